"""Simulated robots: one that is alone in its world, or two; and the passing of their time."""

from bt_mission.robots.model import RobotModel
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.simulation import Simulation
from sim.world.world import Spawn, World


def alone(world: World, model: RobotModel, *, seed: int = 0, props: int = 0) -> SimulatedRobot:
    """Return the robot; its `physics` moves the world."""
    return Simulation(world, [RobotSpawn(model)], seed=seed, props=props).robots[0]


def two(model: RobotModel, *, yaw: float = 0.0) -> list[RobotSpawn]:
    """Return `one` and `two`, 2 m apart along x; the second looks in this direction, degrees."""
    return [
        RobotSpawn(model, "one", Spawn(x=-1)),
        RobotSpawn(model, "two", Spawn(x=1, yaw=yaw)),
    ]


def wait(robot: SimulatedRobot, seconds: float) -> None:
    """Let time pass, without a command."""
    robot.physics.advance_to(robot.physics.time_ns + round(seconds * 1e9))
