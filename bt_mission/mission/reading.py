"""From the nodes of a mission file to steps, one by one, so that no fault hides another.

A node with a fault is kept without its faulty parts where that leaves a node, so that what is
below and behind it is looked at too; such a draft is never run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import pydantic

from bt_mission.common.faults import MOST_FAULTS, Fault, describe, did_you_mean, listed, quoted
from bt_mission.common.located import Document, model_faults
from bt_mission.mission import models, steps
from bt_mission.mission.models import KINDS
from bt_mission.mission.short_names import SHORT_NAMES
from bt_mission.mission.steps import Key, Step

NODE = "a node such as 'wait: 2.0'"
TIMEOUT = "timeout"
_LISTS = frozenset({"sequence", "fallback", "parallel", "choose"})
_SINGLES = frozenset({"do", "else", "invert"})

WrittenModel = TypeVar("WrittenModel", bound=models.Written)


@dataclass
class Reader:
    """Reads nodes and collects the faults of all.

    `lost` are the outputs of nodes with faults: they have a writer, though none that is kept.
    """

    document: Document
    faults: list[Fault] = field(default_factory=list)
    lost: set[str] = field(default_factory=set)

    def fault(
        self, path: tuple[Key, ...], message: str, hint: str | None = None, *, key: bool = False
    ) -> None:
        """Note a fault at a value or at its key."""
        self.faults.append(self.document.fault(path, message, hint, key=key))

    def written(
        self, model: type[WrittenModel], path: tuple[Key, ...], data: Any
    ) -> WrittenModel | None:
        """Return a mapping as a model; its faulty parts are noted and left out."""
        try:
            return model.model_validate(data)
        except pydantic.ValidationError as error:
            self.faults += model_faults(self.document, error, model, path)
            for detail in error.errors(include_url=False)[:MOST_FAULTS]:
                data = _without(data, detail["loc"])
        try:
            return model.model_validate(data)
        except pydantic.ValidationError:
            return None

    def node(self, data: Any, path: tuple[Key, ...]) -> Step | None:
        """Return a node and all below it as steps, or None where nothing of it can be kept."""
        before = len(self.faults)
        if before >= MOST_FAULTS:
            return None
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
            if key not in model.model_fields and len(self.faults) < MOST_FAULTS:
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
        return steps.Sequence(children=tuple(kept), **common) if kept else None

    def built(self, kind: str, written: Any, kept: list[Step], common: dict[str, Any]) -> Step:
        """Return a sound node as a step; note what only its parts together show."""
        if kind == "parallel":
            return self.parallel(written, kept, common)
        if kind == "choose" and written.weights and len(written.weights) != len(kept):
            message = f"expected {len(kept)} weights, one a child, got {len(written.weights)}"
            self.fault((*common["path"], "weights"), message)
        return _step(kind, written, kept, common)

    def parallel(
        self, written: models.ParallelNode, kept: list[Step], common: dict[str, Any]
    ) -> Step:
        """Return a parallel, the names of children in it replaced by their places."""
        wanted: Any = written.succeed_when
        if not isinstance(wanted, str):
            names = [step.name for step in kept]
            wanted = tuple(names.index(name) for name in wanted if name in names)
            for index, name in enumerate(written.succeed_when):
                if names.count(name) != 1:
                    known = [known for known in names if known]
                    what = "no child" if name not in names else "more than one child"
                    message = f"{what} is called {quoted(name)} (children with names: "
                    message += f"{listed(known) if known else 'none'})"
                    place = (*common["path"], "succeed_when", index)
                    self.fault(place, message, did_you_mean(name, known))
        return steps.Parallel(
            children=tuple(kept),
            succeed_when=wanted,
            fail_when=written.fail_when,
            rest=written.rest,
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
            self.fault((*path, key), message, did_you_mean(key, KINDS), key=True)
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
    model: type[models.Node], data: dict[str, Any], path: tuple[Key, ...]
) -> Iterator[tuple[tuple[Key, ...], Any]]:
    """Yield the nodes directly inside a node, each with its path."""
    for key in model.model_fields:
        if key in _LISTS and isinstance(data.get(key), list):
            for index, part in enumerate(data[key]):
                yield (*path, key, index), part
        elif key in _SINGLES and key in data:
            yield (*path, key), data[key]


def _step(kind: str, written: Any, below: list[Step], common: dict[str, Any]) -> Step:
    if kind in SHORT_NAMES:
        short = SHORT_NAMES[kind]
        return _action(short.action, short.type, getattr(written, kind), written, common)
    return _BUILD[kind](written, below, common)


def _repeat(written: models.RepeatNode, below: list[Step], common: dict[str, Any]) -> Step:
    return steps.Repeat(child=below[0], count=written.repeat.count, **common)


def _retry(written: models.RetryNode, below: list[Step], common: dict[str, Any]) -> Step:
    settings = written.retry
    return steps.Retry(child=below[0], attempts=settings.attempts, pause=settings.pause, **common)


def _for_each(written: models.ForEachNode, below: list[Step], common: dict[str, Any]) -> Step:
    ((variable, elements),) = written.for_each.items()
    return steps.ForEach(child=below[0], variable=variable, elements=elements, **common)


def _action(
    name: str, type_name: str, goal: Mapping[str, Any], written: Any, common: dict[str, Any]
) -> Step:
    modifiers = {key: getattr(written, key) for key in _GOAL_MODIFIERS}
    return steps.Action(action=name, type=type_name, goal=goal, **modifiers, **common)


def _service(written: models.ServiceNode, _: list[Step], common: dict[str, Any]) -> Step:
    settings = written.service
    return steps.Service(
        service=settings.name,
        type=settings.type,
        request=settings.request,
        timeout=written.timeout,
        server_timeout=written.server_timeout,
        outputs=written.outputs,
        **common,
    )


def _wait_for(written: models.WaitForNode, _: list[Step], common: dict[str, Any]) -> Step:
    settings = written.wait_for
    return steps.WaitFor(
        topic=settings.topic,
        type=settings.type,
        until=settings.until,
        timeout=written.timeout,
        outputs=written.outputs,
        **common,
    )


_GOAL_MODIFIERS = tuple(models.GoalNode.model_fields.keys() - models.Node.model_fields.keys())


_BUILD: dict[str, Callable[[Any, list[Step], dict[str, Any]], Step]] = {
    "sequence": lambda written, below, common: steps.Sequence(
        children=tuple(below), memory=written.memory, **common
    ),
    "fallback": lambda written, below, common: steps.Fallback(
        children=tuple(below), memory=written.memory, **common
    ),
    "choose": lambda written, below, common: steps.Choose(
        children=tuple(below), weights=tuple(written.weights), **common
    ),
    "timeout": lambda written, below, common: steps.Timeout(
        child=below[0], seconds=written.timeout, **common
    ),
    "invert": lambda _written, below, common: steps.Invert(child=below[0], **common),
    "force": lambda written, below, common: steps.Force(
        child=below[0], status=written.force, **common
    ),
    "guard": lambda written, below, common: steps.Guard(
        child=below[0], condition=written.guard, **common
    ),
    "when": lambda written, below, common: steps.When(
        children=tuple(below), condition=written.when, **common
    ),
    "for_each": _for_each,
    "check": lambda written, _below, common: steps.Check(condition=written.check, **common),
    "set": lambda written, _below, common: steps.Set(values=written.set, **common),
    "repeat": _repeat,
    "retry": _retry,
    "wait": lambda written, _below, common: steps.Wait(seconds=written.wait, **common),
    "log": lambda written, _below, common: steps.Log(message=written.log, **common),
    "action": lambda written, _below, common: _action(
        written.action.name, written.action.type, written.action.goal, written, common
    ),
    "service": _service,
    "wait_for": _wait_for,
}
