"""Slippery places: wheels spin there, and odometry goes wrong."""

import pytest

ICE = {"name": "ice", "x": 0, "y": 0, "radius": 0.6, "friction": 0.02}


def test_wheels_spin_where_it_is_slippery(simulate, drive):
    """Starting on ice, odometry runs ahead of the truth; on the floor it does not."""
    ice, floor = simulate(slippery=[ICE]), simulate()
    for simulation in (ice, floor):
        drive(simulation, 1.0, linear=0.2)
    assert ice.odometry.x == pytest.approx(floor.odometry.x, abs=0.01)
    assert floor.pose[0] == pytest.approx(floor.odometry.x, abs=0.001)
    assert ice.pose[0] < 0.8 * ice.odometry.x


def test_beside_it_they_grip_as_ever(simulate, drive):
    """A robot that does not come near drives as without it."""
    away, floor = simulate(slippery=[{**ICE, "y": 5}]), simulate()
    for simulation in (away, floor):
        drive(simulation, 2.0, 0.2, 0.3)
    assert away.pose == pytest.approx(floor.pose, abs=1e-6)


def test_the_lidar_does_not_see_it_and_nobody_runs_into_it(simulate, drive):
    """It is a mark on the floor."""
    simulation = simulate(slippery=[{**ICE, "x": 0.5}])
    drive(simulation, 2.0, linear=0.2)
    assert not (simulation.scan(0) < 3.5).any()
    assert simulation.collisions == 0


def test_a_run_over_it_repeats_after_a_reset(simulate, drive):
    """Bit for bit."""
    simulation = simulate(slippery=[ICE])
    drive(simulation, 2.0, 0.2, 0.5)
    first = simulation.pose
    simulation.physics.reset()
    drive(simulation, 2.0, 0.2, 0.5)
    assert simulation.pose == first
