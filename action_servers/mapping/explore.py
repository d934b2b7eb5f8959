"""The maneuver behind ExploreFrontiers: drive to the edges of the map until none remains."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from action_servers.core.action import Action
from action_servers.core.limits import UNBOUNDED, NumberLimit
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Grid,
    Observation,
    Value,
    missing,
)
from action_servers.core.progress import ChangedFields
from action_servers.mapping.frontiers import Frontier, Target, choose, frontiers
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.path import NavigationTuning
from action_servers.navigation.planner import Point
from action_servers.navigation.surroundings import PLAN, Surroundings, ignore
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.robots.model import RobotModel

GIVEN_UP_M = 0.35
"""Frontier cells within this distance of a given-up frontier are not tried again."""

GONE_M = 0.30
"""A frontier is gone when no frontier cell is within this distance of its middle."""

NEWS_M2 = 2.0
"""Area newly known from which the choice of a frontier is made afresh."""

_SIGN_OF_LIFE_S = 1.0
_STILL_MAP = "the map has not changed since the goal began; is a mapper running?"

_NO_WAY = (ErrorCode.GOAL_OCCUPIED, ErrorCode.GOAL_OUTSIDE_MAP, ErrorCode.NO_VALID_PATH)

_OURS = {
    ErrorCode.TF_ERROR_WHILE_DRIVING: ErrorCode.NO_MAP,
    ErrorCode.TF_ERROR_WHILE_PLANNING: ErrorCode.NO_MAP,
    ErrorCode.CONTROLLER_TIMED_OUT: ErrorCode.NO_SCAN,
}
"""The codes of missing senses of a drive on the map, as this action numbers them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontierTuning(NavigationTuning):
    """With the servers' parameters `frontiers.*`."""

    PREFIX: ClassVar = "frontiers."

    min_length: float = number(
        0.4,
        (0.05, 100.0),
        "Length of the shortest frontier worth a visit where a goal says 0, m: a Waffle passes "
        "where 0.5 m is free, and a cell on either side is the seam of the wall.",
    )
    map_wait: float = number(
        5.0,
        (0.5, 600.0),
        "How long it waits for a map, and for the robot's place on it, before it gives up, s.",
    )
    settle: float = number(
        2.5,
        (0.5, 60.0),
        "How long it stands and looks before it believes what the map says of frontiers, s: the "
        "map comes once a second, and a cell is free when two scans say so.",
    )


FRONTIERS = FrontierTuning()
"""The defaults."""


FRONTIERS = FrontierTuning()
"""The defaults."""

LIMITS = (
    NumberLimit(field="max_duration", low=0.0, high=86_400.0, unit="s", source="a day"),
    NumberLimit(
        field="min_frontier",
        low=0.05,
        high=100.0,
        unit="m",
        source="a cell of the map",
        zero="the server's default",
    ),
)
"""The shortest frontier is a cell of a map of the usual resolution."""


def plan(
    goal: Any,
    _now: Observation,
    robot: RobotModel,
    tuning: FrontierTuning = FRONTIERS,
    publish: Callable[[Fields], object] = ignore,
) -> ExploreFrontiers:
    """Return the maneuver for a goal. It waits for a map that has not arrived yet."""
    shortest = goal.min_frontier or tuning.min_length
    around = Surroundings(robot, tuning, publish)
    return ExploreFrontiers(robot, goal.max_duration, shortest, tuning, around)


