"""Defects by mutation, of missions and of the servers' methods, for the benchmark of the search."""

from __future__ import annotations

import ast
import inspect
import random
import re
import textwrap
from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

import pytest

from action_servers.core import checks, pilot
from action_servers.driving import drive, explore_forward, straight, turn
from bt_mission.core.yaml.document import read_text
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.goals import attempt

DROPPED = ("timeout", "feedback_timeout", "acceptance_timeout", "cancel_when", "on_cancel")
FLIPS = {">=": "<", "<=": ">", ">": "<=", "<": ">=", " and ": " or "}

METHODS = (
    (explore_forward.ExploreForward, ("step", "feedback", "_look", "_gap")),
    (turn.Turn, ("step", "feedback")),
    (turn.Rotation, ("towards", "_look")),
    (straight.Straight, ("step",)),
    (drive.DriveGuard, ("speed_ahead", "_age_s", "held_back")),
    (drive.Way, ("blocked",)),
    (pilot.Pilot, ("_end", "cancel")),
    (attempt.Attempt, ("_check_feedback", "_check_limits")),
    (checks, ("_fault",)),
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
            signs = [one for one in FLIPS if one in value]
            yield from (value.replace(one, FLIPS[one], 1) for one in signs[:1])
            for found in re.finditer(r"(?<![\w.])\d+(?:\.\d+)?", value):
                half = f"{float(found[0]) / 2:g}"
                yield value[: found.start()] + half + value[found.end() :]


class _Mutation(ast.NodeTransformer):
    """Changes the node of a number, and counts all that can be changed."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.count = 0
        self.what = ""

    def visit(self, node: ast.AST) -> Any:
        changed = _changed(node)
        if changed is not None:
            self.count += 1
            if self.count - 1 == self.number:
                self.what = f"{ast.unparse(node)} -> {ast.unparse(changed)}"
                return ast.copy_location(changed, node)
        return self.generic_visit(node)


_OPPOSITES: dict[type[ast.AST], Any] = {
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
}


def _changed(node: ast.AST) -> Any:
    match node:
        case ast.Compare(left=left, ops=[op], comparators=parts) if type(op) in _OPPOSITES:
            return ast.Compare(left, [_OPPOSITES[type(op)]()], parts)
        case ast.BoolOp(op=op, values=values):
            return ast.BoolOp(_OPPOSITES[type(op)](), values)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPPOSITES:
            return ast.BinOp(left, _OPPOSITES[type(op)](), right)
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            return operand
        case ast.Constant(value=float() as value) if value:
            return ast.Constant(2 * value)
    return None


Plant = Callable[[pytest.MonkeyPatch], object]


def server_mutants(seed: int) -> Iterator[tuple[str, Plant]]:
    """Yield what was changed in a method, and what plants it, in a drawn order."""
    found: list[tuple[Any, str, int]] = []
    for owner, names in METHODS:
        for name in names:
            if hasattr(owner, name):
                counter = _Mutation(-1)
                counter.visit(_tree(owner, name))
                found += [(owner, name, number) for number in range(counter.count)]
    random.Random(seed).shuffle(found)
    for owner, name, number in found:
        mutation = _Mutation(number)
        tree = ast.fix_missing_locations(mutation.visit(_tree(owner, name)))
        module = inspect.getmodule(getattr(owner, name))
        space: dict[str, Any] = {}
        exec(compile(tree, "<mutant>", "exec"), vars(module), space)  # noqa: S102 - our own code
        what = f"{getattr(owner, '__name__', owner)}.{name}: {mutation.what}"
        yield what, lambda patch, o=owner, n=name, m=space[name]: patch.setattr(o, n, m)


def _tree(owner: Any, name: str) -> ast.Module:
    return ast.parse(textwrap.dedent(inspect.getsource(getattr(owner, name))))
