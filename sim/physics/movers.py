"""Obstacles that move: where they are is a function of time alone, whatever pushes against them.

Each slides on two joints, x and y, and is put in its place with its velocity before every step of
the physics. So a contact knows how fast it comes; a mocap body would have no velocity. It weighs
a ton, so that a robot does not stop it within a step.
"""

from __future__ import annotations

import mujoco

from sim.physics.names import MOVER_PREFIX
from sim.world.world import World


class Movers:
    """Puts every moving obstacle in its place."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        self._each = []
        for obstacle in world.moving:
            assert obstacle.motion is not None
            joint = model.joint(f"{MOVER_PREFIX}{obstacle.name}/x")
            home = obstacle.motion.at(0.0)
            self._each.append(
                (int(joint.qposadr[0]), int(joint.dofadr[0]), obstacle.motion, home[0], home[1])
            )

    def place(self, data: mujoco.MjData, time_ns: int) -> None:
        """Set positions and velocities to those at this time after the start."""
        qpos, qvel, time_s = data.qpos, data.qvel, time_ns / 1e9
        for q, v, motion, x_0, y_0 in self._each:
            x, y, vx, vy = motion.at(time_s)
            qpos[q], qpos[q + 1] = x - x_0, y - y_0
            qvel[v], qvel[v + 1] = vx, vy
