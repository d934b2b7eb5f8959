"""The requirements of a mission: the nodes and variables that they name, and separate files."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from typing_extensions import override

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, listed, quoted
from bt_mission.base.yaml.document import Document, Key, read
from bt_mission.language.checks.scope import written_by
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Mission, Requirement
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.trees import used
from bt_mission.requirements.language.formula import Clause, signals_in
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.written import RequirementsFile, requirements_of

_PLACE = re.compile(r"[0-9]+(\.[0-9]+)*")
"""The place of a node in its tree, which may stand instead of its name."""


def with_requirements(mission: Mission, paths: Sequence[str | Path]) -> Mission:
    """Return a mission with the requirements of further files.

    Raises:
        InputError: With all their errors.
    """
    known = {requirement.name for requirement in mission.requirements}
    more = read_requirements(paths, MissionNames(mission), known)
    return replace(mission, requirements=(*mission.requirements, *more))


def read_requirements(
    paths: Sequence[str | Path], names: RequirementNames, known: Collection[str] = ()
) -> tuple[Requirement, ...]:
    """Return the requirements of files, also of missions.

    Args:
        names: What they can name.
        known: The names of requirements that there are already.

    Raises:
        InputError: With all their errors.
    """
    requirements: list[Requirement] = []
    diagnostics: list[Diagnostic] = []
    for path in paths:
        document = read(path)
        reader = NodeReader(document)
        written = reader.written(RequirementsFile, (), _requirements_in(document))
        diagnostics += reader.diagnostics
        if written is None:
            continue
        diagnostics += diagnostics_of_names(document, names)
        for name in written.requirements.keys() & {
            *known,
            *(requirement.name for requirement in requirements),
        }:
            message = f"the requirement {quoted(name)} already exists"
            diagnostics.append(
                document.diagnostic("BT-208", ("requirements", name), message, key=True)
            )
        requirements += requirements_of(written.requirements)
    if diagnostics:
        raise InputError(diagnostics)
    return tuple(requirements)


def _requirements_in(document: Document) -> Any:
    """Return what a file of requirements has; of a mission, only its requirements."""
    data = document.data
    is_mission = isinstance(data, dict) and "mission" in data and "tree" in data
    return {key: data[key] for key in data if key == "requirements"} if is_mission else data


def requirement_diagnostics(mission: Mission, lost: Collection[str] = ()) -> Iterator[Diagnostic]:
    """Yield the nodes and variables that are named in requirements and are not in the mission.

    Args:
        lost: Names of nodes that could not be read, which other errors report.
    """
    return diagnostics_of_names(mission.document, MissionNames(mission, lost))


def diagnostics_of_names(document: Document, names: RequirementNames) -> Iterator[Diagnostic]:
    """Yield what the requirements of a file name, and is not there."""
    for path, root in _formulas(document):
        for error in names.unknown_in(root):
            offset = error.column - 1
            yield document.diagnostic(error.code, path, error.message, error.hint, offset=offset)


class RequirementNames:
    """The nodes and variables that formulas and conditions may name.

    Args:
        nodes: Names of nodes, each with whether such a node has a goal. None where they are not
            known, and any name is valid; so for the others.
        places: The same of the places of nodes in their tree, such as ``0.1``.
        variables: Without their `$`.
    """

    def __init__(
        self,
        nodes: Mapping[str, bool] | None = None,
        places: Mapping[str, bool] | None = None,
        variables: Collection[str] | None = None,
    ) -> None:
        self._nodes, self._places, self._variables = nodes, places or {}, variables

    def lacks(self, node: str) -> bool:
        """Return whether no node has this name, or stands at this place."""
        return self._nodes is not None and self._has_goal(node) is None

    def near(self, node: str) -> str | None:
        """Return "did you mean 'x'?" for the nearest name of a node."""
        return did_you_mean(node, self._nodes or ())

    def unknown_in(self, root: SyntaxNode) -> Iterator[ExpressionError]:
        """Yield an error for each node or variable that is not there."""
        for signal in signals_in(root):
            defined, name = self._variables, signal.arguments[0] if signal.arguments else ""
            if signal.name == "$" and defined is not None and name not in defined:
                message = f"'${name}' is an undefined variable (defined: {listed(defined)})"
                yield ExpressionError("BT-603", message, signal.column, did_you_mean(name, defined))
            known = SIGNALS.get(signal.name)
            if known is not None and "node" in known.arguments and self._nodes is not None:
                yield from self._unknown_node(name, signal.column, needs_goal=known.is_of_goal)

    def _unknown_node(
        self, name: str, column: int, *, needs_goal: bool
    ) -> Iterator[ExpressionError]:
        has_goal = self._has_goal(name)
        if has_goal or (has_goal is not None and not needs_goal):
            return
        nodes = self._nodes or {}
        wanted = sorted(label for label, acts in nodes.items() if acts or not needs_goal)
        what = "node" if has_goal is None else "node with a goal"
        message = f"unknown {what}: {quoted(name)} (known: {listed(wanted, 12)})"
        yield ExpressionError(
            "BT-603", message, column, self._hint(name) or did_you_mean(name, wanted)
        )

    def _has_goal(self, node: str) -> bool | None:
        """Return whether a node has a goal; None where there is no such node."""
        return (self._nodes or {}).get(node, self._places.get(node))

    def _hint(self, _node: str) -> str | None:
        return None


class MissionNames(RequirementNames):
    """The nodes of a mission's run, and its variables."""

    def __init__(self, mission: Mission, lost: Collection[str] = ()) -> None:
        self._mission = mission
        nodes = dict.fromkeys(lost, True)
        for body in (mission.root, *(mission.trees[name].body for name in used(mission))):
            for node in body.walk():
                nodes[node.label] = nodes.get(node.label, False) or isinstance(node, GoalNode)
        variables = {
            *mission.inputs,
            *(followed.variable for followed in mission.follow),
            *(name for node in mission.tree.walk() for name in written_by(node)),
        }
        super().__init__(nodes, variables=variables)

    @override
    def _has_goal(self, node: str) -> bool | None:
        known = super()._has_goal(node)
        if known is None and _PLACE.fullmatch(node):
            at = self._mission.node_at(node)
            return None if at is None else isinstance(at, GoalNode)
        return known

    @override
    def _hint(self, node: str) -> str | None:
        mission = self._mission
        is_renamed = mission.root is not mission.tree and node == mission.tree.label
        return f"the root has the mission's name: {quoted(mission.name)}" if is_renamed else None


def _formulas(document: Document) -> Iterator[tuple[tuple[Key, ...], SyntaxNode]]:
    """Yield the texts of all requirements that can be read, each with its place."""
    written = document.data.get("requirements")
    for name, form in written.items() if isinstance(written, dict) else ():
        parts = form if isinstance(form, dict) else {None: form}
        for key in (None, "formula", "whenever", "then"):
            text = parts.get(key)
            if not isinstance(text, str):
                continue
            with suppress(ExpressionError):
                yield ("requirements", name, *([key] if key else [])), Clause(text).root
