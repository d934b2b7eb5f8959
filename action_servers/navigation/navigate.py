"""The maneuver behind NavigateToPose: plan, follow, look, wait, plan again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from action_servers.core.clearance import footprint
from action_servers.core.drive_limits import Ramp, limits
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Observation,
    Reason,
    overdue,
    silent_guard,
)
from action_servers.core.progress import ProgressChecker
from action_servers.navigation.arc_follower import ArcFollower
from action_servers.navigation.arcs import MARGINS_M, ArcSearch
from action_servers.navigation.follower import Escape, Follower, way_out
from action_servers.navigation.planner import NoPath, Point, at, plan, road_map
from action_servers.navigation.surroundings import Surroundings
from bt_mission.base.geometry import Pose2D, Twist2D, distance
from bt_mission.robots.model import RobotModel

_LOOK_AHEAD_M = 2.5
_STOP_BEFORE_M = 0.05
_OFF_PATH_M = 0.3

_PLACES_A_STEP = 200
"""Of a search for arcs in one control step: about 15 ms, while the car stands."""


@dataclass(frozen=True, slots=True)
class Standing:
    """It has no path: it has not planned yet, or has left its path."""

    follower: None = None


@dataclass(frozen=True, slots=True)
class Searching:
    """A car stands and looks for arcs to the goal; without any, it follows its path in strokes."""

    follower: Follower
    search: ArcSearch
    others: tuple[Callable[[], ArcSearch], ...]
    """The searches to make after this one, each with a smaller margin."""


@dataclass(frozen=True, slots=True)
class Escaping:
    """It drives out of where it is too close to turn freely, and then plans again."""

    follower: Follower
    escape: Escape


@dataclass(frozen=True, slots=True)
class Following:
    """It follows a path."""

    follower: Follower | ArcFollower


State: TypeAlias = Standing | Searching | Escaping | Following


@dataclass(frozen=True, slots=True)
class Retry:
    """It plans again at a time, s: its path is blocked, or it found none."""

    at_s: float
    no_path: NoPath | None = None
    since_s: float = 0.0
    """The time since which there is no path, s."""


class NavigateToPose:
    """Drives to a pose on the map, and stands whenever it does not see or know enough."""

    needs_base = True

    def __init__(
        self,
        goal: Pose2D,
        robot: RobotModel,
        surroundings: Surroundings | None = None,
        twist: Twist2D = ZERO,
        *,
        may_stop: bool = True,
    ) -> None:
        """Make a maneuver to `goal`, in the map frame.

        `surroundings`, with their tuning, may be those of the last, and `twist` what it commanded,
        to drive on from. A car that `may_stop` stands while it plans arcs to the goal and its yaw.
        """
        self._goal = goal
        self._step_s = 1.0 / robot.control_rate
        self.surroundings = surroundings or Surroundings(robot)
        """The state of the world."""
        self._tuning = self.surroundings.tuning
        self._body = footprint(robot)
        self._limits = limits(robot)
        self._sharpest = robot.drive.max_curvature if may_stop else math.inf
        self._ramp = Ramp(self._limits, twist)
        self._progress = ProgressChecker()
        self._state: State = Standing()
        self._retry: Retry | None = None
        self._recovered = False
        self.recoveries = 0
        """The number of recoveries and plans around obstacles."""
        self._start_s: float | None = None
        self._now = Observation(0.0)
        self._pose: Pose2D | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the twist for this control step, or how the goal ends."""
        if self._start_s is None:
            self._start_s = now.time_s
        self._now = now
        self.surroundings.observe(now)
        lost = self._lost(now, self._tuning.give_up_after)
        if lost is not None:
            return lost
        is_blind = self._lost(now, self._tuning.blind_after) is not None
        if is_blind or now.map_pose is None or not self.surroundings.ready:
            return self._ramp.stop()
        if now.held is not None:
            self._ramp.twist = now.held.twist
        is_stopped = now.held_by is Reason.OBSTACLE and self._ramp.twist == ZERO
        self._pose = now.map_pose
        ended = self._mind_the_time(now.map_pose) or self._find_path(now.map_pose)
        return ended or self._drive(now.map_pose, is_stopped=is_stopped)

    def feedback(self) -> Fields | None:
        """Return the fields of Nav2's feedback: metres, seconds, poses in the map frame."""
        if self._pose is None:
            return None
        follower, now, left, seconds = self._state.follower, self._now, 0.0, 0.0
        if follower is not None:
            left = follower.remaining
            seconds = follower.seconds_left(self._pose, now.speed_limit)
        return {
            "current_pose": self._pose,
            "navigation_time": now.time_s - (self._start_s or 0.0),
            "estimated_time_remaining": seconds,
            "number_of_recoveries": self.recoveries,
            "distance_remaining": left,
        }

    def result(self) -> Fields:
        """Return no fields: Nav2's result has none."""
        return {}

    def _lost(self, now: Observation, limit_s: float) -> Finished | None:
        """Return the end of the goal if pose, scan or a guard is too old, or None."""
        began_s, seen_s = self._start_s, self.surroundings.seen_s
        pose = overdue("pose on the map", now.odom_stamp_s, now.time_s, limit_s)
        if pose is not None:
            driving = self._state.follower is not None
            code = ErrorCode.TF_ERROR_WHILE_PLANNING
            return Finished("aborted", ErrorCode.TF_ERROR_WHILE_DRIVING if driving else code, pose)
        scan = overdue("scan", began_s if seen_s is None else seen_s, now.time_s, limit_s)
        scan = scan or silent_guard(now, limit_s)
        return None if scan is None else Finished("aborted", ErrorCode.CONTROLLER_TIMED_OUT, scan)

    def _mind_the_time(self, pose: Pose2D) -> Finished | None:
        """Recover once and then give up when the robot gets nowhere."""
        retry, time_s = self._retry, self._now.time_s
        if isinstance(self._state, Searching):
            self._progress.restart()
        if retry is None or retry.no_path is None:
            idle_s = self._progress.standing_s(pose, time_s)
        else:
            self._progress.restart()
            idle_s = time_s - retry.since_s
        if idle_s >= self._tuning.patience:
            return self._given_up(pose, idle_s)
        if idle_s < self._step_s:
            self._recovered = False
        elif idle_s >= self._tuning.recover_after and not self._recovered:
            self._recovered = True
            self.recoveries += 1
            self.surroundings.forget()
            self._state = Standing()
            # The next scans show again what is there.
            self._retry = replace(retry or Retry(0.0), at_s=time_s + self._tuning.wait)
        return None

    def _given_up(self, pose: Pose2D, idle_s: float) -> Finished:
        no_path = None if self._retry is None else self._retry.no_path
        if no_path is not None:
            reason = f"{no_path.reason}; none has opened for {idle_s:.1f} s"
            return Finished("aborted", no_path.code, reason)
        reason = f"the robot has not got away from {at((pose.x, pose.y))} for {idle_s:.1f} s"
        return Finished("aborted", ErrorCode.FAILED_TO_MAKE_PROGRESS, reason)

    def _find_path(self, pose: Pose2D) -> Finished | None:
        """Plan if there is no path, it was left, or it has been blocked for long."""
        if isinstance(self._state, Searching):
            self._search_on(self._state)
            return None
        follower = self._state.follower
        if follower is not None and follower.off_path > _OFF_PATH_M:
            self._state = Standing()
        if self._retry is None:
            if self._state.follower is not None:
                return None
        elif self._now.time_s < self._retry.at_s:
            return None
        return self._plan(pose)

    def _plan(self, pose: Pose2D) -> Finished | None:
        is_car = math.isfinite(self._sharpest)
        if is_car and self._ramp.twist != ZERO:
            self._state = Standing()  # it plans while it stands
            return None
        start, goal = (pose.x, pose.y), (self._goal.x, self._goal.y)
        roads = self.surroundings.roads
        path = plan(roads, start, goal, self._tuning)
        if isinstance(path, NoPath):
            return self._without_path(path, start)
        if self._retry is not None and self._state.follower is not None:
            self.recoveries += 1
        self._retry = None
        survey, cost = self.surroundings.survey, self.surroundings.cost
        self.surroundings.show(path.points)
        follower = Follower(path, self._goal.yaw, self._limits, cost, survey, self._tuning)
        if is_car:
            x, y = path.points[-1].tolist()
            ends = pose, Pose2D(x, y, self._goal.yaw)
            first, *others = (
                partial(ArcSearch, roads, self._body, self._sharpest, ends, margin)
                for margin in MARGINS_M
            )
            self._state = Searching(follower, first(), tuple(others))
            return None
        if survey.clearance_of(*start) < cost.radius - 1.5 * cost.margin:
            way = way_out(pose, self.surroundings.near(pose), self._body, survey, cost.radius)
            escape = None if way is None else Escape(way, self._limits)
        else:
            escape = self._state.escape if isinstance(self._state, Escaping) else None
        self._state = Following(follower) if escape is None else Escaping(follower, escape)
        return None

    def _without_path(self, path: NoPath, start: Point) -> Finished | None:
        """Plan again later, unless the map alone shows that there never is a path."""
        since_s = self._now.time_s
        if self._retry is not None and self._retry.no_path is not None:
            since_s = self._retry.since_s
        else:
            known = road_map(self.surroundings.mapped, self.surroundings.cost)
            hopeless = plan(known, start, (self._goal.x, self._goal.y), self._tuning)
            if isinstance(hopeless, NoPath) and hopeless.code is not ErrorCode.START_OCCUPIED:
                return Finished("aborted", hopeless.code, hopeless.reason)
        self._retry = Retry(self._now.time_s + self._tuning.wait, path, since_s)
        return None

    def _search_on(self, state: Searching) -> None:
        """Look for arcs to the goal."""
        search = state.search
        search.advance(_PLACES_A_STEP)
        if not search.is_over:
            return
        if search.way is not None:
            survey = self.surroundings.survey
            self.surroundings.show(search.way.poses[:, :2])
            arcs = ArcFollower(
                search.way, self._goal.yaw, self._limits, self._body, survey, self._tuning
            )
            self._state = Following(arcs)
        elif state.others:
            self._state = Searching(state.follower, state.others[0](), state.others[1:])
        else:
            self._state = Following(state.follower)

    def _drive(self, pose: Pose2D, *, is_stopped: bool) -> Twist2D | Finished:
        wanted, blocked = self._wanted(pose)
        if wanted is None:
            return SUCCEEDED
        if blocked or is_stopped:
            if self._retry is None:
                self._retry = Retry(self._now.time_s + self._tuning.wait)
        elif self._state.follower is not None:
            self._retry = None
        return self._ramp.toward(wanted, self._step_s)

    def _wanted(self, pose: Pose2D) -> tuple[Twist2D | None, bool]:
        """Return the next twist, None at the goal, and whether the path is blocked."""
        state = self._state
        if isinstance(state, Escaping):
            out = state.escape.steer(pose)
            if out is None:
                self._state = Standing()
            return out or ZERO, False
        if not isinstance(state, Following):
            return ZERO, False
        survey, follower = self.surroundings.survey, state.follower
        ahead = follower.blocked_in(survey)
        limit = self._now.speed_limit
        if ahead < math.inf:
            limit = min(limit, self._limits.approach(ahead - _STOP_BEFORE_M))
        wanted = follower.steer(pose, survey, self._ramp.twist.linear, limit)
        if wanted is None and distance(pose, self._goal) > 2 * self._tuning.goal_distance:
            self._state = Standing()
            return ZERO, False
        return wanted, ahead < _LOOK_AHEAD_M
