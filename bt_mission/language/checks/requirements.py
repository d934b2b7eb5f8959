"""The requirements of a mission: the nodes and variables that they name, and files of their own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from bt_mission.core.diagnostics import Diagnostic, InputError, did_you_mean, listed, quoted
from bt_mission.core.yaml.document import Document, Key, read
from bt_mission.language.checks.scope import written_by
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Mission
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.requirements.formula import Clause, signals_in
from bt_mission.language.requirements.signals import SIGNALS
from bt_mission.language.requirements.written import RequirementsFile, requirements_of

_PLACE = re.compile(r"[0-9]+(\.[0-9]+)*")
"""The place of a node in its tree, which may stand instead of its name."""


def with_requirements(mission: Mission, paths: Sequence[str | Path]) -> Mission:
    """Return a mission with the requirements of further files.

    Raises:
        InputError: With everything that is wrong with them.
    """
    found = list(mission.requirements)
    faults: list[Diagnostic] = []
    for path in paths:
        document = read(path)
        reader = NodeReader(document)
        written = reader.written(RequirementsFile, (), document.data)
        faults += reader.faults
        if written is None:
            continue
        faults += requirement_faults(mission, document)
        known = {one.name for one in found}
        for name in written.requirements.keys() & known:
            message = f"there is a requirement {quoted(name)} already"
            faults.append(document.fault(("requirements", name), message, key=True))
        found += requirements_of(written.requirements)
    if faults:
        raise InputError(faults)
    return replace(mission, requirements=tuple(found))


def requirement_faults(mission: Mission, document: Document | None = None) -> Iterator[Diagnostic]:
    """Yield the nodes and variables that are named in requirements and are not in the mission."""
    document = document or mission.document
    assert document is not None, "a mission to check comes from a file or a string"
    names = MissionNames(mission)
    for path, root in _formulas(document):
        for error in names.unknown_in(root):
            offset = error.column - 1
            yield document.fault(path, error.message, error.hint, offset=offset)


class MissionNames:
    """The nodes and variables of a mission, which formulas and conditions may name."""

    def __init__(self, mission: Mission) -> None:
        nodes = [node for tree in mission.all_trees for node in tree.body.walk()]
        self._nodes = {node.label for node in nodes}
        self._acting = {node.label for node in nodes if isinstance(node, GoalNode)}
        self._variables = {
            *mission.inputs,
            *(one.variable for one in mission.follow),
            *(name for node in mission.tree.walk() for name in written_by(node)),
        }

    def lacks(self, node: str) -> bool:
        """Return whether no node has this name, or stands at this place."""
        return node not in self._nodes and not _PLACE.fullmatch(node)

    def near(self, node: str) -> str | None:
        """Return "did you mean 'x'?" for the nearest name of a node."""
        return did_you_mean(node, self._nodes)

    def unknown_in(self, root: SyntaxNode) -> Iterator[ExpressionError]:
        """Yield an error for each node or variable that is not in the mission."""
        for signal in signals_in(root):
            if signal.name == "$" and signal.arguments[0] not in self._variables:
                name, defined = signal.arguments[0], self._variables
                message = f"'${name}' is an undefined variable (defined: {listed(defined)})"
                yield ExpressionError(message, signal.column, did_you_mean(name, defined))
            if signal.name not in SIGNALS or "node" not in SIGNALS[signal.name].arguments:
                continue
            node = signal.arguments[0]
            wanted = self._acting if signal.name == "feedback" else self._nodes
            if node in wanted or _PLACE.fullmatch(node):
                continue
            what = "node has a goal and is" if node in self._nodes else "node is"
            message = f"no {what} named {quoted(node)} (named: {listed(sorted(wanted), 12)})"
            yield ExpressionError(message, signal.column, did_you_mean(node, wanted))


def _formulas(document: Document) -> Iterator[tuple[tuple[Key, ...], SyntaxNode]]:
    """Yield the texts of all requirements that can be read, each with its place."""
    written = document.data.get("requirements")
    for name, one in written.items() if isinstance(written, dict) else ():
        parts = one if isinstance(one, dict) else {None: one}
        for key in (None, "formula", "whenever", "then"):
            text = parts.get(key)
            if not isinstance(text, str):
                continue
            with suppress(ExpressionError):
                yield ("requirements", name, *([key] if key else [])), Clause(text).root
