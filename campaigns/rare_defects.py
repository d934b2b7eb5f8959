"""Defects that show in a rare moment alone, for the benchmark of the search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from action_servers.core.maneuver import Observation
from action_servers.driving.explore_forward import ExploreForward
from action_servers.driving.turn import Turn
from bt_mission.core.geometry import Twist2D
from bt_mission.goals.attempt import Attempt
from tests.support.planting import Plant, altered, check_feedback, given, instead, look

DRIVE = """\
scenario: out and round
mission:
  mission: out and round
  world: empty_arena
  inputs: {speed: 0.2, gap: 0.4}
  tree:
    sequence:
      - explore_forward: {fwd_velocity: $speed, stopping_distance: $gap}
        name: out
        cancel_when: current_distance_travelled > 0.8
        on_cancel: success
        timeout: 15
      - turn: {angle: 90}
        name: round
        timeout: 15
start: {x: -1.0}
requirements:
  keeps to its speed: always speed < 0.24
  keeps its distance: always clearance > 0.10
  turns to the left: never running("round") and turn_rate < -0.2
  goes no farther: always distance < 1.0
"""

TO_THE_WALL = (
    DRIVE.replace("        cancel_when: current_distance_travelled > 0.8\n", "")
    .replace("        on_cancel: success\n", "")
    .replace("  goes no farther: always distance < 1.0\n", "")
    .replace("x: -1.0", "x: 0.9")
)


@dataclass(frozen=True)
class RareDefect:
    """A defect, the scenario that it is searched in, what violates it, and the ranges."""

    what: str
    scenario: str
    caught_by: str
    plant: Plant
    ranges: str = "{}"


def _age_s(now: Observation) -> float:
    return 0.0 if now.scan is None else now.time_s - now.scan.stamp_s


def _in_a_window(answer: Any, self: ExploreForward, now: Observation) -> Any:
    """Speed up where a scan is late 2.0 s to 2.3 s after the start of the drive."""
    begun = vars(self).setdefault("begun", now.time_s)
    is_then = 2.0 <= now.time_s - begun <= 2.3
    if is_then and _age_s(now) > 0.25:
        vars(self)["spoilt"] = True
    return Twist2D(0.26, 0.0) if _is_spoilt(self, answer) else answer


def _two_at_once(answer: Any, self: ExploreForward, now: Observation) -> Any:
    """Speed up once scan and odometry have been late at the same time."""
    if _age_s(now) > 0.25 and now.time_s - now.odom_stamp_s > 0.15:
        vars(self)["spoilt"] = True
    return Twist2D(0.26, 0.0) if _is_spoilt(self, answer) else answer


def _is_spoilt(self: Any, answer: Any) -> bool:
    return isinstance(answer, Twist2D) and "spoilt" in vars(self)


def _overlook(self: ExploreForward, now: Observation) -> None:
    """Overlook for ever what comes into view 0.4 m to 0.5 m into the drive."""
    was_free = self._ahead is None or self._ahead.gap > 1.0
    look(self, now)
    is_seen = self._ahead is not None and self._ahead.gap < 1.0
    if was_free and is_seen and 0.4 <= self._drive.distance <= 0.5:
        vars(self)["overlooked"] = True
    if "overlooked" in vars(self):
        self._ahead = None


def _if_it_turns(answer: Any, self: Turn, now: Observation) -> Any:
    """Turn the other way where the base turns already at the beginning."""
    if "begun" not in vars(self):
        vars(self)["begun"] = now.velocity is not None and abs(now.velocity.angular) > 0.15
    is_wrong = vars(self)["begun"] and isinstance(answer, Twist2D)
    return Twist2D(answer.linear, -answer.angular) if is_wrong else answer


def _deaf(self: Attempt, goal: Any, now_ns: int) -> None:
    """Hear no more feedback once there was none for 0.5 s."""
    known = vars(self)
    if goal.unread:
        if now_ns - known.get("heard_ns", now_ns) > 500_000_000:
            known["is_deaf"] = True
        known["heard_ns"] = now_ns
    if "is_deaf" in known:
        goal.unread.clear()
    check_feedback(self, goal, now_ns)


RARE = (
    RareDefect(
        "speeds up if a scan is late within 0.3 s",
        DRIVE,
        "keeps to its speed",
        altered(ExploreForward, "step", _in_a_window),
    ),
    RareDefect(
        "speeds up if scan and odometry are late at once",
        DRIVE,
        "keeps to its speed",
        altered(ExploreForward, "step", _two_at_once),
    ),
    RareDefect(
        "overlooks what appears within 0.5 s",
        DRIVE,
        "keeps its distance",
        instead(ExploreForward, "_look", _overlook),
    ),
    RareDefect(
        "turns the wrong way if it turns as it begins",
        DRIVE,
        "turns to the left",
        altered(Turn, "step", _if_it_turns),
    ),
    RareDefect(
        "hears no feedback after a silence",
        DRIVE,
        "goes no farther",
        instead(Attempt, "_check_feedback", _deaf),
    ),
    RareDefect(
        "stops late in a corner of two inputs",
        TO_THE_WALL,
        "keeps its distance",
        given(
            ExploreForward,
            "__init__",
            lambda speed, gap, *rest: (speed, gap - 4.2 * max(0.0, speed - 0.2), *rest),
        ),
        "inputs: {speed: 0.1..0.25, gap: 0.3..0.6}\nfaults: {most: 0}\nobstacles: {most: 0}\n",
    ),
)
"""Each is planted as in `tests.support.planted_defects`."""
