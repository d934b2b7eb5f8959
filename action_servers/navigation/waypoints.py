"""The maneuvers of FollowWaypoints and NavigateThroughPoses.

One stops at each pose, for some rounds; the other passes some poses on its way to the last one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Observation,
    Value,
)
from action_servers.core.progress import ChangedFields
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.surroundings import Surroundings
from bt_mission.base.geometry import Pose2D, Twist2D, distance
from bt_mission.robots.model import RobotModel

_SIGN_OF_LIFE_S = 1.0


class FollowWaypoints:
    """Drives to poses in turn; each ends with a stop, turned to its yaw."""

    needs_base = True

    def __init__(
        self,
        poses: Sequence[Pose2D],
        robot: RobotModel,
        surroundings: Surroundings,
        *,
        loops: int = 0,
        first: int = 0,
    ) -> None:
        """Make a maneuver through `poses` in the map frame, beginning at the index `first`.

        `loops` is the number of rounds after the first one; these begin at index 0, as in Nav2.
        With `stop_on_failure` in the tuning of the surroundings, the first pose that is not reached
        ends the goal.
        """
        self._poses = tuple(poses)
        self._robot = robot
        self.surroundings = surroundings
        """The state of the world."""
        self._loops_left = loops
        self._index = first
        self._leg: NavigateToPose | None = None
        self._missed: list[Fields] = []
        self._time_s: float | None = None
        self._changed = ChangedFields(again_s=_SIGN_OF_LIFE_S)

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the twist for this control step, or how the goal ends."""
        self._time_s = now.time_s
        if not self._poses:
            return Finished("aborted", ErrorCode.WAYPOINTS_UNKNOWN, "the list of poses is empty")
        if self._leg is None:
            self._leg = NavigateToPose(self._poses[self._index], self._robot, self.surroundings)
        answer = self._leg.step(now)
        if not isinstance(answer, Finished):
            return answer
        if answer.status == "aborted":
            missed: dict[str, Value] = {
                "index": self._index,
                "goal": self._poses[self._index],
                "error_code": answer.error_code,
            }
            self._missed.append(missed)
            if self.surroundings.tuning.stop_on_failure:
                place = f"waypoint {self._index} (of 0 to {len(self._poses) - 1})"
                reason = f"{place} was not reached, code {answer.error_code}: {answer.reason}"
                return Finished("aborted", ErrorCode.WAYPOINTS_UNKNOWN, reason)
        return SUCCEEDED if self._last_leg() else ZERO

    def feedback(self) -> Fields | None:
        """Return the index of the pose driven to: when it changes, and once a second."""
        if not self._poses or self._time_s is None:
            return None
        return self._changed.of({"current_waypoint": self._index}, self._time_s)

    def result(self) -> Fields:
        """Return the poses that were not reached, each with the code of its reason."""
        return {"missed_waypoints": list(self._missed)}

    def _last_leg(self) -> bool:
        """Continue with the next pose or round. Return whether there is none."""
        self._leg = None
        if self._index + 1 < len(self._poses):
            self._index += 1
            return False
        if self._loops_left == 0:
            return True
        self._loops_left -= 1
        self._index = 0
        return False


class NavigateThroughPoses:
    """Drives past poses in turn, whatever their yaw, and stops at the last, turned to its yaw.

    A pose is passed when the robot comes as near as `passing_distance` of the tuning.
    """

    needs_base = True

    def __init__(
        self, poses: Sequence[Pose2D], robot: RobotModel, surroundings: Surroundings
    ) -> None:
        """Make a maneuver through `poses`, at least one, in the map frame."""
        self._poses = tuple(poses)
        self._robot = robot
        self.surroundings = surroundings
        """The state of the world."""
        self._index = 0
        self._twist = ZERO
        self._leg = self._new_leg()
        self._start_s: float | None = None
        self._time_s = 0.0
        self._fastest = robot.max_linear_velocity
        self._recoveries = 0

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the twist for this control step, or how the goal ends."""
        self._start_s = now.time_s if self._start_s is None else self._start_s
        self._time_s = now.time_s
        self._fastest = min(self._robot.max_linear_velocity, now.speed_limit)
        while not self._at_last and self._passes(now.map_pose):
            self._go_on()
        answer = self._leg.step(now)
        if not isinstance(answer, Finished):
            self._twist = answer
            return answer
        if answer.status == "succeeded" and not self._at_last:
            self._twist = ZERO
            self._go_on()
            return ZERO
        if answer.status == "aborted" and len(self._poses) > 1:
            place = f"pose {self._index} (of 0 to {len(self._poses) - 1})"
            reason = f"{place} was not reached: {answer.reason}"
            return Finished("aborted", answer.error_code, reason)
        return answer

    def feedback(self) -> Mapping[str, Value] | None:
        """Return the fields of Nav2's feedback: metres, seconds, poses in the map frame."""
        fields = self._leg.feedback()
        if fields is None or self._start_s is None:
            return None
        left, seconds = fields["distance_remaining"], fields["estimated_time_remaining"]
        assert isinstance(left, float)
        assert isinstance(seconds, float)
        beyond = sum(distance(*pair) for pair in pairwise(self._poses[self._index :]))
        return {
            **fields,
            "navigation_time": self._time_s - self._start_s,
            "number_of_recoveries": self._recoveries + self._leg.recoveries,
            "distance_remaining": left + beyond if left else 0.0,
            "estimated_time_remaining": seconds + beyond / self._fastest,
            "number_of_poses_remaining": len(self._poses) - self._index,
        }

    def result(self) -> Mapping[str, Value]:
        """Return no fields: Nav2's result has none."""
        return {}

    @property
    def _at_last(self) -> bool:
        return self._index == len(self._poses) - 1

    def _passes(self, pose: Pose2D | None) -> bool:
        away = math.inf if pose is None else distance(pose, self._poses[self._index])
        return away < self.surroundings.tuning.passing_distance

    def _go_on(self) -> None:
        self._recoveries += self._leg.recoveries
        self._index += 1
        self._leg = self._new_leg()

    def _new_leg(self) -> NavigateToPose:
        return NavigateToPose(
            self._poses[self._index],
            self._robot,
            self.surroundings,
            self._twist,
            may_stop=len(self._poses) == 1,
        )
