"""From the nodes of a mission file to steps, one by one, so that no fault hides another.

A node with a fault is kept without its faulty parts where that leaves a node, so that what is
below and behind it is looked at too; such a draft is never run.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import pydantic

from bt_mission.core.diagnostics import (
    MOST_FAULTS,
    Diagnostic,
    describe,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.core.yaml.document import Document
from bt_mission.core.yaml.models import model_faults
from bt_mission.language.action_names import BROKEN
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import WORDS, Type, fits, type_of
from bt_mission.language.file import TreeDefinition
from bt_mission.language.goal_limits import GoalLimitsTable
from bt_mission.language.nodes import steps
from bt_mission.language.nodes import written as models
from bt_mission.language.nodes.base import NodeModel, Written
from bt_mission.language.nodes.registry import step_of
from bt_mission.language.nodes.steps import Key, Step
from bt_mission.language.nodes.written import KINDS

NODE = "a node such as 'wait: 2.0'"
TIMEOUT = "timeout"
_LISTS = frozenset({"sequence", "fallback", "parallel", "choose"})
_SINGLES = frozenset({"do", "else", "invert"})

WrittenModel = TypeVar("WrittenModel", bound=Written)


@dataclass(frozen=True)
class Signature:
    """A named tree, as far as those who use it have to know it; `types` are those of its inputs."""

    name: str
    definition: TreeDefinition
    types: Mapping[str, Type | None]
    document: Document
    path: tuple[Key, ...]


@dataclass
class NodeReader:
    """Reads nodes and collects the faults of all.

    `signatures` are the named trees that may be used, `limits` what the mission says of goals.
    `lost` are the outputs of nodes with faults: they have a writer, though none that is kept.
    """

    document: Document
    signatures: Mapping[str, Signature] = field(default_factory=dict)
    limits: GoalLimitsTable = field(default_factory=GoalLimitsTable)
    faults: list[Diagnostic] = field(default_factory=list)
    lost: set[str] = field(default_factory=set)

    def fault(
        self, path: tuple[Key, ...], message: str, hint: str | None = None, *, key: bool = False
    ) -> None:
        """Note a fault at a value or at its key."""
        self.faults.append(self.document.fault(path, message, hint, key=key))

    @property
    def is_full(self) -> bool:
        """Whether there are as many faults as anybody reads."""
        return len(self.faults) >= MOST_FAULTS

    def written(
        self, model: type[WrittenModel], path: tuple[Key, ...], data: Any
    ) -> WrittenModel | None:
        """Return a mapping as a model; its faulty parts are noted and left out."""
        try:
            return model.model_validate(data)
        except pydantic.ValidationError as error:
            self.faults += model_faults(self.document, error, model, path)
            if error.error_count() > MOST_FAULTS:
                return None
            for detail in error.errors(include_url=False):
                data = _without(data, detail["loc"])
        try:
            return model.model_validate(data)
        except pydantic.ValidationError:
            return None

    def node(self, data: Any, path: tuple[Key, ...]) -> Step | None:
        """Return a node and all below it as steps, or None where nothing of it can be kept."""
        if self.is_full:
            return None
        before = len(self.faults)
        kind = self.kind(data, path)
        step = None if kind is None else self.step(kind, data, path)
        if len(self.faults) > before and isinstance(data, dict):
            outputs, values = data.get("outputs"), data.get("set")
            lost = [*outputs.values()] if isinstance(outputs, dict) else []
            lost += values if isinstance(values, dict) else ()
            self.lost.update(name for name in lost if isinstance(name, str))
        return step

    def step(self, kind: str, data: dict[str, Any], path: tuple[Key, ...]) -> Step | None:
        """Return a node of a known kind as a step."""
        model = KINDS[kind]
        known = [name for name in model.model_fields if name != kind]
        for key in data:
            if key not in model.model_fields and not self.is_full:
                message = f"no modifier {quoted(key)} for {kind} (it takes: {listed(known)})"
                self.fault((*path, key), message, did_you_mean(key, known), key=True)
        fields = {key: data[key] for key in data if key in model.model_fields}
        written = self.written(model, path, fields)
        below = [self.node(part, place) for place, part in _children(model, data, path)]
        kept = [step for step in below if step is not None]
        line, column = self.document.position(path)
        common: dict[str, Any] = {
            "name": getattr(written, "name", "") or None,
            "line": line,
            "column": column,
            "path": path,
        }
        if written is not None and len(kept) == len(below):
            return self.built(kind, written, kept, common)
        return steps.SequenceStep(children=tuple(kept), **common) if kept else None

    def built(self, kind: str, written: Any, kept: list[Step], common: dict[str, Any]) -> Step:
        """Return a sound node as a step; note what only its parts together show."""
        if kind == "parallel":
            return self.parallel(written, kept, common)
        if kind == "tree":
            return self.subtree(written, common)
        if kind == "choose" and written.weights and len(written.weights) != len(kept):
            message = f"expected {len(kept)} weights, one a child, got {len(written.weights)}"
            self.fault((*common["path"], "weights"), message)
        return step_of(kind, written, kept, common, self.limits.of)

    def parallel(
        self, written: models.ParallelNode, kept: list[Step], common: dict[str, Any]
    ) -> Step:
        """Return a parallel, the names of children in it replaced by their places."""
        wanted: Any = written.succeed_when
        if not isinstance(wanted, str):
            names = [step.name for step in kept]
            known = [name for name in names if name]
            count = Counter(known)
            # The first of several of a name, which is a fault.
            places = {name: len(names) - 1 - at for at, name in enumerate(reversed(names))}
            wanted = tuple(places[name] for name in wanted if count[name])
            for index, name in enumerate(written.succeed_when):
                if count[name] != 1 and not self.is_full:
                    what = "more than one child" if count[name] else "no child"
                    message = f"{what} is called {quoted(name)} (children with names: "
                    message += f"{listed(known) if known else 'none'})"
                    place = (*common["path"], "succeed_when", index)
                    self.fault(place, message, did_you_mean(name, known))
        return steps.ParallelStep(
            children=tuple(kept),
            succeed_when=wanted,
            fail_when=written.fail_when,
            rest=written.rest,
            **common,
        )

    def subtree(self, written: models.TreeNode, common: dict[str, Any]) -> Step:
        """Return the use of a named tree, compared with what that tree takes and gives."""
        settings, path = written.tree, (*common["path"], "tree")
        inside = (*path, "name") if self.document.find(path).keys else path
        signature = self.signatures.get(settings.name)
        if signature is None:
            known = listed(self.signatures) if self.signatures else "none"
            message = f"no tree is called {quoted(settings.name)} (trees: {known})"
            self.fault(inside, message, did_you_mean(settings.name, self.signatures))
            return steps.SubtreeStep(tree=settings.name, outputs=written.outputs, **common)
        name, definition = signature.name, signature.definition
        for given, value in settings.inputs.items():
            if self.is_full:
                break
            place = (*path, "inputs", given)
            if given not in signature.types:
                known = listed(signature.types) if signature.types else "none"
                message = f"no input {quoted(given)} in {name} (it takes: {known})"
                self.fault(place, message, did_you_mean(given, signature.types), key=True)
            elif not isinstance(value, Expression):
                wanted, got = signature.types[given], type_of(value)
                if wanted is not None and not fits(got, wanted):
                    self.fault(place, f"expected {WORDS[wanted]}, got {describe(value)}")
        missing = [one for one in definition.needs if one not in settings.inputs]
        if missing:
            message = f"{name} needs a value for {listed(missing)}"
            self.fault(inside, message, "give it under 'inputs'")
        for result in written.outputs:
            if result not in definition.outputs and not self.is_full:
                known = listed(definition.outputs) if definition.outputs else "none"
                message = f"no output {quoted(result)} of {name} (it gives: {known})"
                hint = did_you_mean(result, definition.outputs)
                self.fault((*common["path"], "outputs", result), message, hint, key=True)
        return steps.SubtreeStep(
            tree=name,
            inputs=settings.inputs,
            outputs=written.outputs,
            takes=signature.types,
            gives=definition.outputs,
            **common,
        )

    def kind(self, data: Any, path: tuple[Key, ...]) -> str | None:
        """Return the one kind that a node has; note what is wrong where it has not one."""
        if not isinstance(data, dict):
            is_kind = isinstance(data, str) and data in KINDS
            hint = f"write '{data}: ...'" if is_kind else None
            self.fault(path, f"expected {NODE}, got {describe(data)}", hint)
            return None
        kinds: list[str] = [key for key in data if key in KINDS]
        if len(kinds) > 1 and TIMEOUT in kinds:
            kinds.remove(TIMEOUT)  # beside another kind it is that kind's modifier
        if kinds == [TIMEOUT] and "do" not in data and data.keys() - _MODIFIERS - {TIMEOUT}:
            kinds = []  # a modifier of a kind that is misspelt
        if len(kinds) == 1:
            return kinds[0]
        if kinds:
            message = f"two kinds in one node: {quoted(kinds[0])} and {quoted(kinds[1])}"
            hint = "make each an item of its own, with '- ' before it"
            self.fault((*path, kinds[1]), message, hint, key=True)
        elif not data:
            self.fault(path, f"expected {NODE}, got an empty mapping")
        else:
            strange = (key for key in data if key not in _MODIFIERS and key != TIMEOUT)
            key = next(strange, next(iter(data)))
            message = f"no kind of node is called {quoted(key)} (kinds: {listed(KINDS)})"
            hint = did_you_mean(key, KINDS)
            if key in BROKEN:
                message, hint = f"the plug-in {quoted(key)} does not work: {BROKEN[key]}", None
            self.fault((*path, key), message, hint, key=True)
        return None


def _without(data: Any, loc: tuple[Key, ...]) -> Any:
    """Return data without the part at a location, the rest shared."""
    if not loc or not isinstance(data, dict) or loc[0] not in data:
        return data
    key = str(loc[0])
    inner = data[key]
    deeper = len(loc) > 1 and isinstance(inner, dict) and loc[1] in inner
    rest = {name: part for name, part in data.items() if name != key}
    return {**rest, key: _without(inner, loc[1:])} if deeper else rest


_MODIFIERS = frozenset(name for model in KINDS.values() for name in model.model_fields) - {*KINDS}


def _children(
    model: type[NodeModel], data: dict[str, Any], path: tuple[Key, ...]
) -> Iterator[tuple[tuple[Key, ...], Any]]:
    """Yield the nodes directly inside a node, each with its path."""
    for key in model.model_fields:
        if key in _LISTS and isinstance(data.get(key), list):
            for index, part in enumerate(data[key]):
                yield (*path, key, index), part
        elif key in _SINGLES and key in data:
            yield (*path, key), data[key]
