"""Faults of every kind at drawn times, each of which ends by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from bt_mission.faults import PlannedFault
from bt_mission.faults.corruptions import READY_MADE
from bt_mission.faults.planned import AtTime, Beginning, WhenTrue
from bt_mission.faults.values import planned_fault
from bt_mission.language.requirements.formula import Condition
from bt_mission.ros.interface_types import message_type
from bt_mission.testing.generators.draws import Draws, maybe, number, one_of

MOST_FAULTS = 5
STEP_S = 0.25
LATEST_S = 20.0
LONGEST_S = 3.0
LONGEST_HELD_S = 3.0
"""An event has been true for so long at most when a fault begins, s."""

TOPICS = {
    "scan": "sensor_msgs/msg/LaserScan",
    "odom": "nav_msgs/msg/Odometry",
    "cmd_vel": "geometry_msgs/msg/TwistStamped",
    "tf": "tf2_msgs/msg/TFMessage",
}
"""The topics that every mission uses, with their types."""

ACTIONS = ("turn", "explore_forward", "move", "spin")
SERVICES = ("stop", "release")
CORRUPTIONS = ("nan", "zeros", "empty", "old stamp", "wrong frame")
FEEDBACK_CORRUPTIONS = ("nan", "zeros")
WHEELS = ("left", "right", "both")
NODES = ("bt_mission", "bt_mission_servers")


Call = tuple[tuple[Any, ...], dict[str, Any]]


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
class FaultChoice:
    """What faults are drawn from.

    Attributes:
        names: Of :data:`DRAWN` and :data:`IN_LEAVES`.
        leaves: Names or paths of leaves in which exceptions may be raised.
        actions: Of a mission; none are :data:`ACTIONS`.
        times: The first and the last, s since the start, in steps of :data:`STEP_S`.
        lasting: The shortest and the longest, s.
        topics: With the names of their types.
        fields: What fields may be given other values.
        events: Conditions at which faults may begin, besides the times.
        limits: Times that decide something, s: periods just below and above them are drawn as
            often as all others.
    """

    names: Sequence[str]
    leaves: Sequence[str] = ()
    actions: Sequence[str] = ()
    times: tuple[float, float] = (STEP_S, LATEST_S)
    lasting: tuple[float, float] = (STEP_S, LONGEST_S)
    topics: Mapping[str, str] = field(default_factory=lambda: TOPICS)
    services: Sequence[str] = SERVICES
    fields: Sequence[FieldValues] = FIELDS
    events: Sequence[str] = ()
    limits: Sequence[float] = ()

    def beginning(self, draws: Draws) -> Beginning:
        """Draw when a fault begins: at the first time, at any, or with an event."""
        time = number(draws, *self.times, STEP_S)
        time = self.times[0] if maybe(draws, 4) else time
        if not self.events or not maybe(draws, 2):
            return AtTime(time)
        held = number(draws, 0, LONGEST_HELD_S, STEP_S) if maybe(draws, 2) else 0.0
        return WhenTrue(Condition(one_of(draws, self.events)), held)

    def period(self, draws: Draws, low: float, high: float, step: float) -> float:
        """Draw a period, s: one between two, or one beside a limit."""
        if self.limits and maybe(draws, 2):
            return one_of(draws, self.limits)
        return number(draws, low, high, step)

    def action(self, draws: Draws) -> str:
        """Draw an action."""
        return one_of(draws, self.actions or ACTIONS)

    def topic(self, draws: Draws) -> str:
        """Draw a topic."""
        return one_of(draws, tuple(self.topics))


@dataclass(frozen=True)
class FaultDraw:
    """What draws the calls of a fault.

    Args:
        make: Draws arguments and options, but for `lasting`.
        ends: The fault takes `lasting`; others are over at once.
    """

    make: Callable[[Draws, FaultChoice], Call]
    ends: bool = True


def drawn_faults(
    draws: Draws, names: Sequence[str] = (), leaves: Sequence[str] = ()
) -> tuple[PlannedFault, ...]:
    """Some faults, each of which ends by itself.

    Args:
        names: Of :data:`DRAWN` and :data:`IN_LEAVES`; by default those of topics, goals and
            feedback.
        leaves: Names or paths of leaves in which exceptions may be raised.
    """
    count = draws.whole(0, MOST_FAULTS)
    choice = FaultChoice(names or GRAPH_FAULTS, leaves)
    return tuple(fault for _ in range(count) for fault in drawn_fault(draws, choice))


def can_be_drawn(name: str, choice: FaultChoice) -> bool:
    """Tell whether there is anything that a fault could be about."""
    if name in IN_LEAVES:
        return bool(choice.leaves)
    if name in ("delay_service", "ignore_service", "fail_service"):
        return bool(choice.services)
    if name in ("set_feedback", "set_result", "set_fields"):
        return any(one.fault == name for one in choice.fields)
    return True


def drawn_fault(draws: Draws, choice: FaultChoice) -> tuple[PlannedFault, ...]:
    """One fault, and what it needs before it."""
    begins = choice.beginning(draws)
    name = one_of(draws, choice.names)
    if name in IN_LEAVES:
        method = one_of(draws, ("update", "initialise", "terminate"))
        return (planned_fault(begins, name, one_of(draws, choice.leaves), method=method),)
    arguments, options = DRAWN[name].make(draws, choice)
    if DRAWN[name].ends:
        options = options | {"lasting": choice.period(draws, *choice.lasting, STEP_S)}
    found = planned_fault(begins, name, *arguments, **options)
    if name in OF_A_BOX:
        box = planned_fault(begins, "spawn_box", 1.0, 0.0, nearest_free=True)
        return (box, found)
    return (found,)


@cache
def corruptions_of(type_name: str) -> tuple[str, ...]:
    """Return the ready-made corruptions that change a message of a type."""
    message = message_type(type_name)
    found = []
    for one in CORRUPTIONS:
        made = message()
        if READY_MADE[one](made, list(made.get_fields_and_field_types())):
            found.append(one)
    return tuple(found)


def _plainly(*arguments: Any, **options: Any) -> Callable[[Draws, FaultChoice], Call]:
    return lambda *_: (arguments, options)


def _topic(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.topic(draws),), {}


def _drop(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.topic(draws),), {"share": number(draws, 0.25, 1, 0.25)}


def _delay(draws: Draws, choice: FaultChoice) -> Call:
    by = choice.period(draws, 0.05, 0.5, 0.05)
    return (choice.topic(draws), by), {"jitter": number(draws, 0, 0.1, 0.05)}


def _freeze(draws: Draws, choice: FaultChoice) -> Call:
    topic = choice.topic(draws)
    has_stamps = "old stamp" in corruptions_of(choice.topics[topic])
    return (topic,), {"fresh_stamps": True} if has_stamps and maybe(draws, 4) else {}


def _corrupt(draws: Draws, choice: FaultChoice) -> Call:
    ways = {topic: corruptions_of(kind) for topic, kind in choice.topics.items()}
    topic = one_of(draws, [one for one, found in ways.items() if found])
    return (topic, one_of(draws, ways[topic])), {}


def _set(fault: str) -> Callable[[Draws, FaultChoice], Call]:
    def make(draws: Draws, choice: FaultChoice) -> Call:
        found = one_of(draws, [one for one in choice.fields if one.fault == fault])
        return (found.target,), {found.field: one_of(draws, found.values)}

    return make


def _goals(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.action(draws), draws.whole(1, 3)), {}


def _late(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.action(draws), choice.period(draws, 0.1, 1.5, 0.1)), {}


def _action(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.action(draws),), {}


def _repeated(draws: Draws, choice: FaultChoice) -> Call:
    part = one_of(draws, ("goal", "result", "cancel"))
    return (choice.action(draws), part), {"after": number(draws, 0, 0.5, 0.1)}


def _wrong_feedback(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.action(draws), one_of(draws, FEEDBACK_CORRUPTIONS)), {}


def _raised_in_maneuver(draws: Draws, choice: FaultChoice) -> Call:
    return (choice.action(draws),), {"on": draws.whole(1, 20)}


def _service(draws: Draws, choice: FaultChoice) -> Call:
    return (one_of(draws, choice.services),), {}


def _late_service(draws: Draws, choice: FaultChoice) -> Call:
    return (one_of(draws, choice.services), choice.period(draws, 0.1, 1.5, 0.1)), {}


def _metres(low: float, high: float, step: float) -> Callable[[Draws, FaultChoice], Call]:
    return lambda draws, _: ((number(draws, low, high, step),), {})


def _blind(draws: Draws, _: FaultChoice) -> Call:
    if maybe(draws, 2):
        middle, half = number(draws, -180, 180, 15), number(draws, 5, 90, 5)
        return ((middle - half, middle + half),), {}
    return (), {"share": number(draws, 0.1, 1, 0.1)}


def _radius_error(draws: Draws, _: FaultChoice) -> Call:
    return (), {"left_radius": number(draws, -0.2, 0.2, 0.05) or 0.05}


def _drift(draws: Draws, _: FaultChoice) -> Call:
    return (number(draws, -0.1, 0.1, 0.05),), {"turn": number(draws, -20, 20, 5)}


def _wheel(draws: Draws, _: FaultChoice) -> Call:
    return (one_of(draws, WHEELS),), {}


def _pushed(draws: Draws, _: FaultChoice) -> Call:
    return (number(draws, -20, 20, 5), number(draws, -20, 20, 5)), {}


def _shoved(draws: Draws, _: FaultChoice) -> Call:
    ahead, left = number(draws, -0.3, 0.3, 0.1), number(draws, -0.3, 0.3, 0.1)
    return (ahead, left), {"turn": number(draws, -2, 2, 0.5)}


def _place(draws: Draws, _: FaultChoice) -> Call:
    ahead, left = number(draws, 0.4, 2, 0.2), number(draws, -0.6, 0.6, 0.2)
    return (ahead, left), {"nearest_free": True}


def _box_moves(draws: Draws, _: FaultChoice) -> Call:
    ahead, left = number(draws, -0.5, 1.5, 0.5), number(draws, -1, 1, 0.5)
    return ("box", ahead, left), {"speed": number(draws, 0.1, 1, 0.1), "nearest_free": True}


def _clock_jumps(draws: Draws, _: FaultChoice) -> Call:
    return (number(draws, -2, 2, 0.5) or 0.5,), {"node": one_of(draws, NODES)}


def _clock_stops(draws: Draws, _: FaultChoice) -> Call:
    return (), {"node": one_of(draws, NODES)}


def _in_callback(draws: Draws, _: FaultChoice) -> Call:
    return ("bt_mission_servers", one_of(draws, ("scan", "odom", "stop"))), {
        "on": draws.whole(1, 20)
    }


OF_A_BOX = ("move_box", "remove_box")
"""Faults of a box that another fault has spawned."""

IN_LEAVES = ("raise_in_leaf",)
"""Faults of a leaf, whose name depends on the mission."""

DRAWN: dict[str, FaultDraw] = {
    "drop": FaultDraw(_drop),
    "delay": FaultDraw(_delay),
    "duplicate": FaultDraw(_topic),
    "freeze": FaultDraw(_freeze),
    "corrupt": FaultDraw(_corrupt),
    "reject_goals": FaultDraw(_goals),
    "delay_answers": FaultDraw(_late),
    "delay_results": FaultDraw(_late),
    "refuse_cancels": FaultDraw(_goals),
    "slow_server": FaultDraw(_late),
    "silence_feedback": FaultDraw(_action),
    "ignore_goals": FaultDraw(_goals),
    "drop_answers": FaultDraw(_goals),
    "drop_results": FaultDraw(_goals),
    "ignore_cancels": FaultDraw(_goals),
    "answer_after_halt": FaultDraw(_action),
    "repeat_answers": FaultDraw(_repeated),
    "delay_feedback": FaultDraw(_late),
    "freeze_feedback": FaultDraw(_action),
    "forge_feedback": FaultDraw(_action),
    "corrupt_feedback": FaultDraw(_wrong_feedback),
    "set_feedback": FaultDraw(_set("set_feedback")),
    "set_result": FaultDraw(_set("set_result")),
    "set_fields": FaultDraw(_set("set_fields")),
    "abort_goal": FaultDraw(_action),
    "kill_server": FaultDraw(_action),
    "raise_in_maneuver": FaultDraw(_raised_in_maneuver),
    "raise_in_callback": FaultDraw(_in_callback),
    "delay_service": FaultDraw(_late_service),
    "ignore_service": FaultDraw(_service),
    "fail_service": FaultDraw(_service),
    "lidar_noise": FaultDraw(_metres(0.01, 0.2, 0.01)),
    "lidar_bias": FaultDraw(_metres(-0.3, 0.3, 0.1)),
    "lidar_blind": FaultDraw(_blind),
    "lidar_frozen": FaultDraw(_plainly()),
    "lidar_dead": FaultDraw(_plainly()),
    "odometry_error": FaultDraw(_radius_error),
    "odometry_drift": FaultDraw(_drift),
    "odometry_dead": FaultDraw(_plainly()),
    "imu_dead": FaultDraw(_plainly()),
    "joints_dead": FaultDraw(_plainly()),
    "camera_noise": FaultDraw(_metres(0.1, 0.5, 0.1)),
    "camera_black": FaultDraw(_plainly()),
    "camera_frozen": FaultDraw(_plainly()),
    "camera_dead": FaultDraw(_plainly()),
    "slip_wheel": FaultDraw(_wheel),
    "block_wheel": FaultDraw(_wheel),
    "motors_off": FaultDraw(_plainly()),
    "battery_charge": FaultDraw(_metres(0, 1, 0.1), ends=False),
    "push": FaultDraw(_pushed, ends=False),
    "shove": FaultDraw(_shoved, ends=False),
    "spawn_box": FaultDraw(_place),
    "spawn_cylinder": FaultDraw(_place),
    "move_box": FaultDraw(_box_moves, ends=False),
    "remove_box": FaultDraw(_plainly(), ends=False),
    "jump_clock": FaultDraw(_clock_jumps),
    "stop_clock": FaultDraw(_clock_stops),
}
"""Every fault that can be drawn, by the name of its method; the first is the simplest."""

GRAPH_FAULTS = tuple(DRAWN)[:11]
"""Faults of topics and of goals on their way: none touches the robot, or code."""
