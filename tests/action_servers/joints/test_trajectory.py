"""Trajectories of an arm and a gripper: acceptance, course, tolerances and ends, without ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from control_msgs.action import FollowJointTrajectory, GripperCommand
from control_msgs.msg import JointTolerance

from action_servers.core.maneuver import ZERO, Finished, JointReadings, Observation, Refusal
from action_servers.joints import gripper, trajectory
from action_servers.joints.trajectory import Code
from bt_mission.robots.model import load_robot
from bt_mission.ros.interface_types import fill

ROBOT = load_robot("waffle_arm")
ARM = ("joint1", "joint2", "joint3", "joint4")
FINGERS = ("gripper_left_joint", "gripper_right_joint")
STEP_S = 0.05


class Joints:
    """Joints that are where they were sent a step ago, but for `stuck` ones."""

    def __init__(self) -> None:
        self.time_s = 10.0
        self.positions = dict.fromkeys((*ARM, *FINGERS), 0.0)
        self.wanted: dict[str, float] = {}
        self.stuck: dict[str, float] = {}
        self.sent: list[dict[str, float]] = []
        self._speeds = dict.fromkeys(self.positions, 0.0)

    def send(
        self, names: Sequence[str], positions: Sequence[float], _efforts: Sequence[float] = ()
    ) -> None:
        """Keep a command."""
        self.wanted = dict(zip(names, positions, strict=True))
        self.sent.append(self.wanted)

    def step(self) -> None:
        """Let a control step pass."""
        before = dict(self.positions)
        self.positions |= self.wanted
        self.positions |= {name: min(self.positions[name], at) for name, at in self.stuck.items()}
        self._speeds = {n: (self.positions[n] - at) / STEP_S for n, at in before.items()}
        self.time_s = round(self.time_s + STEP_S, 6)

    def observe(self) -> Observation:
        """Return what the servers know."""
        readings = JointReadings(self.time_s, dict(self.positions), self._speeds, {})
        return Observation(self.time_s, joints=readings)


def goal(*points: Mapping[str, Any], names: Sequence[str] = ARM, **fields: Any) -> Any:
    """A goal with these points."""
    written = {"trajectory": {"joint_names": list(names), "points": list(points)}, **fields}
    return fill(FollowJointTrajectory.Goal(), written)


def to(*positions: float, after: float = 2.0, **fields: Any) -> dict[str, Any]:
    """A point of a trajectory."""
    return {"positions": list(positions), "time_from_start": after, **fields}


def planned(message: Any, joints: Joints) -> Any:
    """Return what becomes of a goal."""
    return trajectory.plan(message, joints.observe(), ROBOT, joints)


def run(maneuver: Any, joints: Joints, most: int = 200) -> tuple[Finished, float]:
    """Step a maneuver until its end; return it and its time, s."""
    start_s = joints.time_s
    for _ in range(most):
        answer = maneuver.step(joints.observe())
        if isinstance(answer, Finished):
            return answer, round(joints.time_s - start_s, 6)
        assert answer == ZERO
        joints.step()
    raise AssertionError("the maneuver does not end")


TARGET = to(1.0, -0.5, 0.2, 0.0)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (goal(TARGET, names=["joint1", "joint2", "joint3", "joint5"]), "did you mean 'joint"),
        (goal(TARGET, names=["joint1", "joint1", "joint3", "joint4"]), "'joint1' is named twice"),
        (goal(to(0.0, 0.0, 0.0), names=ARM[:3]), "must name all joints; missing: joint4"),
        (goal(), "expected 1 to 1,000, got 0"),
        (goal(to(1.0)), "trajectory.points[0]: expected 4 positions, got 1"),
        (goal(to(0.0, 1.6, 0.0, 0.0)), "joint2 must be from -1.79 to 1.57, got 1.6"),
        (goal(to(0.0, 0.0, 0.0, 0.0), TARGET), "time_from_start must increase"),
        (
            goal(to(1.0, 0.0, 0.0, 0.0, after=0.2)),
            "joint1 would move at 5 a second, the limit is 4.8",
        ),
        (goal(to(1.0, 0.0, 0.0, 0.0, after=0.0)), "is at 0, and cannot be at 1 after 0 s"),
        (goal(TARGET, path_tolerance=[{"name": "elbow"}]), "path_tolerance: no joint 'elbow'"),
        (
            goal(TARGET, goal_tolerance=[{"name": "joint1", "position": -2.0}]),
            "goal_tolerance of joint1: expected 0 or more, or -1 for any, got -2",
        ),
    ],
)
def test_a_goal_that_the_arm_cannot_follow_is_refused(message: Any, reason: str) -> None:
    """With the field, what was expected and what was got; nothing is sent."""
    joints = Joints()
    refused = planned(message, joints)
    assert isinstance(refused, Refusal)
    assert reason in refused.reason
    assert joints.sent == []


def test_numbers_are_finite() -> None:
    """NaN compares with no limit."""
    message = goal(TARGET)
    message.trajectory.points[0].positions[1] = math.nan
    refused = planned(message, Joints())
    assert refused == Refusal("trajectory.points[0]: expected finite positions and velocities")


def test_a_trajectory_of_the_past_is_refused() -> None:
    """Its stamp and its last time lie before now."""
    message = goal(TARGET)
    message.trajectory.header.stamp.sec = 5
    refused = planned(message, Joints())
    assert refused == Refusal(
        "trajectory.header.stamp is too old: the last point was due 3.00 s ago"
    )


def test_joints_follow_the_course_and_end_at_its_time() -> None:
    """At constant speed; the goal succeeds at the first step after its time."""
    joints = Joints()
    end, time_s = run(planned(goal(TARGET), joints), joints)
    assert (end.status, time_s) == ("succeeded", 2.0)
    assert joints.sent[0]["joint1"] == pytest.approx(0.025)
    assert joints.sent[19]["joint1"] == pytest.approx(0.5)
    assert joints.positions["joint2"] == pytest.approx(-0.5)


def test_between_velocities_the_course_is_a_cubic() -> None:
    """From rest to rest, half of the way after half of the time, and slow at both ends."""
    joints = Joints()
    rest = [0.0] * 4
    run(planned(goal(to(1.0, 0.0, 0.0, 0.0, velocities=rest)), joints), joints)
    way = [sent["joint1"] for sent in joints.sent]
    assert way[19] == pytest.approx(0.5)
    assert way[0] == pytest.approx(3 * 0.025**2 - 2 * 0.025**3)


def test_a_joint_that_leaves_its_path_ends_the_goal_where_it_is() -> None:
    """Code -4; at the end all joints are sent to where they are."""
    joints = Joints()
    joints.stuck = {"joint1": 0.3}
    tolerance = [JointTolerance(name="joint1", position=0.11)]
    message = goal(TARGET)
    message.path_tolerance = tolerance
    maneuver = planned(message, joints)
    with trajectory.holding(maneuver, ""):
        end, time_s = run(maneuver, joints)
    assert (end.status, end.error_code, time_s) == ("aborted", Code.PATH_TOLERANCE_VIOLATED, 0.85)
    assert end.reason == "joint1 is 0.125 from its path, the tolerance is 0.11"
    assert joints.sent[-1]["joint1"] == 0.3


@pytest.mark.parametrize(("allowed", "end_s"), [(0.0, 3.0), (0.5, 2.5)])
def test_a_goal_that_is_not_reached_ends_after_its_tolerance_of_time(
    allowed: float, end_s: float
) -> None:
    """Code -5; 0 is the default of a second."""
    joints = Joints()
    joints.stuck = {"joint1": 0.9}
    maneuver = planned(goal(TARGET, goal_time_tolerance=allowed), joints)
    end, time_s = run(maneuver, joints)
    assert (end.status, end.error_code, time_s) == ("aborted", Code.GOAL_TOLERANCE_VIOLATED, end_s)


def test_any_error_is_allowed_with_a_tolerance_of_minus_one() -> None:
    """As the definition says."""
    joints = Joints()
    joints.stuck = {"joint1": 0.9}
    tolerance = [{"name": "joint1", "position": -1.0}]
    end, time_s = run(planned(goal(TARGET, goal_tolerance=tolerance), joints), joints)
    assert (end.status, time_s) == ("succeeded", 2.0)


def test_a_cancel_stops_the_joints_where_they_are() -> None:
    """And so does any end from outside; a regular end sends nothing more."""
    joints = Joints()
    maneuver = planned(goal(TARGET), joints)
    with trajectory.holding(maneuver, ""):
        for _ in range(10):
            maneuver.step(joints.observe())
            joints.step()
        maneuver.step(joints.observe())
    assert joints.sent[-1] == {name: joints.positions[name] for name in ARM}
    assert joints.positions["joint1"] == pytest.approx(0.25)


def grip(position: float, joints: Joints) -> Any:
    """Return the maneuver of a gripper's goal."""
    message = fill(GripperCommand.Goal(), {"command": {"position": position}})
    return gripper.plan(message, joints.observe(), ROBOT, joints)


def test_a_gripper_gets_there_or_stalls() -> None:
    """It holds something where it stands for a second short of its goal."""
    joints = Joints()
    free = grip(-0.01, joints)
    assert run(free, joints)[0].status == "succeeded"
    assert (free.result()["reached_goal"], free.result()["stalled"]) == (True, False)
    joints.stuck = dict.fromkeys(FINGERS, 0.005)
    holding = grip(0.019, joints)
    end, time_s = run(holding, joints)
    assert (end.status, time_s) == ("succeeded", 1.05)
    assert (holding.result()["reached_goal"], holding.result()["stalled"]) == (False, True)
    assert holding.result()["position"] == pytest.approx(0.005)


def test_joints_that_fall_silent_end_the_goal() -> None:
    """After a second, with the age of the last message."""
    joints = Joints()
    maneuver = planned(goal(TARGET), joints)
    now = joints.observe()
    late = Observation(now.time_s + 1.5, joints=now.joints)
    end = maneuver.step(late)
    assert isinstance(end, Finished)
    assert end.reason == "no joint_states for 1 s: the last is 1.50 s old"
