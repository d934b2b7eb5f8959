"""What random faults are drawn from: the topics, actions, limits and fields of a mission."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from bt_mission.scenarios.draws import Draws, maybe, number, one_of

STEP_S = 0.25
LATEST_S = 20.0
LONGEST_S = 3.0

TOPICS = {
    "scan": "sensor_msgs/msg/LaserScan",
    "odom": "nav_msgs/msg/Odometry",
    "cmd_vel": "geometry_msgs/msg/TwistStamped",
    "tf": "tf2_msgs/msg/TFMessage",
}
"""The topics that every mission uses, with their types."""


ACTIONS = ("turn", "explore_forward", "move", "spin")
"""Where no mission says which actions it uses."""


@dataclass(frozen=True)
class FieldValues:
    """Values that a field of messages can be given.

    Attributes:
        fault: The fault that gives them: ``set_feedback``, ``set_result`` or ``set_fields``.
        target: The action or the topic.
        field: Its dotted name.
    """

    fault: str
    target: str
    field: str
    values: tuple[bool | int | float | str, ...]


FIELDS = (
    FieldValues("set_feedback", "turn", "remaining_angle", (0.0, 10.0, 180.0)),
    FieldValues("set_result", "turn", "angle_turned", (0.0, 90.0, -90.0)),
    FieldValues("set_fields", "odom", "pose.pose.position.x", (0.0, 1.0)),
)
"""Where no mission says which fields it reads."""


@dataclass(frozen=True)
class Drawable:
    """Material from which faults are drawn.

    Attributes:
        names: Of faults.
        leaves: Names or paths of leaves in which exceptions may be raised.
        times: The first and the last, s since the start, in steps of :data:`STEP_S`.
        lasting: The shortest and the longest, s.
        topics: With the names of their types.
        fields: What fields may be given other values.
        events: Conditions at which faults may begin, besides the times.
        limits: Times that decide something, s: periods just below and above them are drawn as
            often as all others.
        trusted: The topics whose messages the mission reads, each with the periods of silence
            that its limits tell apart, s. They are tried first.
    """

    names: Sequence[str]
    leaves: Sequence[str] = ()
    actions: Sequence[str] = ACTIONS
    times: tuple[float, float] = (STEP_S, LATEST_S)
    lasting: tuple[float, float] = (STEP_S, LONGEST_S)
    topics: Mapping[str, str] = field(default_factory=lambda: TOPICS)
    services: Sequence[str] = ("stop", "release")
    fields: Sequence[FieldValues] = FIELDS
    events: Sequence[str] = ()
    limits: Sequence[float] = ()
    trusted: Mapping[str, Sequence[float]] = field(default_factory=dict)

    def period(self, draws: Draws, low: float, high: float, step: float) -> float:
        """Draw a period, s: one between two, or one beside a limit."""
        if self.limits and maybe(draws, 2):
            return one_of(draws, self.limits)
        return number(draws, low, high, step)

    def fields_of(self, fault: str) -> list[FieldValues]:
        """Return the fields that a fault may give other values."""
        return [field for field in self.fields if field.fault == fault]
