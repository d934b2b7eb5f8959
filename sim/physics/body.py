"""A robot's body in the MuJoCo model.

The robot stands on two driven wheels and on its casters; velocity servos turn the wheels, and
only their contact with the floor moves the base. Servo settings are those at which commanded
speeds are reached; what else was tried stands beside each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco

from bt_mission.core.robot.model import CameraModel, RobotModel
from sim.physics.names import (
    ACCELEROMETER,
    BASE,
    CAMERA,
    FLOOR_BIT,
    GRIP,
    LOOKS,
    OBSTACLE_BIT,
    ROBOT,
    SCREEN_BIT,
    SCREENS,
    SLIDE,
    SOLIMP,
    SOLREF,
    WHEELS,
)
from sim.physics.scenery import yaw_quaternion
from sim.physics.spawn import RobotSpawn
from sim.world.colours import rgba
from sim.world.world import Spawn

_ARMATURE = 0.0015
"""kg m^2, a motor's rotor seen through its gear.

Without it the wheel is so light against the base that friction turns soft: 6 mm in 2 m are lost.
The 0.01 of ROBOTIS's own MuJoCo model gives the wheels momentum enough to hop against a wall.
"""

_SERVO_GAIN = 0.15
"""N m s: a wheel follows its command within about 15 ms."""

_PUSH = 0.75
"""The part of the wheels' grip that the motors can push with.

