"""Simulations and worlds that several tests of the simulator use."""

import pytest

from bt_mission.common.robot import load_robot
from sim.simulation import Simulation
from sim.world import World

CONTROL_NS = 50_000_000
"""The period at which a controller commands, 20 Hz."""


@pytest.fixture(scope="session")
def waffle():
    """The default robot."""
    return load_robot("waffle")


@pytest.fixture
def make_world():
    """Makes a world from fields; a wide empty floor unless told otherwise."""

    def make(**fields: object) -> World:
        return World.model_validate({"name": "test", "size": [20, 20], **fields})

    return make


@pytest.fixture
def simulate(waffle, make_world):
    """Makes a simulation of a Waffle in a world of these fields."""

    def simulate(seed: int = 1, **fields: object) -> Simulation:
        return Simulation(make_world(**fields), waffle, seed=seed)

    return simulate


@pytest.fixture
def drive():
    """Drives at a velocity, commanded at 20 Hz, for some seconds; odometry is read as often."""

    def drive(simulation: Simulation, seconds: float, linear: float = 0.0, angular: float = 0.0):
        end_ns = simulation.time_ns + round(seconds * 1e9)
        while simulation.time_ns < end_ns:
            simulation.command(linear, angular)
            simulation.advance_to(min(simulation.time_ns + CONTROL_NS, end_ns))
            simulation.read_odometry()

    return drive
