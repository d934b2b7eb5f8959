"""Robots in a world, moved by physics alone; the ROS node is a thin layer over it.

Pure: no ROS and no wall clock. The same world, robots, seed and commands give the same readings,
bit for bit, on one version of MuJoCo and one processor architecture.

How a robot stands: which of its parts drag on the floor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from bt_mission.robots.model import RobotModel
from sim.physics.names import BASE, FLOOR, FLOOR_BIT, MODEL_PREFIX, WHEELS
from sim.physics.physics import Physics
from sim.physics.simulator import SimulatorFactory
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.world.world import World


class Simulation:
    """One robot or several in one world, on one clock. They see each other and collide.

        simulation = Simulation(world, [RobotSpawn(waffle, "robot1", Spawn(x=-1)),
                                        RobotSpawn(burger, "robot2", Spawn(x=1))], seed=1)
        simulation["robot1"].command(0.2, 0.0)
        simulation.advance_to(simulation.time_ns + 50_000_000)
        simulation["robot2"].scan(0)

    `seed` decides all sensor noise: that of a robot depends on the seed and on its name, not on the
    other robots. `start_ns` is the first instant: above 0, which ROS takes for "not set". `props`
    is how many obstacles can be placed later. `simulator` makes what moves a robot alone in place
    of MuJoCo (`sim.physics.simulator`); it may raise SimulatorError at every step.

    A lidar 0.13 m above the floor looks over the bodies of other robots, so each of several
    carries a screen: as long and as wide as its hull, from the floor up to above the highest
    lidar. The others' lidars and cameras see the screen, in a separate colour; it touches
    nothing. Raises SpawnError and RobotSpawnError.
    """

    def __init__(
        self,
        world: World,
        robots: Sequence[RobotSpawn],
        *,
        seed: int,
        start_ns: int = 1_000_000_000,
        props: int = 0,
        simulator: SimulatorFactory | None = None,
    ) -> None:
        self.physics = Physics(world, robots, start_ns, props, simulator, seed)
        self.robots = tuple(SimulatedRobot(self.physics, robot, seed=seed) for robot in robots)
        self.physics.begin(self.robots)

    def __getitem__(self, name: str) -> SimulatedRobot:
        """Return the robot of that name; a robot alone may have an empty one. Raises KeyError."""
        return {robot.name: robot for robot in self.robots}[name]

    @property
    def time_ns(self) -> int:
        """The present instant, ns."""
        return self.physics.time_ns

    def advance_to(self, time_ns: int) -> None:
        """Step the physics up to `time_ns`, a whole number of steps from now.

        Raises ValueError where that time is past, or lies between two steps.
        """
        self.physics.advance_to(time_ns)


_STANDING_NS = 1_000_000_000
"""The time in which a robot stops moving, or tips over."""


def dragging(robot: RobotModel) -> Iterator[str]:
    """Yield which parts besides wheels and casters touch the floor where the robot stands."""
    simulation = Simulation(World(name="floor", size=(20.0, 20.0)), [RobotSpawn(robot)], seed=0)
    simulation.advance_to(simulation.time_ns + _STANDING_NS)
    physics = simulation.physics
    model, floor = physics.model, physics.model.geom(FLOOR).id
    geoms = physics.data.contact.geom
    for geom in sorted({*geoms[(geoms == floor).any(axis=1)].ravel().tolist()} - {floor}):
        slides = (model.geom_contype[geom], model.geom_conaffinity[geom]) == (0, FLOOR_BIT)
        if not slides and model.geom(geom).name not in WHEELS:
            yield (
                f"{_described(physics, geom)} touches the floor, which brakes the robot. If it is"
                " a caster, list it in `casters`, by its name or its place"
            )


def _described(physics: Physics, geom: int) -> str:
    """Return the name of a geom, or its shape and body, and its place in the base."""
    model, data = physics.model, physics.data
    base = model.body(BASE).id
    place = data.xmat[base].reshape(3, 3).T @ (data.geom_xpos[geom] - data.xpos[base])
    at = ", ".join(f"{each:.3f}" for each in np.round(place, 3).tolist())
    name = model.geom(geom).name.removeprefix(MODEL_PREFIX)
    shape = str(mujoco.mjtGeom(int(model.geom_type[geom])).name).removeprefix("mjGEOM_").lower()
    part = f"'{name}'" if name else f"a {shape}"
    return f"{part} at ({at}) m of the base"
