"""How a base that does not roll on its wheels stands and moves: supports, and three servos.

`sim.robot.base` says why, and sets the servos.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco

from bt_mission.robots.model import RobotModel
from sim.physics.names import FLOOR_BIT, ROBOT, SERVOS, SOLIMP, SOLREF

_SERVO_S = 0.005
"""The time in which the servos of a planar base follow: a car of 1 m/s in a bend of 1 rad/s then
slides sideways at 5 mm/s."""

_SUPPORT_M = 0.01
"""The radius of a support without friction, under each wheel of a planar base."""


@dataclass(frozen=True)
class MassFigures:
    """Of a whole robot, in the frame of its base.

    `height` is that of its centre of mass, m; `inertia` that about the z axis of the base, kg m^2.
    """

    height: float
    inertia: float


def add_support(base: mujoco.MjsBody, name: str, at: Sequence[float], radius: float) -> None:
    """Add a ball on which a base slides without friction."""
    base.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[radius, 0, 0],
        pos=at,
        contype=0,
        conaffinity=FLOOR_BIT,
        # The pair would take the floor's friction, which costs up to half of the speed.
        condim=1,
        priority=1,
        group=ROBOT,
        solref=SOLREF,
        solimp=SOLIMP,
    )


def add_planar_drive(
    spec: mujoco.MjSpec,
    base: mujoco.MjsBody,
    robot: RobotModel,
    prefix: str,
    group: int,
    mass: MassFigures,
) -> None:
    """Add supports, and servos for the velocity ahead, to the left, and of turning."""
    drive, height = robot.drive, robot.base_height
    for index, (x, y) in enumerate(drive.places):
        add_support(base, f"{prefix}support {index}", (x, y, _SUPPORT_M - height), _SUPPORT_M)
    # At the height of the centre of mass, so that the base does not pitch.
    site = base.add_site(name=f"{prefix}drive", pos=[0, 0, mass.height], group=5)
    for name, axis, moved in zip(
        SERVOS, (0, 1, 5), (robot.base_mass,) * 2 + (mass.inertia,), strict=True
    ):
        gear = [0.0] * 6
        gear[axis] = 1.0
        servo = spec.add_actuator(
            name=prefix + name, target=site.name, trntype=mujoco.mjtTrn.mjTRN_SITE, gear=gear
        )
        servo.set_to_velocity(kv=moved / _SERVO_S)
        servo.forcelimited = True
        servo.forcerange = [-1.0, 1.0]  # the base sets it
        servo.group = group