class ExploreFrontiers:
    """Drives to the best frontier, and to the next when that is gone; needs a map that grows.

    `max_duration` is in seconds, 0 for no limit, `shortest` in metres. A frontier without a path,
    or one that stays although the robot has been there, is ignored. One that could not be reached
    is given up, and the goal ends aborted when only such ones remain.
    """

    needs_base = True

    def __init__(
        self,
        robot: RobotModel,
        max_duration: float,
        shortest: float,
        tuning: FrontierTuning = FRONTIERS,
        surroundings: Surroundings | None = None,
    ) -> None:
        self._robot = robot
        self._tuning = tuning
        self._max_duration = max_duration or math.inf
        self._shortest = shortest
        self.surroundings = surroundings or Surroundings(robot)
        """The state of the world."""
        self._grid: Grid | None = None
        self._maps = 0
        self._area = 0.0
        self._left: list[Frontier] = []
        self._target: Target | None = None
        self._area_at_choice = 0.0
        self._leg: NavigateToPose | None = None
        self._twist = ZERO
        self._settled_s: float | None = None
        self._seen: list[Point] = []
        self._failed: list[Point] = []
        self._shut: list[Point] = []
        self._failure: Finished | None = None
        self._visited = 0
        self._start_s: float | None = None
        self._time_s = 0.0
        self._changed = ChangedFields(again_s=_SIGN_OF_LIFE_S)

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the twist for this control step, or how the goal ends."""
        if self._start_s is None:
            self._start_s = now.time_s
        self._time_s = now.time_s
        elapsed_s = now.time_s - self._start_s
        if elapsed_s >= self._max_duration - 1e-6:
            return self._out_of_time()
        unready = missing(now)
        if unready is not None and self._leg is None:
            # Once it drives, the leg watches over scan and pose.
            if elapsed_s >= self._tuning.map_wait:
                return Finished("aborted", _code_for(now), unready)
            return ZERO
        self._take_in(now)
        answer = self._go_on(now)
        self._twist = ZERO if isinstance(answer, Finished) else answer
        return answer

    def feedback(self) -> Fields | None:
        """Return the frontiers left and the known area: when they change, and once a second."""
        telling: dict[str, Value] = {"frontiers_left": len(self._left), "area_mapped": self._area}
        return self._changed.of(telling, self._time_s)

    def result(self) -> Fields:
        """Return the number of frontiers that were driven to until gone, and the known area."""
        return {"frontiers_visited": self._visited, "area_mapped": self._area}

    def _take_in(self, now: Observation) -> None:
        """Handle a new map: known area, remaining frontiers, and whether the target is one."""
        self.surroundings.observe(now)
        grid = now.grid
        if grid is None or grid is self._grid:
            return
        self._grid = grid
        self._maps += 1
        self._area = float((grid.cells >= 0).sum()) * grid.resolution**2
        self._find()
        target = self._target
        if target is None:
            return
        if not self._is_left(target.frontier):
            self._visited += 1
            self._target = None
        elif self._area - self._area_at_choice >= NEWS_M2:
            self._target = None

    def _find(self) -> None:
        assert self._grid is not None
        given_up = self._seen + self._failed
        self._left = frontiers(self._grid, self._shortest, given_up, GIVEN_UP_M)

    def _is_left(self, frontier: Frontier) -> bool:
        x, y = frontier.middle
        return any(
            bool((abs(other.points - (x, y)).max(axis=1) <= GONE_M).any()) for other in self._left
        )

    def _go_on(self, now: Observation) -> Twist2D | Finished:
        if self._settled_s is not None:
            if now.time_s < self._settled_s - 1e-6:
                return ZERO
            self._settled_s = None
            if self._target is not None:
                if self._maps == 1:
                    return Finished("aborted", ErrorCode.NO_MAP, _STILL_MAP)
                # It has been there and looked, and the frontier is still there.
                self._give_up(self._target, self._seen)
            return self._choose(now, settled=True)
        if self._target is None or self._leg is None:
            return self._choose(now, settled=False)
        answer = self._leg.step(now)
        if not isinstance(answer, Finished):
            return answer
        self._leg = None
        if answer.status == "succeeded":
            return self._settle(now)
        if answer.error_code in _OURS:
            return Finished("aborted", _OURS[ErrorCode(answer.error_code)], answer.reason)
        if answer.error_code in _NO_WAY:
            self._turn_away(self._target)
        else:
            self._failure = answer
            self._give_up(self._target, self._failed)
        return ZERO

    def _settle(self, now: Observation) -> Twist2D:
        self._leg = None
        self._settled_s = now.time_s + self._tuning.settle
        return ZERO

    def _turn_away(self, target: Target) -> None:
        """Drop a target that the map has cut off meanwhile; ignore it if that happens again."""
        if any(math.dist(place, target.frontier.middle) <= GIVEN_UP_M for place in self._shut):
            self._give_up(target, self._seen)
        self._shut.append(target.frontier.middle)
        self._target = None

    def _give_up(self, target: Target, where: list[Point]) -> None:
        where.append(target.frontier.middle)
        self._target = None
        self._find()

    def _choose(self, now: Observation, *, settled: bool) -> Twist2D | Finished:
        """Start a leg to the best frontier; look again before concluding that there is none."""
        self._target = None
        if now.map_pose is None or not self.surroundings.ready:
            return self._not_ready(now)
        self._target, _ = choose(self._left, self.surroundings.roads, now.map_pose)
        if self._target is None:
            return self._all_done() if settled else self._settle(now)
        self._area_at_choice = self._area
        self._leg = NavigateToPose(self._target.pose, self._robot, self.surroundings, self._twist)
        answer = self._leg.step(now)
        # A leg that is over at once is looked into at the next step.
        return ZERO if isinstance(answer, Finished) else answer

    def _not_ready(self, now: Observation) -> Twist2D | Finished:
        if self._start_s is None or now.time_s - self._start_s < self._tuning.map_wait:
            return ZERO
        within = f"within {self._tuning.map_wait:g} s"
        reason = f"no scan could be placed on the map {within}; do the clocks agree?"
        return Finished("aborted", ErrorCode.NO_SCAN, reason)

    def _all_done(self) -> Finished:
        if self._failure is None:
            return SUCCEEDED
        reason = f"{len(self._failed)} of the frontiers could not be driven to, the last because "
        return Finished("aborted", ErrorCode.BLOCKED, reason + self._failure.reason)

    def _out_of_time(self) -> Finished:
        reason = f"max_duration, {self._max_duration:g} s, is over; frontiers left: "
        return Finished("aborted", ErrorCode.UNKNOWN, reason + str(len(self._left)))


def _code_for(now: Observation) -> ErrorCode:
    if now.odom is None:
        return ErrorCode.NO_ODOMETRY
    return ErrorCode.NO_SCAN if now.scan is None else ErrorCode.NO_MAP


EXPLORE_FRONTIERS = Action(
    name="explore_frontiers",
    type="bt_mission_interfaces/action/ExploreFrontiers",
    needs=("base", "scan", "odometry", "map"),
    example={"max_duration": 120.0, "min_frontier": 0.5},
    plan=plan,
    tuning=FRONTIERS,
    topic=PLAN,
    limits=lambda _robot, _tuning: LIMITS,
    feedback=lambda _goal: {"frontiers_left": UNBOUNDED, "area_mapped": UNBOUNDED},
    waits=True,
)
