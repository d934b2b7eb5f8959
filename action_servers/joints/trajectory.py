"""Move the joints of an arm along a trajectory, as joint_trajectory_controller does.

Between two points a joint moves at constant velocity, or on a cubic where both give velocities. It
starts at the measured positions. Accelerations and efforts of points are not used.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from action_servers.core.action import Action, JointCommands
from action_servers.core.limits import (
    NOT_NEGATIVE,
    Limits,
    NumberLimit,
    faults,
    reason,
)
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    JointReadings,
    Observation,
    Refusal,
    refusal,
    stale_joints,
)
from action_servers.core.progress import Ticker
from action_servers.core.tuning import Tuning
from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.base.stamps import NS, to_ns
from bt_mission.robots.joints import JointLimits
from bt_mission.robots.model import RobotModel

MOST_POINTS = 1_000
ROUNDING = 1e-6
LONGEST_S = 3_600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryTuning(Tuning):
    """Of how well an arm follows."""

    joint_tolerance: float = number(
        0.03,
        (0.001, 1.0),
        "Error of a joint at the end of a trajectory that names none, rad or m.",
    )
    joint_time_tolerance: float = number(
        1.0,
        (0.0, 60.0),
        "Time for that after the end of a trajectory whose goal_time_tolerance is 0, s.",
    )


TRAJECTORIES = TrajectoryTuning()
"""The defaults."""


@dataclass(frozen=True, slots=True)
class JointsLimit:
    """The joints that a goal names: all those of an arm, or some, each once, in any order."""

    field: str
    joints: tuple[str, ...]
    source: str = "arm of the robot"
    needs_all: bool = True

    @property
    def words(self) -> str:
        """The accepted values, as text."""
        return f"{'all' if self.needs_all else 'some'} of {listed(self.joints)}"

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with these names, or None."""
        unknown = self._unknown(value)
        if unknown is not None:
            known = f"joints: {listed(self.joints)}"
            return f"{self.field}: no joint '{unknown[:60]}' in the arm ({known})"
        twice = next((name for index, name in enumerate(value) if name in value[:index]), None)
        if twice is not None:
            return f"{self.field}: the joint '{twice[:60]}' is named twice"
        missing = [name for name in self.joints if self.needs_all and name not in value]
        return f"{self.field} must name all joints; missing: {listed(missing)}" if missing else None

    def hint(self, value: Any) -> str | None:
        """Return the joint that was probably meant, if one is near."""
        unknown = self._unknown(value)
        return None if unknown is None else did_you_mean(unknown, self.joints)

    def _unknown(self, names: Any) -> str | None:
        return next((name for name in names if name not in self.joints), None)


class Code(IntEnum):
    """The error codes of `control_msgs/action/FollowJointTrajectory` that its goals end with."""

    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


@dataclass(frozen=True, slots=True)
class Point:
    """Where all joints are at a time from the start, s; velocities may be empty."""

    time_s: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...] = ()


def limits(robot: RobotModel, _tuning: Tuning) -> Limits:
    """Return the limits of single fields."""
    if robot.arm is None:
        return ()
    return (
        JointsLimit("trajectory.joint_names", tuple(robot.arm.joints)),
        NumberLimit(
            field="goal_time_tolerance", low=0.0, high=math.inf, unit="s", source=NOT_NEGATIVE
        ),
    )


def misfit(goal: Any, robot: RobotModel) -> str | None:
    """Return why an arm cannot follow a trajectory, wherever it is now; or None."""
    if robot.arm is None:
        return f"the robot '{robot.name}' has no arm"
    names = refusal(*faults(goal, limits(robot, TRAJECTORIES)))
    return names.reason if names is not None else next(_misfits(goal, robot.arm.joints), None)


def _misfits(goal: Any, joints: Mapping[str, JointLimits]) -> Iterator[str]:
    names = list(goal.trajectory.joint_names)
    if goal.multi_dof_trajectory.points or goal.multi_dof_trajectory.joint_names:
        yield "multi_dof_trajectory is not supported"
    for part in ("component_path_tolerance", "component_goal_tolerance"):
        if getattr(goal, part):
            yield f"{part} is not supported"
    yield from _wrong_points(goal.trajectory.points, names, joints)
    yield from _wrong_tolerances(goal, joints)


def _wrong_points(
    points: Sequence[Any], names: Sequence[str], joints: Mapping[str, JointLimits]
) -> Iterator[str]:
    if not 1 <= len(points) <= MOST_POINTS:
        yield f"trajectory.points: expected 1 to {MOST_POINTS:,}, got {len(points):,}"
    for index, point in enumerate(points):
        yield from _wrong_point(f"trajectory.points[{index}]", point, names)
    yield from _wrong_course(points, names, joints)


