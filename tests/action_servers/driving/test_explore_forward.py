"""Facts about driving forward until something is near."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from action_servers.core.maneuver import ErrorCode, Finished
from action_servers.driving.explore_forward import EXPLORING, ExploreForward, ExploreTuning, limits
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel
from tests.support.thorough import sample


def wall_ahead(robot: RobotModel, gap: float) -> list[tuple[float, float, float, float]]:
    """A wall across the way, `gap` metres in front of the hull."""
    x = robot.hull.front + gap
    return [(x, -2.0, x, 2.0)]


@pytest.mark.parametrize(
    ("gap", "speed"),
    sample(itertools.product([0.6, 1.0, 1.3, 2.2], [0.05, 0.1, 0.2, 0.22]), every=3),
)
def test_stands_at_the_stopping_distance(fake, robot, gap, speed):
    """It stands within 5 mm of the stopping distance, measured from the hull, at any speed."""
    base = fake(robot, wall_ahead(robot, gap))
    explore: Any = ExploreForward(speed, 0.5, robot)

    assert base.run(explore) == Finished("succeeded")

    true_gap = gap - base.x
    assert true_gap == pytest.approx(0.5, abs=0.005)
    assert base.linear == pytest.approx(0.0, abs=0.01)
    assert explore.result()["closest_obstacle"] == pytest.approx(true_gap, abs=0.005)
    assert explore.result()["total_distance_travelled"] == pytest.approx(base.x, abs=0.002)


def test_drives_at_the_speed_it_was_given(fake, waffle):
    """Far from everything, it commands exactly the goal's speed, straight ahead."""
    base = fake(waffle)
    base.run_for(ExploreForward(0.2, 0.5, waffle), 2.0)
    assert set(base.twists) == {Twist2D(0.2, 0.0)}


def test_slows_down_without_a_jerk(fake, waffle):
    """Speed falls steadily, and no faster than the base can follow but for the last 5 cm/s."""
    base = fake(waffle, wall_ahead(waffle, 1.5))
    base.run(ExploreForward(0.26, 0.5, waffle))
    speeds = [twist.linear for twist in base.twists]
    falls = -np.diff(speeds)
    assert falls.min() >= 0.0
    assert falls.max() <= 0.06
    assert np.count_nonzero(falls) >= 8


def test_an_obstacle_already_near_ends_the_goal_without_moving(fake, waffle):
    """Nothing but zero is commanded when the stopping distance is already reached."""
    base = fake(waffle, wall_ahead(waffle, 0.4))
    assert base.run(ExploreForward(0.2, 0.5, waffle)) == Finished("succeeded")
    assert base.x == 0.0


def test_stops_for_what_is_narrower_than_a_ray_arc_sees(fake, waffle):
    """A post in front of a wheel stops it, though it stands 31 degrees beside straight ahead."""
    edge = waffle.hull.half_width
    x = waffle.hull.front + 0.9
    base = fake(waffle, [(x, edge - 0.02, x, edge + 0.05)])
    explore: Any = ExploreForward(0.2, 0.2, waffle)
    assert base.run(explore) == Finished("succeeded")
    assert 0.9 - base.x == pytest.approx(0.2, abs=0.005)
    assert explore.result()["closest_obstacle_angle"] > 20.0


def test_drives_past_what_the_hull_does_not_meet(fake, waffle):
    """Walls beside the swept width do not stop it."""
    side = waffle.hull.half_width + 0.05
    base = fake(waffle, [(-3.0, side, 9.0, side), (-3.0, -side, 9.0, -side)])
    base.run_for(ExploreForward(0.2, 0.5, waffle), 10.0)
    assert base.x > 1.9


@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_bearing_is_positive_to_the_left(fake, waffle, side, sign):
    """The result tells on which side the obstacle stands."""
    x = waffle.hull.front + 1.0
    base = fake(waffle, [(x, sign * 0.05, x, sign * 0.15)])
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    base.run(explore)
    expected = math.degrees(math.atan2(sign * 0.1, waffle.hull.front + 0.5))
    assert explore.result()["closest_obstacle_angle"] == pytest.approx(expected, abs=1.5), side


def test_result_before_the_first_step_is_empty_but_valid(waffle):
    """A goal canceled at once has driven nothing and seen nothing."""
    assert ExploreForward(0.2, 0.5, waffle).result() == {
        "total_distance_travelled": 0.0,
        "closest_obstacle": math.inf,
        "closest_obstacle_angle": 0.0,
    }


