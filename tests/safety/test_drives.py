"""A robot that drives at things stops before them; a small version of the benchmark."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from tests.support.thorough import sample

WORLDS = ("explore_arena", "nav_arena", "turtlebot3_world")
NOISE_M = 0.01
"""One standard deviation of a ray of the lidar."""


@pytest.mark.parametrize(
    ("world", "appears"), sample(itertools.product(WORLDS, [False, True]), every=3)
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