def _wrong_tolerances(goal: Any, joints: Mapping[str, JointLimits]) -> Iterator[str]:
    for part in ("path_tolerance", "goal_tolerance"):
        given = getattr(goal, part)
        names = JointsLimit(part, tuple(joints), needs_all=False)
        wrong = reason(names, [each.name for each in given])
        if wrong is not None:
            yield wrong
        for each in given:
            for value in (each.position, each.velocity, each.acceleration):
                if not (value >= 0 or value == -1) or math.isinf(value):
                    yield f"{part} of {each.name}: expected 0 or more, or -1 for any, got {value:g}"


def _wrong_point(where: str, point: Any, names: Sequence[str]) -> Iterator[str]:
    if len(point.positions) != len(names):
        yield f"{where}: expected {len(names)} positions, got {len(point.positions)}"
    if len(point.velocities) not in (0, len(names)):
        yield f"{where}: expected {len(names)} velocities or none, got {len(point.velocities)}"
    if not all(map(math.isfinite, (*point.positions, *point.velocities))):
        yield f"{where}: expected finite positions and velocities"


def _wrong_course(
    points: Sequence[Any], names: Sequence[str], joints: Mapping[str, JointLimits]
) -> Iterator[str]:
    """Yield why the course of the points is beyond the limits of the joints."""
    course = [_point(each) for each in points]
    before: Point | None = None
    for index, point in enumerate(course):
        where = f"trajectory.points[{index}]"
        if point.time_s < 0 or (before is not None and point.time_s <= before.time_s):
            yield f"{where}: time_from_start must increase from point to point, from 0 s on"
        if point.time_s > LONGEST_S:
            yield f"{where}: time_from_start is above {LONGEST_S:g} s"
        for name, position in zip(names, point.positions, strict=True):
            low, high = joints[name].min, joints[name].max
            if not low - ROUNDING <= position <= high + ROUNDING:
                yield f"{where}: {name} must be from {low:g} to {high:g}, got {position:g}"
        if before is not None:
            yield from _too_fast(where, before, point, names, joints)
        before = point


def _too_fast(
    where: str,
    before: Point,
    point: Point,
    names: Sequence[str],
    joints: Mapping[str, JointLimits],
) -> Iterator[str]:
    """Yield which joints move too fast between two points."""
    for index, name in enumerate(names):
        fastest, most = _fastest(before, point, index), joints[name].max_velocity
        if fastest > most * (1 + ROUNDING):
            yield f"{where}: {name} would move at {fastest:.3g} a second, the limit is {most:g}"


def _fastest(before: Point, point: Point, index: int) -> float:
    """Return the highest speed of a joint between two points."""
    span = point.time_s - before.time_s
    mean = (point.positions[index] - before.positions[index]) / span
    if not (before.velocities and point.velocities):
        return abs(mean)
    first, last = before.velocities[index], point.velocities[index]
    speeds = [abs(first), abs(last)]
    # The velocity of the cubic is a parabola in the share s of the time.
    square, linear = 3 * (first + last - 2 * mean), 6 * mean - 4 * first - 2 * last
    if square:
        share = -linear / (2 * square)
        if 0 < share < 1:
            speeds.append(abs(first + linear * share + square * share**2))
    return max(speeds)


def _point(message: Any) -> Point:
    return Point(
        to_ns(message.time_from_start) / NS, tuple(message.positions), tuple(message.velocities)
    )


class Course:
    """The positions and velocities of joints over time."""

    def __init__(self, points: Sequence[Point]) -> None:
        self._points = points
        self._times = [point.time_s for point in points]
        self.duration_s = points[-1].time_s

    def at(self, time_s: float) -> tuple[list[float], list[float]]:
        """Return positions and velocities at a time from the start, s."""
        points = self._points
        index = bisect_right(self._times, time_s)
        if index == 0 or index == len(points):
            there = points[0] if index == 0 else points[-1]
            return list(there.positions), [0.0] * len(there.positions)
        before, after = points[index - 1], points[index]
        span = after.time_s - before.time_s
        share = (time_s - before.time_s) / span
        if not (before.velocities and after.velocities):
            speeds = [
                (b - a) / span for a, b in zip(before.positions, after.positions, strict=True)
            ]
            moved = zip(before.positions, after.positions, strict=True)
            return [a + share * (b - a) for a, b in moved], speeds
        each = [_cubic(before, after, joint, share, span) for joint in range(len(after.positions))]
        return [position for position, _ in each], [speed for _, speed in each]


