"""Robots in a world, moved by physics alone: what the ROS node is a thin layer over.

`Simulation` is one robot alone in its world; `Fleet` holds several in one. Pure: no ROS and no
wall clock. The same world, robots, seed and commands give the same readings, bit for bit, on one
version of MuJoCo and one processor architecture.
"""

from __future__ import annotations

from collections.abc import Sequence

from bt_mission.core.robot.model import RobotModel
from sim.physics.physics import Physics
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.world.world import World


class Simulation(SimulatedRobot):
    """One robot alone in one world.

    `seed` decides all sensor noise. `start_ns` is the first instant: above 0, which ROS takes
    for "not set". `props` is how many obstacles can be placed later. Raises SpawnError.
    """

    def __init__(
        self,
        world: World,
        robot: RobotModel,
        *,
        seed: int,
        start_ns: int = 1_000_000_000,
        props: int = 0,
    ) -> None:
        physics = Physics(world, [RobotSpawn(robot)], start_ns, props)
        super().__init__(physics, RobotSpawn(robot), seed=seed)
        self.world, self.props = physics.world, physics.props
        self.model, self.data = physics.model, physics.data
        physics.begin([self])

    @property
    def time_ns(self) -> int:
        """The present instant, ns."""
        return self.physics.time_ns

    def advance_to(self, time_ns: int) -> None:
        """Step the physics up to `time_ns`, a whole number of steps from now.

        Raises ValueError where that time is past, or lies between two steps.
        """
        self.physics.advance_to(time_ns)

    def reset(self) -> None:
        """Put everything back to its state at the start. Time and counters go on."""
        self.physics.reset()


class Fleet:
    """Several robots in one world, on one clock. They see each other and collide.

        fleet = Fleet(world, [RobotSpawn(waffle, "robot1", Spawn(x=-1)),
                              RobotSpawn(burger, "robot2", Spawn(x=1))], seed=1)
        fleet["robot1"].command(0.2, 0.0)
        fleet.physics.advance_to(fleet.physics.time_ns + 50_000_000)
        fleet["robot2"].scan(0)

    The noise of a robot's sensors depends on the seed and on its name, not on the other robots.
    A lidar 0.13 m above the floor looks over the bodies of other robots, so each of several
    carries a screen: as long and as wide as its hull, from the floor up to above the highest
    lidar. The others' lidars and cameras see the screen, in a colour of its own; it touches
    nothing. Raises SpawnError and RobotSpawnError.
    """

    def __init__(
        self,
        world: World,
        entrants: Sequence[RobotSpawn],
        *,
        seed: int,
        start_ns: int = 1_000_000_000,
        props: int = 0,
    ) -> None:
        self.physics = Physics(world, entrants, start_ns, props)
        self.props = self.physics.props
        self.robots = tuple(
            SimulatedRobot(self.physics, entrant, seed=seed) for entrant in entrants
        )
        self.physics.begin(self.robots)

    def __getitem__(self, name: str) -> SimulatedRobot:
        """Return the robot of that name. Raises KeyError."""
        return {robot.name: robot for robot in self.robots}[name]

    @property
    def collisions(self) -> int:
        """How often any of them has touched an obstacle or another robot."""
        return sum(robot.collisions for robot in self.robots)
