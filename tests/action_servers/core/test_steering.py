"""Facts about the motions of cars and of bases that slide, as the governor allows them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from nav2_msgs.action import DriveOnHeading

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, Reason, Scan
from action_servers.driving.straight import Straight, misfit, plan_drive_on_heading
from action_servers.driving.turn import Turn
from action_servers.robot_io.messages import ScanMerger
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import load_robot
from tests.support.fake_robot import FakeRobot, Wall, in_the_open

CAR, SLIDER = load_robot("f1tenth"), load_robot("rosbot")


def box(front: float, rear: float, left: float, right: float) -> list[Wall]:
    """Four walls around the origin."""
    return [
        (front, right, front, left),
        (rear, right, rear, left),
        (rear, left, front, left),
        (rear, right, front, right),
    ]


def test_every_twist_of_a_car_is_one_that_it_can_drive():
    """Never a turn on the spot, and no arc sharper than its steering."""
    governor = Governor(CAR)
    for linear in (-0.5, -0.1, 0.0, 0.1, 0.5):
        for angular in (-0.6, 0.0, 0.6):
            now = governor.look(in_the_open(1.0))
            twist = governor.allow(Twist2D(linear, angular), now).twist
            assert abs(twist.angular) <= CAR.drive.max_curvature * abs(twist.linear) + 1e-9
            assert math.copysign(1.0, twist.angular) == math.copysign(1.0, angular)


@pytest.mark.parametrize("angle_deg", [-180, -60, 90, 180])
def test_a_car_turns_in_strokes_near_its_place(angle_deg):
    """Ahead and back, by 0.4 rad each; it ends at the angle, within 0.6 m of its place."""
    base = FakeRobot(CAR)
    end = base.run(Turn(math.radians(angle_deg), 0.6, CAR))
    assert end.status == "succeeded"
    assert math.degrees(base.yaw) == pytest.approx(angle_deg, abs=1.0)
    assert math.hypot(base.x, base.y) < 0.6
    directions = {math.copysign(1.0, twist.linear) for twist in base.twists if twist.linear}
    assert directions == {1.0, -1.0}


def test_a_stroke_ends_before_a_wall_and_the_turn_goes_on():
    """0.25 m ahead and behind are enough for a turn of 90 degrees in more strokes."""
    base = FakeRobot(CAR, box(CAR.hull.front + 0.25, CAR.hull.rear - 0.25, 3.0, -3.0))
    end = base.run(Turn(math.radians(40), 0.6, CAR), limit_s=120.0)
    assert end.status == "succeeded"
    assert abs(math.degrees(base.yaw) - 40) < 1.0


def test_a_car_that_is_boxed_in_stands():
    """Neither stroke has room: the goal ends with the reason, and nothing was touched."""
    hull = CAR.hull
    base = FakeRobot(CAR, box(hull.front + 0.02, hull.rear - 0.02, 0.3, -0.3))
    end = base.run(Turn(1.0, 0.6, CAR))
    assert (end.status, abs(base.x) < 0.02) == ("aborted", True)


def test_no_base_drives_back_where_no_lidar_looks():
    """A car without its lidar at the rear drives ahead only."""
    blind = type(CAR).model_validate(CAR.model_dump() | {"lidars": {}})
    assert (CAR.sees_behind, blind.sees_behind) == (True, False)
    governor = Governor(blind)
    allowed = governor.allow(Twist2D(-0.2, 0.0), governor.look(in_the_open(1.0)))
    assert (allowed.twist, allowed.held_by) == (ZERO, Reason.OBSTACLE)
    ahead = Twist2D(0.2, 0.0)
    assert governor.allow(ahead, governor.look(in_the_open(1.1))).twist == ahead


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slide_stops_before_a_wall(side):
    """The gap that is left is the governor's margin, and nothing is touched."""
    wall = side * (SLIDER.hull.half_width + 0.5)
    base = FakeRobot(SLIDER, [(-2.0, wall, 2.0, wall)])
    governor = base.governor
    governor.begin()
    for _ in range(100):
        now = governor.look(base.observe())
        base.move(governor.allow(Twist2D(0.0, 0.0, side * 0.4), now).twist)
    gap = abs(wall - base.y) - SLIDER.hull.half_width
    assert 0.02 < gap < 0.08


def test_drive_on_heading_slides_to_a_point_aside():
    """The base keeps its heading; another base refuses the goal as Nav2 does."""
    goal = DriveOnHeading.Goal(speed=0.3)
    goal.target.x, goal.target.y = 0.3, -0.4
    base = FakeRobot(SLIDER)
    maneuver = plan_drive_on_heading(goal, in_the_open(1.0), SLIDER)
    assert isinstance(maneuver, Straight)
    assert base.run(maneuver).status == "succeeded"
    assert misfit(goal, SLIDER, backwards=False) is None
    assert misfit(goal, CAR, backwards=False) == "target.y and target.z must be 0, got -0.4 and 0"
    assert (base.x, base.y, base.yaw) == pytest.approx((0.3, -0.4, 0.0), abs=0.01)


def test_a_base_that_cannot_slide_is_never_commanded_to():
    """Whatever a maneuver wants."""
    governor = Governor(CAR)
    now = governor.look(in_the_open(1.0))
    assert governor.allow(Twist2D(0.2, 0.0, 0.3), now).twist.lateral == 0.0


def test_the_scans_of_two_lidars_are_one_around_the_first():
    """Each direction has its nearest point; the stamp is the oldest; until all are there, none."""
    lidars = tuple(CAR.all_lidars.values())
    merger = ScanMerger(lidars)
    base = FakeRobot(CAR, box(2.0, -1.5, 1.0, -1.0))
    ahead = base.observe().scan
    assert ahead is not None
    assert merger.merged([ahead, None]) is None
    around = np.full(360, 0.7, dtype=np.float32)
    rear = Scan(9.5, -math.pi, math.tau / 360, 0.06, 10.0, around)
    merged = merger.merged([ahead, rear])
    assert merged is not None
    assert merged is merger.merged([ahead, rear])
    assert merged.stamp_s == 9.5
    behind = round(math.pi / merged.angle_increment)
    assert merged.ranges[behind] == pytest.approx(0.7 + lidars[0].x - lidars[1].x, abs=0.01)
    assert merged.ranges[0] == pytest.approx(0.7 - (lidars[0].x - lidars[1].x), abs=0.01)
