"""Missions of all kinds of nodes that drive, turn, wait and look, and end in bounded time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bt_mission.scenarios.draws import Draws, maybe, number, one_of

DEEPEST = 3
MOST_CHILDREN = 3
MOST_PARTS = 8
"""The mission continues if one of them except the last fails."""
LIMIT_S = 12.0
"""On every goal."""

Node = dict[str, Any]


def drawn_mission(draws: Draws) -> dict[str, Any]:
    """A valid mission, as data of a mission file."""
    parts = [_node(draws, DEEPEST) for _ in range(draws.whole(1, MOST_PARTS))]
    return {
        "mission": "drawn",
        "inputs": {"speed": number(draws, 0.1, 0.25, 0.05)},
        "tree": {
            "sequence": [
                {"set": {"n": 1}},
                *({"force": "success", "do": part} for part in parts[:-1]),
                parts[-1],
            ]
        },
    }


def _node(draws: Draws, depth: int) -> Node:
    if depth == 0 or draws.whole(0, 2) == 0:
        return one_of(draws, _LEAVES)(draws)
    return one_of(draws, _BRANCHES)(draws, depth - 1)


def _children(draws: Draws, depth: int) -> list[Node]:
    return [_node(draws, depth) for _ in range(draws.whole(1, MOST_CHILDREN))]


def _explore(draws: Draws) -> Node:
    fields = {"fwd_velocity": "$speed", "stopping_distance": number(draws, 0.2, 0.6, 0.1)}
    node = {"explore_forward": fields, **_limit(draws)}
    if maybe(draws, 2):
        node["cancel_when"] = f"current_distance_travelled > {number(draws, 0.2, 1.0, 0.2)}"
        node["on_cancel"] = "success"
    return node


def _turn(draws: Draws) -> Node:
    angle: Any = number(draws, -180, 180, 15)
    if maybe(draws, 3):
        angle = "uniform(-90, 90)"
    return {"turn": {"angle": angle}, **_limit(draws)}


def _move(draws: Draws) -> Node:
    fields = {
        "secs": draws.whole(1, 3),
        "linear_velocity": number(draws, -0.1, 0.2, 0.05),
        "angular_velocity": number(draws, -0.5, 0.5, 0.25),
    }
    return {"move": fields, **_limit(draws)}


def _wait(draws: Draws) -> Node:
    return {"wait": number(draws, 0, 2, 0.25)}


def _limit(draws: Draws) -> Node:
    return {"timeout": number(draws, 2, LIMIT_S, 1)}


# Python evaluates the parts of each of these from left to right, which is the order of the draws.
_LEAVES: tuple[Callable[[Draws], Node], ...] = (
    _wait,
    _turn,
    _explore,
    _move,
    lambda draws: {"spin": {"target_yaw": number(draws, -3, 3, 0.5)}, **_limit(draws)},
    lambda _: {"log": "n is $n"},
    lambda _: {"set": {"n": "n + 1"}},
    lambda draws: {"check": f"n > {draws.whole(0, 3)}"},
)


def _parallel(draws: Draws, depth: int) -> Node:
    beside = [_wait(draws), _node(draws, depth)]
    return {"parallel": beside, "succeed_when": one_of(draws, ("all", "any"))}


def _retry(draws: Draws, depth: int) -> Node:
    pause = number(draws, 0, 1, 0.25)
    return {"retry": {"attempts": draws.whole(1, 2), "pause": pause}, "do": _node(draws, depth)}


def _for_each(draws: Draws, depth: int) -> Node:
    values = [draws.whole(0, 3) for _ in range(draws.whole(1, 2))]
    return {"for_each": {f"one_{depth}": values}, "do": _node(draws, depth)}


def _around(head: Callable[[Draws], Node]) -> Callable[[Draws, int], Node]:
    """Return what draws a decorator, and then what it is around."""
    return lambda draws, depth: {**head(draws), "do": _node(draws, depth)}


_BRANCHES: tuple[Callable[[Draws, int], Node], ...] = (
    lambda draws, depth: {"sequence": _children(draws, depth)},
    lambda draws, depth: {"fallback": _children(draws, depth)},
    _parallel,
    _around(lambda draws: {"repeat": {"count": draws.whole(1, 2)}}),
    _retry,
    _around(lambda draws: {"timeout": number(draws, 1, LIMIT_S, 1)}),
    _around(lambda draws: {"force": one_of(draws, ("success", "failure"))}),
    lambda draws, depth: {"invert": _node(draws, depth)},
    lambda draws, depth: {"choose": _children(draws, depth)},
    _around(lambda draws: {"when": f"n > {draws.whole(0, 2)}"}),
    _around(lambda draws: {"guard": f"n < {draws.whole(1, 4)}"}),
    _for_each,
)
