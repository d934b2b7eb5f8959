"""The signals that requirements speak of: their types, units and ranges, and who knows them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from bt_mission.base.actions import GOALS_AT
from bt_mission.base.units import Dimension
from bt_mission.language.expressions.values import Type
from bt_mission.language.outcome import CANCELED, Outcome

Knows = Literal["simulator", "odometry", "topic", "mission"]
"""Sources of a signal: only a simulation; a simulation, and odometry on a robot; a topic; or the
executive."""


@dataclass(frozen=True)
class Signal:
    """One signal.

    Attributes:
        text: What it is, for people, with its unit.
        type: Of its value; None where a message decides.
        unit: None where it is not known.
        range: From where to where its number can go.
        known_by: Its source.
        arguments: Those in its parentheses; without any it is written without them.
        is_of_goal: Does it need a node that sends goals?
    """

    text: str
    type: Type | None = "number"
    unit: Dimension | None = (0, 0, 0)
    range: tuple[float, float] = (-math.inf, math.inf)
    known_by: Knows = "simulator"
    arguments: tuple[str, ...] = ()
    is_of_goal: bool = False


_M, _S, _RAD, _MPS, _RADPS = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, -1, 0), (0, -1, 1)
_POSITIVE = (0.0, math.inf)

SIGNALS: Mapping[str, Signal] = {
    "time": Signal("since the mission's start, s", unit=_S, range=_POSITIVE, known_by="mission"),
    "x": Signal("true x in the map, m", unit=_M),
    "y": Signal("true y in the map, m", unit=_M),
    "yaw": Signal("true heading in the map, rad", unit=_RAD, range=(-math.pi, math.pi)),
    "clearance": Signal("true room to the nearest thing, m; below 0 inside it", unit=_M),
    "nearest": Signal("name of the nearest thing", type="text"),
    "collisions": Signal("how often the robot has touched something", "integer", range=_POSITIVE),
    "speed": Signal("speed ahead, m/s", unit=_MPS, known_by="odometry"),
    "turn_rate": Signal("turn rate to the left, rad/s", unit=_RADPS, known_by="odometry"),
    "distance": Signal("length of the path, m", unit=_M, range=_POSITIVE, known_by="odometry"),
    "odometry.x": Signal("x by odometry, m", unit=_M, known_by="topic"),
    "odometry.y": Signal("y by odometry, m", unit=_M, known_by="topic"),
    "odometry.yaw": Signal(
        "heading by odometry, rad", unit=_RAD, range=(-math.pi, math.pi), known_by="topic"
    ),
    "scan_clearance": Signal(
        "smallest range of the newest scan, m, from the lidar",
        unit=_M,
        range=_POSITIVE,
        known_by="topic",
    ),
    "battery": Signal(
        "charge of the battery as its topic has it, of a TurtleBot3 in percent",
        range=_POSITIVE,
        known_by="topic",
    ),
    "age": Signal(
        "since the newest message of a topic, s; before the first, since the start",
        unit=_S,
        range=_POSITIVE,
        known_by="topic",
        arguments=("topic",),
    ),
    "topic": Signal(
        "field of the newest message of a topic",
        type=None,
        unit=None,
        known_by="topic",
        arguments=("topic", "field"),
    ),
    "feedback": Signal(
        "field of the newest feedback of a node's present goal",
        type=None,
        unit=None,
        known_by="mission",
        arguments=("node", "field"),
        is_of_goal=True,
    ),
    "open_goals": Signal(
        "goals that were sent and have not ended", "integer", range=_POSITIVE, known_by="mission"
    ),
    **{
        name: Signal(
            f"goals that move the {part}, were sent and have not ended",
            "integer",
            range=_POSITIVE,
            known_by="mission",
        )
        for name, part in GOALS_AT.items()
    },
    "accepted": Signal(
        "the server has accepted a node's newest goal",
        "bool",
        None,
        known_by="mission",
        arguments=("node",),
        is_of_goal=True,
    ),
    "outcome": Signal(
        "a node's newest goal has ended in this way",
        "bool",
        None,
        known_by="mission",
        arguments=("node",),
        is_of_goal=True,
    ),
    "running": Signal("a node runs", "bool", None, known_by="mission", arguments=("node",)),
    "succeeded": Signal(
        "a node has ended well, and not been entered again",
        "bool",
        None,
        known_by="mission",
        arguments=("node",),
    ),
    "failed": Signal(
        "a node has failed, and not been entered again",
        "bool",
        None,
        known_by="mission",
        arguments=("node",),
    ),
}
"""Every signal by its name; `$name` is a variable of the mission besides."""

OUTCOME = "outcome"
OUTCOMES = (CANCELED, *(str(outcome) for outcome in Outcome))
"""What the outcome of a goal is compared with; `canceled` is any of those that begin with it."""

ENDS_WITH_MISSION = frozenset(
    name for name, signal in SIGNALS.items() if signal.known_by == "mission" and name != "time"
)
"""Signals that never change again once the mission has ended."""
