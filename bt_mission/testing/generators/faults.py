"""Faults of every kind at drawn times, each of which ends by itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from bt_mission.faults import PlannedFault
from bt_mission.faults.faults import FAULTS
from bt_mission.faults.planned import AtTime
from bt_mission.faults.values import planned_fault
from bt_mission.testing.generators.draws import Draws, maybe, number, one_of

MOST_FAULTS = 5
STEP_S = 0.25
LATEST_S = 20.0
LONGEST_S = 3.0

TOPICS = ("scan", "odom", "cmd_vel", "tf")
ACTIONS = ("turn", "explore_forward", "move", "spin")
SERVICES = ("stop", "release")
CORRUPTIONS = ("nan", "zeros", "empty", "old stamp", "wrong frame")
FEEDBACK_CORRUPTIONS = ("nan", "zeros")
WHEELS = ("left", "right", "both")
NODES = ("bt_mission", "bt_mission_servers")


Call = tuple[tuple[Any, ...], dict[str, Any]]


@dataclass(frozen=True)
class FaultDraw:
    """What draws the calls of a fault.

    Args:
        make: Draws arguments and options, but for `lasting`.
        ends: The fault takes `lasting`; others are over at once.
    """

    make: Callable[[Draws], Call]
    ends: bool = True


@dataclass(frozen=True)
class FaultChoice:
    """What faults are drawn from.

    Attributes:
        names: Of :data:`DRAWN` and :data:`IN_LEAVES`.
        leaves: Names or paths of leaves in which exceptions may be raised.
        actions: Of a mission; none are :data:`ACTIONS`.
        times: The first and the last, s since the start, in steps of :data:`STEP_S`.
        lasting: The shortest and the longest, s.
    """

    names: Sequence[str]
    leaves: Sequence[str] = ()
    actions: Sequence[str] = ()
    times: tuple[float, float] = (STEP_S, LATEST_S)
    lasting: tuple[float, float] = (STEP_S, LONGEST_S)


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


def drawn_fault(draws: Draws, choice: FaultChoice) -> tuple[PlannedFault, ...]:
    """One fault, and what it needs before it."""
    time = number(draws, *choice.times, STEP_S)
    name = one_of(draws, choice.names)
    if name in IN_LEAVES:
        method = one_of(draws, ("update", "initialise", "terminate"))
        return (planned_fault(AtTime(time), name, one_of(draws, choice.leaves), method=method),)
    arguments, options = DRAWN[name].make(draws)
    if choice.actions and "action" in FAULTS[name].parameters:
        arguments = (one_of(draws, choice.actions), *arguments[1:])
    if DRAWN[name].ends:
        options = options | {"lasting": number(draws, *choice.lasting, STEP_S)}
    found = planned_fault(AtTime(time), name, *arguments, **options)
    if name in OF_A_BOX:
        return (planned_fault(AtTime(time), "spawn_box", 1.0, 0.0, even_into_the_robot=True), found)
    return (found,)


def _plainly(*arguments: Any, **options: Any) -> Callable[[Draws], Call]:
    return lambda _: (arguments, options)


def _topic(draws: Draws) -> Call:
    return (one_of(draws, TOPICS),), {}


def _drop(draws: Draws) -> Call:
    return (one_of(draws, TOPICS),), {"share": number(draws, 0.25, 1, 0.25)}


def _delay(draws: Draws) -> Call:
    by = number(draws, 0.05, 0.5, 0.05)
    return (one_of(draws, TOPICS), by), {"jitter": number(draws, 0, 0.1, 0.05)}


def _freeze(draws: Draws) -> Call:
    return (one_of(draws, TOPICS),), {"fresh_stamps": True} if maybe(draws, 4) else {}


def _corrupt(draws: Draws) -> Call:
    return ("scan", one_of(draws, CORRUPTIONS)), {}


def _goals(draws: Draws) -> Call:
    return (one_of(draws, ACTIONS), draws.whole(1, 3)), {}


def _late(draws: Draws) -> Call:
    return (one_of(draws, ACTIONS), number(draws, 0.1, 1.5, 0.1)), {}


def _action(draws: Draws) -> Call:
    return (one_of(draws, ACTIONS),), {}


def _repeated(draws: Draws) -> Call:
    part = one_of(draws, ("goal", "result", "cancel"))
    return (one_of(draws, ACTIONS), part), {"after": number(draws, 0, 0.5, 0.1)}


def _wrong_feedback(draws: Draws) -> Call:
    return (one_of(draws, ACTIONS), one_of(draws, FEEDBACK_CORRUPTIONS)), {}


def _raised_in_maneuver(draws: Draws) -> Call:
    return (one_of(draws, ACTIONS),), {"on": draws.whole(1, 20)}


def _service(draws: Draws) -> Call:
    return (one_of(draws, SERVICES),), {}


def _late_service(draws: Draws) -> Call:
    return (one_of(draws, SERVICES), number(draws, 0.1, 1.5, 0.1)), {}


def _metres(low: float, high: float, step: float) -> Callable[[Draws], Call]:
    return lambda draws: ((number(draws, low, high, step),), {})


def _blind(draws: Draws) -> Call:
    return (), {"share": number(draws, 0.1, 1, 0.1)}


def _radius_error(draws: Draws) -> Call:
    return (), {"left_radius": number(draws, -0.2, 0.2, 0.05) or 0.05}


def _drift(draws: Draws) -> Call:
    return (number(draws, -0.1, 0.1, 0.05),), {"turn": number(draws, -20, 20, 5)}


def _wheel(draws: Draws) -> Call:
    return (one_of(draws, WHEELS),), {}


def _pushed(draws: Draws) -> Call:
    return (number(draws, -20, 20, 5), number(draws, -20, 20, 5)), {}


def _shoved(draws: Draws) -> Call:
    ahead, left = number(draws, -0.3, 0.3, 0.1), number(draws, -0.3, 0.3, 0.1)
    return (ahead, left), {"turn": number(draws, -2, 2, 0.5)}


def _place(draws: Draws) -> Call:
    ahead, left = number(draws, 0.4, 2, 0.2), number(draws, -0.6, 0.6, 0.2)
    return (ahead, left), {"even_into_the_robot": True}


def _box_moves(draws: Draws) -> Call:
    ahead, left = number(draws, -0.5, 1.5, 0.5), number(draws, -1, 1, 0.5)
    return ("box", ahead, left), {"speed": number(draws, 0.1, 1, 0.1)}


def _clock_jumps(draws: Draws) -> Call:
    return (number(draws, -2, 2, 0.5) or 0.5,), {"node": one_of(draws, NODES)}


def _clock_stops(draws: Draws) -> Call:
    return (), {"node": one_of(draws, NODES)}


def _in_callback(draws: Draws) -> Call:
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