def _cubic(before: Point, after: Point, joint: int, s: float, span: float) -> tuple[float, float]:
    """Return position and velocity of a joint at a share of the time between two points."""
    p, q = before.positions[joint], after.positions[joint]
    u, v = before.velocities[joint] * span, after.velocities[joint] * span
    a, b = 2 * p - 2 * q + u + v, 3 * q - 3 * p - 2 * u - v
    return ((a * s + b) * s + u) * s + p, ((3 * a * s + 2 * b) * s + u) / span


def plan(
    goal: Any,
    now: Observation,
    robot: RobotModel,
    joints: JointCommands,
    tuning: TrajectoryTuning = TRAJECTORIES,
) -> Trajectory | Refusal:
    """Return the maneuver for a goal."""
    wrong = misfit(goal, robot)
    if wrong is not None:
        return Refusal(wrong)
    assert robot.arm is not None
    assert now.joints is not None
    names = tuple(goal.trajectory.joint_names)
    absent = [name for name in names if name not in now.joints.positions]
    if absent:
        return Refusal(f"joint_states has no {listed(absent)}")
    start_s = to_ns(goal.trajectory.header.stamp) / NS or now.time_s
    points = [_point(each) for each in goal.trajectory.points]
    if start_s + points[-1].time_s < now.time_s:
        ago = now.time_s - start_s - points[-1].time_s
        return Refusal(
            f"trajectory.header.stamp is too old: the last point was due {ago:.2f} s ago"
        )
    here = Point(
        min(0.0, points[0].time_s),
        tuple(now.joints.positions[name] for name in names),
        (0.0,) * len(names) if points[0].velocities else (),
    )
    if points[0].time_s > 0:
        points.insert(0, here)
        reason = next(
            _too_fast("trajectory.points[0]", here, points[1], names, robot.arm.joints), None
        )
    else:
        reason = next(_elsewhere(here, points[0], names, tuning.joint_tolerance), None)
    if reason is not None:
        return Refusal(reason)
    tolerances = Tolerances.of(goal, names, tuning)
    return Trajectory(names, Course(points), start_s, tolerances, joints, robot, tuning)


def _elsewhere(here: Point, there: Point, names: Sequence[str], tolerance: float) -> Iterator[str]:
    for name, a, b in zip(names, here.positions, there.positions, strict=True):
        if abs(a - b) > tolerance:
            yield (
                f"trajectory.points[0]: {name} is at {a:.3g}, and cannot be at {b:.3g} after 0 s;"
                " give a later time_from_start"
            )


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Largest errors of each joint, infinite for any: on the way, and at the end."""

    path: tuple[float, ...]
    path_velocity: tuple[float, ...]
    goal: tuple[float, ...]
    goal_velocity: tuple[float, ...]
    time_s: float

    @classmethod
    def of(cls, goal: Any, names: Sequence[str], tuning: TrajectoryTuning) -> Tolerances:
        """Return those of a goal; 0 is the default, and a negative number any error."""
        path = {each.name: each for each in goal.path_tolerance}
        end = {each.name: each for each in goal.goal_tolerance}

        def chosen(given: Mapping[str, Any], field: str, usual: float) -> tuple[float, ...]:
            values = (getattr(given[name], field) if name in given else 0.0 for name in names)
            return tuple(math.inf if v < 0 else v or usual for v in values)

        return cls(
            chosen(path, "position", math.inf),
            chosen(path, "velocity", math.inf),
            chosen(end, "position", tuning.joint_tolerance),
            chosen(end, "velocity", math.inf),
            to_ns(goal.goal_time_tolerance) / NS or tuning.joint_time_tolerance,
        )


class JointManeuver:
    """What a goal for joints has in common: at a sudden end the joints stop where they are."""

    needs_base = False

    def __init__(self, names: Sequence[str], joints: JointCommands) -> None:
        self._names = tuple(names)
        self._joints = joints
        self._now: JointReadings | None = None
        self._is_over = False

    def hold(self) -> None:
        """Stop the joints where they are, unless the goal has ended regularly."""
        if self._now is not None and not self._is_over:
            now = self._now.positions
            self._joints.send(self._names, [now[name] for name in self._names])
        self._is_over = True

    def succeeded(self) -> Finished:
        """Return the end of a goal whose joints stay as they are commanded."""
        self._is_over = True
        return SUCCEEDED

    def measured(self, now: Observation, limit_s: float) -> JointReadings | Finished:
        """Return the newest positions, or the end of the goal without them."""
        reason = stale_joints(now, limit_s)
        joints = now.joints
        if joints is not None and reason is None:
            absent = [name for name in self._names if name not in joints.positions]
            reason = f"joint_states has no {listed(absent)}" if absent else None
        if reason is not None or joints is None:
            return Finished("aborted", ErrorCode.NO_ODOMETRY, reason or "")
        self._now = joints
        return joints


@contextmanager
def holding(maneuver: Any, _goal_id: str) -> Iterator[None]:
    """Stop the joints at an end that is not the maneuver's own: cancel, replacement, stop."""
    try:
        yield
    finally:
        hold = getattr(maneuver, "hold", None)
        if hold is not None:
            hold()


