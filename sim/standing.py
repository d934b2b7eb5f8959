"""How a robot stands: which of its parts drag on the floor."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from bt_mission.robots.model import RobotModel
from sim.physics.names import BASE, FLOOR, FLOOR_BIT, MODEL_PREFIX, WHEELS
from sim.physics.physics import Physics
from sim.physics.spawn import RobotSpawn
from sim.simulation import Simulation
from sim.world.world import World

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
