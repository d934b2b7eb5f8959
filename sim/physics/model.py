"""The MuJoCo model of a world with robots in it."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from sim.physics.body import add_robot, add_screen, add_touch
from sim.physics.names import BASE, ROBOT_BIT, STEP_NS
from sim.physics.prop_bodies import add_bodies, keep_figures
from sim.physics.scenery import add_world
from sim.physics.spawn import RobotSpawn
from sim.world.world import World

SCREEN_COLOURS = ("purple", "orange", "brown", "black", "grey", "white")

_OVER = 0.03
"""Metres by which a robot's screen stands above the highest lidar."""


def compile_model(world: World, entrants: Sequence[RobotSpawn], props: int = 0) -> mujoco.MjModel:
    """Return the compiled model; each robot stands where it starts. `props`: spare bodies."""
    spec = mujoco.MjSpec()
    spec.modelname = world.name
    spec.option.timestep = STEP_NS / 1e9
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # So odometry is off by 0.16 mm in 2 m; with elliptic cones or impratio 1, by 1.6 mm.
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.option.impratio = 10.0
    spec.visual.global_.offwidth = spec.visual.global_.offheight = 1
    add_world(spec, world)
    several = len(entrants) > 1
    lidars = max(entrant.robot.base_height + entrant.robot.lidar.z for entrant in entrants)
    for index, entrant in enumerate(entrants):
        spawn, contype = entrant.spawn or world.spawn, ROBOT_BIT if several else 0
        base = add_robot(spec, entrant, spawn, group=index, contype=contype)
        if several:
            colour = SCREEN_COLOURS[index % len(SCREEN_COLOURS)]
            add_screen(base, entrant.robot, lidars + _OVER, colour)
    for entrant in entrants:
        add_touch(spec, entrant.prefix, "", tree=bool(world.moving))
        for other in entrants:
            if other is not entrant:
                add_touch(spec, entrant.prefix, other.prefix + BASE, tree=True)
    model = spec.compile()
    if not props:
        return model
    add_bodies(spec, props, [entrant.prefix for entrant in entrants])
    spare = spec.compile()
    keep_figures(spare, model)
    return spare
