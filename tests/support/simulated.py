"""A simulated robot that is alone in its world."""

from bt_mission.core.robot.model import RobotModel
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.simulation import Simulation
from sim.world.world import World


def alone(world: World, model: RobotModel, *, seed: int = 0, props: int = 0) -> SimulatedRobot:
    """Return the robot; its `physics` moves the world."""
    return Simulation(world, [RobotSpawn(model)], seed=seed, props=props).robots[0]