def test_bearing_of_a_canceled_leg_is_that_of_the_nearest_thing_beside_the_way(fake, waffle):
    """With a free way ahead, the bearing still tells from which side to turn away."""
    base = fake(waffle, [(0.5, -0.6, 3.0, -0.6)])
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    base.run_for(explore, 3.0)
    assert explore.result()["closest_obstacle"] == math.inf
    assert -95.0 < explore.result()["closest_obstacle_angle"] < -40.0


def test_feedback_only_when_something_changed(fake, waffle):
    """The same feedback is not given twice."""
    base = fake(waffle, wall_ahead(waffle, 1.0))
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    explore.step(base.observe())
    assert explore.feedback() == {
        "current_distance_travelled": 0.0,
        "closest_obstacle": pytest.approx(1.0, abs=1e-6),
    }
    assert explore.feedback() is None


def test_distance_is_the_length_of_the_path(fake, waffle):
    """Odometry that moves back counts too: it is a path length, no displacement."""
    base = fake(waffle)
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    explore.step(base.observe())
    base.move(Twist2D(0.2, 0.0), 1.0)
    there = base.x
    explore.step(base.observe())
    base.move(Twist2D(-0.2, 0.0), 1.0)
    back = base.x
    explore.step(base.observe())
    assert explore.result()["total_distance_travelled"] == pytest.approx(there + abs(back - there))


def test_blocked_robot_gives_up_after_two_seconds(fake, waffle):
    """A base that does not move ends the goal, with what was commanded in the reason."""
    base = fake(waffle)
    base.stuck = True
    finished = base.run(ExploreForward(0.2, 0.5, waffle))
    assert finished == Finished(
        "aborted",
        ErrorCode.BLOCKED,
        "blocked: commanded 0.20 m/s, no progress for 2 s; "
        "the base is held, or refuses commands as late",
    )
    assert base.time_s == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("lost", "code"), [("odometry", ErrorCode.NO_ODOMETRY), ("scan", ErrorCode.NO_SCAN)]
)
def test_sensor_that_falls_silent_ends_the_goal_after_one_second(fake, waffle, lost, code):
    """It drives no longer than a second without scan or odometry."""
    base = fake(waffle)
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    base.run_for(explore, 1.0)
    last = base.observe()
    kept = ("odom", "odom_stamp_s", "velocity") if lost == "odometry" else ("scan",)
    base.changes = {field: getattr(last, field) for field in kept}
    stamp = last.odom_stamp_s if lost == "odometry" else last.scan.stamp_s

    finished = base.run(explore)

    assert (finished.status, finished.error_code) == ("aborted", code)
    assert finished.reason == f"no {lost} for 1 s: the last is 1.05 s old"
    assert base.time_s == pytest.approx(stamp + 1.05)


def test_odometry_that_jumps_ends_the_goal(fake, waffle):
    """A reset of odometry is not counted as distance."""
    base = fake(waffle)
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    base.run_for(explore, 1.0)
    base.x -= 1.5
    finished = explore.step(base.observe())
    assert finished.error_code == ErrorCode.NO_ODOMETRY
    assert finished.reason == "odometry jumped by 1.49 m in 0.050 s; was it reset?"
    assert explore.result()["total_distance_travelled"] < 0.2


def test_stopping_distance_keeps_clear_of_the_blind_ring_of_the_lidar(robot):
    """A lidar that cannot see what touches the hull needs a longer stopping distance."""
    blind = robot.lidar.min_range - (robot.hull.front - robot.lidar.x)
    stopping_distance: Any = limits(robot, EXPLORING)[1]
    assert stopping_distance.low == max(0.05, blind + 0.05)


def test_a_stopping_distance_is_never_shorter_than_the_governors(waffle):
    """The base would be held before it is there."""
    stopping_distance: Any = limits(waffle, ExploreTuning(stop_margin=0.2))[1]
    assert stopping_distance.low == pytest.approx(0.22)


def test_drives_on_when_what_it_stopped_for_has_left(fake, waffle):
    """Somebody walks through: the goal ends at the next obstacle, not where nothing is."""
    base = fake(waffle, wall_ahead(waffle, 0.8))
    explore: Any = ExploreForward(0.2, 0.5, waffle)
    while base.twists[-1:] != [Twist2D()]:
        base.move(explore.step(base.observe()))
    base.walls = np.array(wall_ahead(waffle, 1.6))
    assert base.run(explore) == Finished("succeeded")
    assert 1.6 - base.x == pytest.approx(0.5, abs=0.005)
