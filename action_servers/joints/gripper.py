"""Open or close a gripper, as ros2_control's GripperActionController does.

A goal succeeds at its position, or where the gripper stalls: then it holds something, and presses
on. The result says which (`reached_goal`, `stalled`).
"""

from __future__ import annotations

from typing import Any

from action_servers.core.action import Action, JointCommands
from action_servers.core.limits import Limits, NumberLimit
from action_servers.core.maneuver import ZERO, Fields, Finished, Observation
from action_servers.core.progress import ChangedFields, Ticker
from action_servers.core.tuning import TUNING, Tuning
from action_servers.joints.trajectory import JointManeuver, holding
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.joints import GripperModel
from bt_mission.robots.model import RobotModel

STALL_VELOCITY, STALL_S = 0.001, 1.0
"""m/s or rad/s below which a gripper stands, and for how long: defaults of ros2_controllers."""


def limits(robot: RobotModel, _tuning: Tuning) -> Limits:
    """Return the limits of a robot's gripper."""
    gripper = robot.gripper
    if gripper is None:
        return ()
    source = "gripper of the robot"
    return (
        NumberLimit(
            field="command.position", low=gripper.min, high=gripper.max, unit="m", source=source
        ),
        NumberLimit(
            field="command.max_effort",
            low=0.0,
            high=gripper.max_effort,
            unit="N",
            source=source,
            zero="max_effort of the gripper",
        ),
    )


def plan(
    goal: Any, _now: Observation, robot: RobotModel, joints: JointCommands, tuning: Tuning = TUNING
) -> Grip:
    """Return the maneuver for a goal."""
    assert robot.gripper is not None
    effort = goal.command.max_effort or robot.gripper.max_effort
    return Grip(goal.command.position, effort, robot.gripper, joints, tuning)


class Grip(JointManeuver):
    """Sends all joints of a gripper to one position."""

    def __init__(
        self,
        position: float,
        effort: float,
        gripper: GripperModel,
        joints: JointCommands,
        tuning: Tuning,
    ) -> None:
        super().__init__(gripper.joints, joints)
        self._goal, self._effort, self._gripper = position, effort, gripper
        self._timeout_s = tuning.sensor_timeout
        self._ticker = Ticker()
        self._changes = ChangedFields()
        self._stands_since_s: float | None = None
        self._position, self._force = 0.0, 0.0
        self._is_stalled = self._is_there = False

    def step(self, now: Observation) -> Twist2D | Finished:
        """Command the position, or end."""
        joints = self.measured(now, self._timeout_s)
        if isinstance(joints, Finished):
            return joints
        self._ticker.update(now.time_s)
        names = self._names
        positions = [joints.positions[name] for name in names]
        self._position = sum(positions) / len(names)
        self._force = max(abs(joints.efforts.get(name, 0.0)) for name in names)
        self._is_there = all(
            abs(each - self._goal) <= self._gripper.tolerance for each in positions
        )
        moves = max(abs(joints.velocities.get(name, 0.0)) for name in names) > STALL_VELOCITY
        if moves or self._stands_since_s is None:
            self._stands_since_s = now.time_s
        self._is_stalled = not self._is_there and now.time_s - self._stands_since_s >= STALL_S
        if self._is_there or self._is_stalled:
            return self.succeeded()
        self._joints.send(names, [self._goal] * len(names), [self._effort] * len(names))
        return ZERO

    def feedback(self) -> Fields | None:
        """Return position and force, once a second and at the end."""
        if not (self._ticker.take() or self._is_over):
            return None
        return self._changes.of(self.result())

    def result(self) -> Fields:
        """Return position and force, and whether it stalled or got there."""
        return {
            "position": self._position,
            "effort": self._force,
            "stalled": self._is_stalled,
            "reached_goal": self._is_there,
        }


GRIPPER_COMMAND = Action(
    name="gripper_controller/gripper_cmd",
    type="control_msgs/action/GripperCommand",
    needs=("gripper",),
    short="",
    example={"command": {"position": 0.019, "max_effort": 0.0}},
    plan=plan,
    limits=limits,
    during=holding,
)
