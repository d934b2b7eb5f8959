"""Defects by mutation, of missions and of the servers' methods, for the benchmark of the search."""

from __future__ import annotations

import ast
import inspect
import random
import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from action_servers.core import checks, governor, pilot
from action_servers.driving import drive, explore_forward, straight, turn
from bt_mission.core.yaml.document import read_text
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.goals import attempt
from tools.mutations import Place, places_of

ROOT = Path(__file__).resolve().parent.parent

DROPPED = ("timeout", "feedback_timeout", "acceptance_timeout", "cancel_when", "on_cancel")
FLIPS = {">=": "<", "<=": ">", ">": "<=", "<": ">=", " and ": " or "}

METHODS = (
    (explore_forward.ExploreForward, ("step", "feedback", "_look", "_gap")),
    (turn.Turn, ("step", "feedback")),
    (turn.Rotation, ("towards",)),
    (straight.Straight, ("step",)),
    (drive.Drive, ("speed_ahead",)),
    (governor.Governor, ("look", "allow")),
    (governor.Room, ("allow",)),
    (pilot.Pilot, ("_end", "cancel")),
    (attempt.Attempt, ("_check_feedback", "_check_limits")),
    (checks, ("overdue",)),
)
"""What is mutated of the servers and of the goals of the executive."""


def mission_mutants(text: str, seed: int) -> Iterator[tuple[str, str]]:
    """Yield what was changed in a mission, and the mission, in a drawn order."""
    data = read_text(text).data
    places = list(_places(data["tree"], ("tree",)))
    random.Random(seed).shuffle(places)
    for what, path, change in places:
        other = deepcopy(data)
        owner: Any = other
        for key in path:
            owner = owner[key]
        change(owner)
        yield f"{'/'.join(map(str, path))}: {what}", to_yaml(other)


Change = Callable[[Any], None]


def _places(node: Any, path: tuple[Any, ...]) -> Iterator[tuple[str, tuple[Any, ...], Change]]:
    if isinstance(node, list):
        for number in range(len(node)):
            if len(node) > 1:
                yield f"without part {number + 1}", path, lambda it, n=number: it.pop(n)
        if len(node) > 1:
            yield "reversed", path, lambda it: it.reverse()
        for number, part in enumerate(node):
            yield from _places(part, (*path, number))
    elif isinstance(node, dict):
        for key, value in node.items():
            yield from _of_key(key, value, path)
            yield from _places(value, (*path, key))


def _of_key(
    key: str, value: Any, path: tuple[Any, ...]
) -> Iterator[tuple[str, tuple[Any, ...], Change]]:
    def becomes(other: Any) -> Change:
        return lambda it: it.update({key: other})

    if key in DROPPED:
        yield f"no {key}", path, lambda it: it.pop(key)
    for other in _others(value):
        yield f"{key} {other}", path, becomes(other)
    if key in ("sequence", "fallback"):
        swapped = "fallback" if key == "sequence" else "sequence"
        yield f"{swapped} for {key}", path, lambda it: it.update({swapped: it.pop(key)})


def _others(value: Any) -> Iterator[Any]:
    """Yield other values of a kind."""
    match value:
        case bool():
            yield not value
        case int():
            yield from (value * 2, value // 2)
        case float():
            yield from (value * 2, value / 2)
        case str():
            signs = [flip for flip in FLIPS if flip in value]
            yield from (value.replace(sign, FLIPS[sign], 1) for sign in signs[:1])
            for number in re.finditer(r"(?<![\w.])\d+(?:\.\d+)?", value):
                half = f"{float(number[0]) / 2:g}"
                yield value[: number.start()] + half + value[number.end() :]


Plant = Callable[[pytest.MonkeyPatch], object]


def server_mutants(seed: int) -> Iterator[tuple[str, Plant]]:
    """Yield what was changed in a method, and what plants it, in a drawn order."""
    candidates: list[tuple[Any, Any, Place]] = []
    for owner, names in METHODS:
        module = owner if inspect.ismodule(owner) else inspect.getmodule(owner)
        prefix = "" if owner is module else f"{owner.__name__}."
        wanted = {prefix + name for name in names}
        every = places_of(Path(str(module.__file__)), ROOT)
        candidates += [(owner, module, place) for place in every if place.function in wanted]
    random.Random(seed).shuffle(candidates)
    for owner, module, place in candidates:
        body: list[Any] = ast.parse(place.planted(Path(module.__file__).read_bytes())).body
        method: Any = None
        for name in place.function.split("."):
            method = next(member for member in body if getattr(member, "name", "") == name)
            body = method.body
        space: dict[str, Any] = {}
        code = compile(ast.Module([method], []), "<mutant>", "exec")
        exec(code, vars(module), space)  # noqa: S102 - our own code
        what = f"{place.function}: {place.before} -> {place.after}"
        yield what, partial(_plant, owner, method.name, space[method.name])


def _plant(owner: Any, name: str, mutant: Any, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(owner, name, mutant)