A robot that drives against a wall then stalls and stands. With enough strength to slip, its wheels
grip and slip in turns, and it trembles by 6 mm.
"""


Triple = tuple[float, float, float]


@dataclass(frozen=True)
class LookShape:
    """A box of half edges, or an upright cylinder of radius and half height (and 0), m."""

    kind: Literal["box", "cylinder"]
    half: Triple
    at: Triple
    colour: str


def add_robot(
    spec: mujoco.MjSpec, entrant: RobotSpawn, spawn: Spawn, *, group: int, contype: int
) -> mujoco.MjsBody:
    """Add one, its motors in a separate actuator group. Return its base."""
    robot, prefix = entrant.robot, entrant.prefix
    base = spec.worldbody.add_body(
        name=prefix + BASE,
        pos=[spawn.x, spawn.y, robot.base_height],
        quat=yaw_quaternion(math.radians(spawn.yaw)),
        mass=robot.base_mass,
        inertia=robot.base_inertia,
        ipos=robot.base_centre_of_mass,
        explicitinertial=True,
    )
    base.add_freejoint(name=prefix + BASE)
    base.add_geom(
        name=f"{prefix}hull",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[edge / 2 for edge in robot.body.size],
        pos=robot.body.centre,
        contype=contype,
        conaffinity=FLOOR_BIT | OBSTACLE_BIT | contype,
        friction=SLIDE,
        group=ROBOT,
    )
    for index, caster in enumerate(robot.casters):
        base.add_geom(
            name=f"{prefix}caster {index}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[robot.caster_radius, 0, 0],
            pos=caster,
            contype=0,
            conaffinity=FLOOR_BIT,
            # The pair would take the floor's friction, which costs up to half of the speed.
            condim=1,
            priority=1,
            group=ROBOT,
            solref=SOLREF,
            solimp=SOLIMP,
        )
    for name, side in zip(WHEELS, (1, -1), strict=True):
        motor = _add_wheel(spec, base, robot, prefix + name, side=side, contype=contype)
        motor.group = group
    _add_sensors(spec, base, robot, prefix)
    if robot.camera is not None:
        _add_camera(spec, base, robot.camera, prefix)
    _add_looks(base, robot)
    return base


def add_screen(base: mujoco.MjsBody, robot: RobotModel, height: float, colour: str) -> None:
    """Add a screen around the hull, `height` m high: other robots see it, and never touch it."""
    hull = robot.hull
    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[(hull.front - hull.rear) / 2, hull.half_width, height / 2],
        pos=[(hull.front + hull.rear) / 2, 0, height / 2 - robot.base_height],
        rgba=rgba(colour),
        contype=SCREEN_BIT,
        conaffinity=0,
        group=SCREENS,
    )


def _add_wheel(
    spec: mujoco.MjSpec,
    base: mujoco.MjsBody,
    robot: RobotModel,
    name: str,
    *,
    side: int,
    contype: int,
) -> mujoco.MjsActuator:
    radius, width = robot.wheel_radius, robot.wheel_width
    wheel = base.add_body(
        name=name,
        pos=[0, side * robot.wheel_y, radius - robot.base_height],
        mass=robot.wheel_mass,
        inertia=robot.wheel_inertia,
        ipos=[0, 0, 0],  # without it, MuJoCo uses `pos`, and the wheel runs out of balance
        explicitinertial=True,
    )
    wheel.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0], armature=_ARMATURE)
    wheel.add_geom(
        name=name,
        # Touches the floor in one point, so it turns on the spot without scrubbing; a cylinder of
        # this width made the robot turn 3 % less than its wheels said.
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        size=[radius, width / 2, radius],
        contype=contype,
        conaffinity=FLOOR_BIT | OBSTACLE_BIT | contype,
        friction=GRIP,
        group=ROBOT,
        solref=SOLREF,
        solimp=SOLIMP,
    )
    tyre = _add_look(wheel, mujoco.mjtGeom.mjGEOM_CYLINDER, [radius, width / 2, 0], [0, 0, 0])
    tyre.quat = [math.sqrt(0.5), math.sqrt(0.5), 0, 0]
    motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_velocity(kv=_SERVO_GAIN)
    most = _PUSH * _grip_torque(robot)
    motor.forcelimited = True
    motor.forcerange = [-most, most]
    return motor


def _grip_torque(robot: RobotModel) -> float:
    """Return the torque, N m, at which a wheel on the level begins to slip."""
    on_casters = robot.base_centre_of_mass[0] / robot.casters[0][0]
    on_wheels = 9.81 * (robot.base_mass * (1 - on_casters) + 2 * robot.wheel_mass)
    return GRIP[0] * on_wheels / 2 * robot.wheel_radius


def _add_sensors(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: RobotModel, prefix: str) -> None:
    imu, site = robot.imu, f"{prefix}imu"
    base.add_site(name=site, pos=[imu.x, imu.y, imu.z], group=5)
    spec.add_sensor(
        name=prefix + ACCELEROMETER,
        type=mujoco.mjtSensor.mjSENS_ACCELEROMETER,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=site,
    )


def _add_camera(
    spec: mujoco.MjSpec, base: mujoco.MjsBody, camera: CameraModel, prefix: str
) -> None:
    aspect = camera.height / camera.width
    base.add_camera(
        name=prefix + CAMERA,
        pos=[camera.x, camera.y, camera.z],
        quat=[0.5, 0.5, -0.5, -0.5],  # right of the image is -y, up is z: it looks along x
        fovy=math.degrees(2 * math.atan(math.tan(camera.hfov / 2) * aspect)),
        resolution=[camera.width, camera.height],
    )
    spec.visual.quality.offsamples = 0  # four samples a pixel cost a CPU four times as much
    buffer = spec.visual.global_  # one for all, as large as the largest image
    buffer.offwidth = max(buffer.offwidth, camera.width)
    buffer.offheight = max(buffer.offheight, camera.height)


def _add_looks(base: mujoco.MjsBody, robot: RobotModel) -> None:
    """Add what people see of the body."""
    kinds = {"box": mujoco.mjtGeom.mjGEOM_BOX, "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER}
    for look in looks(robot):
        _add_look(base, kinds[look.kind], list(look.half), list(look.at), look.colour)


def _add_look(
    body: mujoco.MjsBody,
    kind: mujoco.mjtGeom,
    size: list[float],
    pos: list[float],
    colour: str = "black",
) -> mujoco.MjsGeom:
    return body.add_geom(
        type=kind, size=size, pos=pos, rgba=rgba(colour), contype=0, conaffinity=0, group=LOOKS
    )


def looks(robot: RobotModel) -> list[LookShape]:
    """Return what people see of a robot, in `base_link`: plates, a core, lidar, a bar in front."""
    length, width, height = robot.body.size
    x, y, z = robot.body.centre
    plate = 0.004
    plates = [
        LookShape(
            "box",
            (length / 2, width / 2, plate),
            (x, y, z + level * (height / 2 - plate)),
            "#3a3f44",
        )
        for level in (-1, 0, 1)
    ]
    core = (length * 0.42, width * 0.36, height / 2 - 2 * plate)
    lidar = (robot.lidar.x, robot.lidar.y, robot.lidar.z - 0.005)
    bar = (robot.hull.front - 0.012, 0.0, z + height / 2)
    return [
        *plates,
        LookShape("box", core, (x, y, z), "#5b6570"),
        LookShape("cylinder", (0.035, 0.02, 0.0), lidar, "black"),
        LookShape("box", (0.006, width / 4, 0.006), bar, "orange"),
    ]
