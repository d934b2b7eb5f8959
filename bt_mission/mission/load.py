"""From a mission file to frozen steps, or every fault in it at once. No ROS is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pydantic

from bt_mission.common.faults import Fault, InputError, describe, did_you_mean, listed, quoted
from bt_mission.common.located import Document, model_faults, read
from bt_mission.common.located import read_text as read_yaml
from bt_mission.mission import models, steps
from bt_mission.mission.expressions import Plain
from bt_mission.mission.inputs import overridden
from bt_mission.mission.models import KINDS, SHORT_NAMES
from bt_mission.mission.review import scope_faults, warnings
from bt_mission.mission.steps import Key, Mission, Step

NODE = "a node such as 'wait: 2.0'"


def load(
    path: str | Path,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> Mission:
    """Return the mission in a file. Raises InputError with all its faults.

    `set` gives inputs other values (texts are read as `--set` reads them); `seed`, `world` and
    `robot` replace what the file says. ROS types, worlds and robots are not looked at here:
    that is for `check`.
    """
    return _load(read(path), set, seed, world, robot)


def load_text(
    text: str,
    file: str = "<text>",
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - as in load
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> Mission:
    """Return the mission in a text. Raises InputError with all its faults."""
    return _load(read_yaml(text, file), set, seed, world, robot)


def _load(
    document: Document,
    given: Mapping[str, Plain] | None,
    seed: int | None,
    world: str | None,
    robot: str | None,
) -> Mission:
    loader = _Loader(document)
    written = loader.written(models.MissionFile, (), document.data)
    tree = None
    if isinstance(document.data, dict) and "tree" in document.data:
        tree = loader.node(document.data["tree"], ("tree",))
    if not isinstance(written, models.MissionFile) or tree is None:
        raise loader.failure()
    inputs, faults = overridden(written.inputs, given or {})
    loader.faults += faults
    mission = Mission(
        name=written.mission,
        description=written.description,
        world=world or written.world or None,
        robot=robot or written.robot,
        seed=written.seed if seed is None else seed,
        inputs=inputs,
        tree=tree,
        file=document.file,
        document=document,
    )
    loader.faults += scope_faults(document, mission)
    if loader.faults:
        raise loader.failure()
    return replace(mission, warnings=tuple(warnings(document, mission)))


@dataclass
class _Loader:
    """Reads nodes one by one and collects the faults of all."""

    document: Document
    faults: list[Fault] = field(default_factory=list)

    def failure(self) -> InputError:
        return InputError(sorted(set(self.faults), key=lambda fault: (fault.line, fault.column)))

    def fault(self, *arguments: Any, **options: Any) -> None:
        self.faults.append(self.document.fault(*arguments, **options))

    def written(
        self, model: type[models.Written], path: tuple[Key, ...], data: Any
    ) -> models.Written | None:
        """Return a mapping as a model, or None where it has faults, which are noted."""
        try:
            return model.model_validate(data)
        except pydantic.ValidationError as error:
            self.faults += model_faults(self.document, error, model, path)
            return None

    def node(self, data: Any, path: tuple[Key, ...]) -> Step | None:
        """Return a node and all below it as steps, or None where something in it is wrong."""
        kind = self.kind(data, path)
        if kind is None:
            return None
        model = KINDS[kind]
        unknown = [key for key in data if key not in model.model_fields]
        for key in unknown:
            known = [name for name in model.model_fields if name != kind]
            message = f"no modifier {quoted(key)} for {kind} (it takes: {listed(known)})"
            self.fault((*path, key), message, did_you_mean(key, known), key=True)
        written = self.written(model, path, {key: data[key] for key in data if key not in unknown})
        below = [self.node(part, place) for place, part in _children(data, path)]
        if written is None or None in below:
            return None
        line, column = self.document.position(path)
        common = {
            "name": getattr(written, "name", "") or None,
            "line": line,
            "column": column,
            "path": path,
        }
        return _step(kind, written, [step for step in below if step is not None], common)

    def kind(self, data: Any, path: tuple[Key, ...]) -> str | None:
        """Return the one kind that a node has; note what is wrong where it has not one."""
        if not isinstance(data, dict):
            is_kind = isinstance(data, str) and data in KINDS
            hint = f"write '{data}: ...'" if is_kind else None
            self.fault(path, f"expected {NODE}, got {describe(data)}", hint)
            return None
        kinds: list[str] = [key for key in data if key in KINDS]
        if len(kinds) == 1:
            return kinds[0]
        if kinds:
            message = f"two kinds in one node: {quoted(kinds[0])} and {quoted(kinds[1])}"
            hint = "make each an item of its own, with '- ' before it"
            self.fault((*path, kinds[1]), message, hint, key=True)
        elif not data:
            self.fault(path, f"expected {NODE}, got an empty mapping")
        else:
            key = next((key for key in data if key not in _MODIFIERS), next(iter(data)))
            message = f"no kind of node is called {quoted(key)} (kinds: {listed(KINDS)})"
            self.fault((*path, key), message, did_you_mean(key, KINDS), key=True)
        return None


_MODIFIERS = frozenset(name for model in KINDS.values() for name in model.model_fields) - {*KINDS}


def _children(data: dict[str, Any], path: tuple[Key, ...]) -> Iterator[tuple[tuple[Key, ...], Any]]:
    """Yield the nodes directly inside a node, each with its path."""
    for key in ("sequence", "fallback", "parallel"):
        if isinstance(data.get(key), list):
            for index, part in enumerate(data[key]):
                yield (*path, key, index), part
    if "do" in data and ("repeat" in data or "retry" in data):
        yield (*path, "do"), data["do"]


def _step(kind: str, written: Any, below: list[Step], common: dict[str, Any]) -> Step:
    if kind in SHORT_NAMES:
        return _action(f"/{kind}", SHORT_NAMES[kind], getattr(written, kind), written, common)
    return _BUILD[kind](written, below, common)


def _repeat(written: models.RepeatNode, below: list[Step], common: dict[str, Any]) -> Step:
    return steps.Repeat(child=below[0], count=written.repeat.count, **common)


def _retry(written: models.RetryNode, below: list[Step], common: dict[str, Any]) -> Step:
    settings = written.retry
    return steps.Retry(child=below[0], attempts=settings.attempts, pause=settings.pause, **common)


def _parallel(written: models.ParallelNode, below: list[Step], common: dict[str, Any]) -> Step:
    return steps.Parallel(children=tuple(below), succeed_when=written.succeed_when, **common)


def _action(
    name: str, type_name: str, goal: Mapping[str, Any], written: Any, common: dict[str, Any]
) -> Step:
    modifiers = {key: getattr(written, key) for key in _GOAL_MODIFIERS}
    return steps.Action(action=name, type=type_name, goal=goal, **modifiers, **common)


_GOAL_MODIFIERS = tuple(models.GoalNode.model_fields.keys() - models.Node.model_fields.keys())


_BUILD: dict[str, Callable[[Any, list[Step], dict[str, Any]], Step]] = {
    "sequence": lambda written, below, common: steps.Sequence(
        children=tuple(below), memory=written.memory, **common
    ),
    "fallback": lambda written, below, common: steps.Fallback(
        children=tuple(below), memory=written.memory, **common
    ),
    "parallel": _parallel,
    "repeat": _repeat,
    "retry": _retry,
    "wait": lambda written, _below, common: steps.Wait(seconds=written.wait, **common),
    "log": lambda written, _below, common: steps.Log(message=written.log, **common),
    "action": lambda written, _below, common: _action(
        written.action.name, written.action.type, written.action.goal, written, common
    ),
}
