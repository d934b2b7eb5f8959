"""A robot's body in the MuJoCo model.

A differential robot stands on two driven wheels and on its casters; velocity servos turn the
wheels, and only their contact with the floor moves the base. `sim.robot.base` says how the others
move. Servo settings are those at which commanded
speeds are reached; what else was tried stands beside each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from bt_mission.robots.body import BoxBody, CylinderBody
from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.model import CameraModel, RobotModel
from bt_mission.robots.statics import shares
from sim.physics.mjcf import add_model
from sim.physics.names import (
    ACCELEROMETER,
    BASE,
    CAMERA,
    FLOOR_BIT,
    GRIP,
    LOOKS,
    LOOSE_BIT,
    OBSTACLE_BIT,
    PUSH,
    ROBOT,
    SCREEN_BIT,
    SCREENS,
    SLIDE,
    SOLIMP,
    SOLREF,
    WHEELS,
)
from sim.physics.planar import MassFigures, add_planar_drive, add_support
from sim.physics.scenery import yaw_quaternion
from sim.physics.spawn import RobotSpawn
from sim.world.shapes import rgba
from sim.world.world import Spawn

_ARMATURE = 0.0015
"""kg m^2, a motor's rotor seen through its gear.

Without it the wheel is so light against the base that friction turns soft: 6 mm in 2 m are lost.
The 0.01 of ROBOTIS's own MuJoCo model gives the wheels momentum enough to hop against a wall.
"""

_SERVO_GAIN = 0.15
"""N m s: a wheel follows its command within about 15 ms."""

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
    if robot.model is None:
        base = _add_built(spec, robot, prefix, group=group, contype=contype)
        _add_looks(base, robot)
    else:
        base = add_model(spec, robot, prefix, group=group, contype=contype)
    base.pos = [spawn.x, spawn.y, robot.base_height]
    base.quat = yaw_quaternion(math.radians(spawn.yaw))
    _add_sensors(spec, base, robot, prefix)
    if robot.camera is not None:
        _add_camera(spec, base, robot.camera, prefix)
    return base


def _add_built(
    spec: mujoco.MjSpec, robot: RobotModel, prefix: str, *, group: int, contype: int
) -> mujoco.MjsBody:
    """Build a robot of the figures of its file."""
    base = spec.worldbody.add_body(
        name=prefix + BASE,
        mass=robot.base_mass,
        inertia=robot.base_inertia,
        ipos=robot.base_centre_of_mass,
        explicitinertial=True,
    )
    base.add_freejoint(name=prefix + BASE)
    base.add_geom(
        name=f"{prefix}hull",
        **_shape_of(spec, robot, prefix),
        contype=contype,
        conaffinity=FLOOR_BIT | OBSTACLE_BIT | LOOSE_BIT | contype,
        friction=SLIDE,
        group=ROBOT,
    )
    drive = robot.drive
    if isinstance(drive, DifferentialDrive):
        for index, caster in enumerate(drive.casters):
            add_support(base, f"{prefix}caster {index}", caster, drive.caster_radius)
        for name, side in zip(WHEELS, (1, -1), strict=True):
            motor = _add_wheel(spec, base, robot, drive, prefix + name, side=side, contype=contype)
            motor.group = group
    else:
        x, y, z = robot.base_centre_of_mass
        inertia = robot.base_inertia[2] + robot.base_mass * math.hypot(x, y) ** 2
        add_planar_drive(spec, base, robot, prefix, group, MassFigures(z, inertia))
        for (x, y), heading in zip(drive.places, drive.headings, strict=True):
            size = [drive.wheel_radius, drive.wheel_width / 2, 0]
            at = [x, y, drive.wheel_radius - robot.base_height]
            _add_look(base, mujoco.mjtGeom.mjGEOM_CYLINDER, size, at).quat = _sideways(heading)
    return base


def _shape_of(spec: mujoco.MjSpec, robot: RobotModel, prefix: str) -> dict[str, Any]:
    """Return the shape of the body as the fields of a geom."""
    body = robot.body
    if isinstance(body, CylinderBody):
        size = [body.radius, body.height / 2, 0]
        return {"type": mujoco.mjtGeom.mjGEOM_CYLINDER, "size": size, "pos": body.centre}
    if isinstance(body, BoxBody):
        size = [edge / 2 for edge in body.size]
        return {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": size, "pos": body.centre}
    points = [(x, y, z) for z in body.heights for x, y in body.outline]
    mesh = spec.add_mesh(name=f"{prefix}hull", uservert=np.array(points).ravel())
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    return {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": mesh.name}


def _sideways(yaw: float) -> list[float]:
    """Return the rotation of an axis along z to one across a heading."""
    c, s, half = math.cos(yaw / 2), math.sin(yaw / 2), math.sqrt(0.5)
    return [c * half, c * half, s * half, s * half]


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
    drive: DifferentialDrive,
    name: str,
    *,
    side: int,
    contype: int,
) -> mujoco.MjsActuator:
    radius, width = drive.wheel_radius, drive.wheel_width
    wheel = base.add_body(
        name=name,
        pos=[0, side * drive.wheel_y, radius - robot.base_height],
        mass=drive.wheel_mass,
        inertia=drive.wheel_inertia,
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
        conaffinity=FLOOR_BIT | OBSTACLE_BIT | LOOSE_BIT | contype,
        friction=GRIP,
        group=ROBOT,
        solref=SOLREF,
        solimp=SOLIMP,
    )
    tyre = _add_look(wheel, mujoco.mjtGeom.mjGEOM_CYLINDER, [radius, width / 2, 0], [0, 0, 0])
    tyre.quat = _sideways(0.0)
    motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_velocity(kv=_SERVO_GAIN)
    most = PUSH * _grip_torque(robot, drive)
    motor.forcelimited = True
    motor.forcerange = [-most, most]
    return motor


def _grip_torque(robot: RobotModel, drive: DifferentialDrive) -> float:
    """Return the torque, N m, at which the wheels on the level begin to slip."""
    along = [x for x, _ in drive.supports]
    on_casters = sum(shares(along, robot.base_centre_of_mass[0])[len(drive.places) :])
    on_wheels = 9.81 * (robot.base_mass * (1 - on_casters) + 2 * drive.wheel_mass)
    return GRIP[0] * on_wheels / 2 * drive.wheel_radius


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
    if isinstance(robot.body, CylinderBody):
        lidar_at = (robot.lidar.x, robot.lidar.y, robot.lidar.z - 0.005)
        radius = robot.body.radius
        return [
            LookShape("cylinder", (radius, height / 2, 0.0), (x, y, z), "#3a3f44"),
            LookShape("cylinder", (0.035, 0.02, 0.0), lidar_at, "black"),
            LookShape(
                "box",
                (0.006, width / 4, 0.006),
                (x + radius * 0.85, y, z + height / 2),
                "orange",
            ),
        ]
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
