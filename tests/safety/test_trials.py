"""What the campaign of safety measures, in small: drives, movers and stops on the virtual clock."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from bt_mission.robots.model import load_robot
from sim.world.motion import Drifting
from sim.world.shapes import Obstacle
from tests.support.thorough import sample

WORLDS = ("explore_arena", "nav_arena", "turtlebot3_world")
NOISE_M = 0.01
"""One standard deviation of a ray of the lidar."""


@pytest.mark.parametrize(
    ("world", "appears"), sample(itertools.product(WORLDS, [False, True]), every=5)
)
def test_no_drive_ends_in_a_collision(benchmark: Any, world: str, *, appears: bool) -> None:
    """From seeded poses at full speed, with noise: nearer than told by no more than noise."""
    trials = benchmark("safety_trials")
    drives = list(trials.drives(world, count=4, speeds=(0.26,), seed=2, appears=appears))
    assert len(drives) == 4
    assert sum(drive.collisions for drive in drives) == 0
    assert {drive.status for drive in drives} == {"succeeded"}
    assert min(drive.surplus for drive in drives) > -2 * NOISE_M


def test_every_obstacle_of_a_world_is_aimed_at(benchmark: Any) -> None:
    """In turn, from where the robot fits."""
    trials = benchmark("safety_trials")
    with benchmark("safety_rig").Rig("nav_arena") as rig:
        poses = trials.poses(rig, 26, 1)
        targets = {obstacle.name for obstacle in rig.world.obstacles}
    assert len(poses) == 26
    assert len({pose.target for pose in poses}) > 0.8 * len(targets)


def test_a_robot_that_is_driven_into_a_wall_is_counted(benchmark: Any) -> None:
    """The trial itself can tell a collision: nobody looks at the lidar here."""
    with benchmark("safety_rig").Rig("nav_arena", intruder=True) as rig:
        rig.place(0.0, 0.0, 0.0)
        rig.intrude(0.2)
        assert rig.gap_ahead() == pytest.approx(0.2, abs=1e-6)
        end_s = rig.now_s + 2.0
        while rig.now_s < end_s:
            rig.sim.robots[0].command(0.2, 0.0)
            rig.clock.step()
        assert rig.collisions == 1
        assert rig.gap_ahead() == pytest.approx(0.0, abs=0.002)


@pytest.mark.thorough
@pytest.mark.parametrize("world", sample(["dqn_stage4", "dqn_stage3"], every=2))
def test_nothing_runs_into_an_exploring_robot(benchmark: Any, world: str) -> None:
    """Not even at 0.5 m/s, twice as fast as the robot."""
    outing = benchmark("safety_movers").outing(world, 1, 40, 0.5)
    assert outing.met == ()
    assert outing.driven_m > 4.0


@pytest.mark.thorough
def test_what_moves_runs_into_a_robot_that_does_not_give_way(benchmark: Any) -> None:
    """It was seen, and a robot that knows how things move could have avoided it."""
    outing = benchmark("safety_movers").outing("dqn_stage3", 1, 40, 0.5, False)
    first = outing.met[0]
    assert first.is_mover
    assert first.was_seen
    assert first.was_run_into
    assert first.could_avoid
    assert first.mover_speed == pytest.approx(0.5)


@pytest.mark.parametrize(("is_alley", "could_avoid"), [(False, True), (True, False)])
def test_the_oracle_knows_a_way_out_where_there_is_one(
    benchmark: Any, *, is_alley: bool, could_avoid: bool
) -> None:
    """Of something that comes at a robot that stands: aside in the open, nowhere in an alley."""
    oracle_of = benchmark("safety_oracle")
    mover = Obstacle.cylinder("mover", 2.0, 0.0, radius=0.15, height=0.5, colour="orange")
    mover = oracle_of.replace(mover, motion=Drifting((2.0, 0.0), (-0.5, 0.0)))
    walls = [
        Obstacle.box(name, x, y, yaw=0.0, size=size, colour="grey")
        for name, x, y, size in (
            ("left", 0.0, 0.35, (2.0, 0.1, 0.5)),
            ("right", 0.0, -0.35, (2.0, 0.1, 0.5)),
            ("behind", -0.4, 0.0, (0.1, 0.7, 0.5)),
        )
    ]
    obstacles = [mover, *walls] if is_alley else [mover]
    oracle = oracle_of.Oracle(load_robot("waffle"), obstacles)
    states = [oracle_of.State(t / 20, (0.0, 0.0, 0.0), (0.0, 0.0)) for t in range(72)]
    assert oracle.way_out(states, 3.56) == (could_avoid, False)
    assert oracle.is_seen(states[-1], mover)


ACTIONS = (
    "explore_forward",
    "turn",
    "camera_sweep",
    "move",
    "navigate_to_pose",
    "navigate_through_poses",
    "follow_waypoints",
    "spin",
    "backup",
    "drive_on_heading",
)


def test_every_action_that_drives_is_here(benchmark: Any) -> None:
    """The trials have a goal for each."""
    assert tuple(benchmark("safety_stops").GOALS) == ACTIONS


@pytest.mark.parametrize("action", sample(ACTIONS, every=2))
def test_the_stop_service_stops(benchmark: Any, action: str) -> None:
    """The base stands within 0.3 s, and the goal is aborted as stopped."""
    stop = benchmark("safety_stops").by_service(action)
    assert stop.stood_after_s <= 0.3
    assert (stop.status, stop.reason) == ("aborted", "stopped")


@pytest.mark.parametrize("action", sample(reversed(ACTIONS), every=5))
def test_a_lidar_that_falls_silent_stops(benchmark: Any, action: str) -> None:
    """The base stands within 1 s, and the goal is aborted with the reason."""
    stop = benchmark("safety_stops").by_lost_scan(action)
    assert stop.stood_after_s <= 1.0
    assert stop.status == "aborted"
    assert "no scan" in stop.reason
