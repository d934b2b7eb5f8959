"""A robot gives way to what moves: a small version of the benchmark, and its oracle."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.core.robot.model import load_robot
from sim.world.motion import Drifting
from sim.world.shapes import Obstacle
from tests.support.thorough import sample


@pytest.mark.parametrize("world", sample(["dqn_stage4", "dqn_stage3"], every=2))
def test_nothing_runs_into_an_exploring_robot(benchmark: Any, world: str) -> None:
    """Not even at 0.5 m/s, twice as fast as the robot."""
    outing = benchmark("safety_movers").outing(world, 1, 40, 0.5)
    assert outing.met == ()
    assert outing.driven_m > 4.0


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