class Trajectory(JointManeuver):
    """Sends the joints along a course, and watches how well they follow."""

    def __init__(
        self,
        names: tuple[str, ...],
        course: Course,
        start_s: float,
        tolerances: Tolerances,
        joints: JointCommands,
        robot: RobotModel,
        tuning: Tuning,
    ) -> None:
        super().__init__(names, joints)
        self._course = course
        self._start_s = start_s
        self._tolerances = tolerances
        self._period_s = 1.0 / robot.control_rate
        self._timeout_s = tuning.sensor_timeout
        self._ticker = Ticker()
        self._feedback: Fields = {}

    def step(self, now: Observation) -> Twist2D | Finished:
        """Command the next positions, or end."""
        joints = self.measured(now, self._timeout_s)
        if isinstance(joints, Finished):
            return joints
        self._ticker.update(now.time_s)
        elapsed_s = now.time_s - self._start_s
        actual = [joints.positions[name] for name in self._names]
        speeds = [joints.velocities.get(name, 0.0) for name in self._names]
        desired, wanted = self._course.at(joints.stamp_s - self._start_s)
        errors = [a - b for a, b in zip(desired, actual, strict=True)]
        slips = [a - b for a, b in zip(wanted, speeds, strict=True)]
        self._feedback = {
            "joint_names": list(self._names),
            "desired": _fields(elapsed_s, desired, wanted),
            "actual": _fields(elapsed_s, actual, speeds),
            "error": _fields(elapsed_s, errors, slips),
        }
        limit, duration_s = self._tolerances, self._course.duration_s
        if elapsed_s < duration_s - ROUNDING:
            why = self._beyond(errors, limit.path, "its path") or self._beyond(
                slips, limit.path_velocity, "the velocity of its path"
            )
            if why is not None:
                return Finished("aborted", Code.PATH_TOLERANCE_VIOLATED, why)
        else:
            why = self._beyond(errors, limit.goal, "its goal") or self._beyond(
                slips, limit.goal_velocity, "rest"
            )
            if why is None:
                return self.succeeded()
            if elapsed_s >= duration_s + limit.time_s - ROUNDING:
                late = f"{why}, {elapsed_s - duration_s:.2f} s after the end of the trajectory"
                return Finished("aborted", Code.GOAL_TOLERANCE_VIOLATED, late)
        if elapsed_s + self._period_s > 0:
            self._joints.send(self._names, self._course.at(elapsed_s + self._period_s)[0])
        return ZERO

    def feedback(self) -> Fields | None:
        """Return desired and actual positions, once a second."""
        return self._feedback if self._ticker.take() else None

    def result(self) -> Fields:
        """Return nothing more than code and text."""
        return {}

    def _beyond(self, errors: Sequence[float], limits: Sequence[float], what: str) -> str | None:
        for name, error, limit in zip(self._names, errors, limits, strict=True):
            if abs(error) > limit:
                return f"{name} is {abs(error):.3g} from {what}, the tolerance is {limit:g}"
        return None


def _fields(time_s: float, positions: Sequence[float], velocities: Sequence[float]) -> Fields:
    return {
        "positions": list(positions),
        "velocities": list(velocities),
        "time_from_start": max(0.0, time_s),
    }


FOLLOW_JOINT_TRAJECTORY = Action(
    name="arm_controller/follow_joint_trajectory",
    type="control_msgs/action/FollowJointTrajectory",
    needs=("arm",),
    short="",
    example={
        "trajectory": {
            "joint_names": ["joint1", "joint2", "joint3", "joint4"],
            "points": [{"positions": [0.5, -1.0, 0.3, 0.7], "time_from_start": 4.0}],
        }
    },
    plan=plan,
    tuning=TRAJECTORIES,
    limits=limits,
    misfit=misfit,
    codes=tuple(Code),
    during=holding,
)
