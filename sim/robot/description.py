"""The robot's frames and sensors, and its URDF for RViz and Foxglove.

The URDF is of boxes, cylinders and spheres. Its links are the frames, below `base_footprint`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from bt_mission.robots.body import CylinderBody
from bt_mission.robots.drives import DifferentialDrive, OmnidirectionalDrive
from bt_mission.robots.model import RobotModel
from sim.frames import BASE_FOOTPRINT, BASE_LINK, FramePose, Quaternion, Vector
from sim.physics.body import looks
from sim.robot.links import Link
from sim.sensors.battery import BatterySensor
from sim.sensors.bumper import BumperSensor
from sim.sensors.camera import LINK as CAMERA_LINK
from sim.sensors.camera import CameraInfoSensor, CameraSensor
from sim.sensors.depth_camera import DepthCameraSensor, DepthInfoSensor
from sim.sensors.distance import RangeSensor
from sim.sensors.imu import Imu
from sim.sensors.lidar import LidarSensor
from sim.sensors.sensor import Sensor, named
from sim.world.shapes import rgba

SENSORS: tuple[type[Sensor], ...] = (
    Imu,
    LidarSensor,
    BatterySensor,
    CameraInfoSensor,
    CameraSensor,
    DepthInfoSensor,
    DepthCameraSensor,
)

NAMED: tuple[type[Sensor], ...] = (LidarSensor, RangeSensor, BumperSensor)
"""Those of which a robot has several, each with a name."""


def sensors_of(robot: RobotModel) -> list[type[Sensor]]:
    """Return the kinds of sensors that a robot has."""
    kinds = [kind for kind in SENSORS if kind.figures(robot) is not None]
    return kinds + [named(kind, name) for kind in NAMED for name in getattr(robot, kind.table)]


# A quarter turn about x to the right: z along the axle to the left.
_SIDEWAYS: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


def fixed_frames(robot: RobotModel) -> list[FramePose]:
    """Return all frames below `base_footprint`. Wheels are shown as at the start."""
    drive = robot.drive
    axle_z = drive.wheel_radius - robot.base_height
    casters = drive.casters if isinstance(drive, DifferentialDrive) else ()
    names = _caster_names(casters)
    return [
        FramePose(BASE_FOOTPRINT, BASE_LINK, (0.0, 0.0, robot.base_height)),
        *(
            FramePose(BASE_LINK, f"{name}_link", (x, y, axle_z), _axle(robot, index))
            for index, (name, (x, y)) in enumerate(zip(drive.names, drive.places, strict=True))
        ),
        *(
            FramePose(BASE_LINK, name, at, _SIDEWAYS)
            for name, at in zip(names, casters, strict=True)
        ),
        *(frame for kind in sensors_of(robot) for frame in kind.frames(robot)),
    ]


def _axle(robot: RobotModel, index: int) -> Quaternion:
    """Return the rotation of a wheel's frame: z along its axle to the left of its heading."""
    if not isinstance(robot.drive, OmnidirectionalDrive):
        return _SIDEWAYS
    half = math.radians(robot.drive.wheels[index].heading) / 2
    x, _, _, w = _SIDEWAYS
    return math.cos(half) * x, math.sin(half) * x, math.sin(half) * w, math.cos(half) * w


def _caster_names(casters: Sequence[Vector]) -> list[str]:
    """Return the frame of each caster; those on the same side are numbered."""
    places = []
    for x, y, _ in casters:
        end = "_front" if x > 0 else "_back" if x < 0 else ""
        places.append(f"caster{end}{'_left' if y > 0 else '_right' if y < 0 else ''}")
    return [
        f"{place}_{places[:index].count(place) + 1}_link"
        if places.count(place) > 1
        else f"{place}_link"
        for index, place in enumerate(places)
    ]


_CAMERA = (0.02, 0.06, 0.02)
"""m: edges of what is shown for the camera."""


def description(robot: RobotModel, moved: Sequence[Link] = ()) -> str:
    """Return the URDF of a robot; its links are the frames of `tf` and `tf_static`.

    `moved` are the links of arm and gripper.
    """
    family = "turtlebot3_" if robot.name in ("burger", "waffle") else ""
    root = ET.Element("robot", name=family + robot.name)
    links = {BASE_FOOTPRINT: ET.SubElement(root, "link", name=BASE_FOOTPRINT)}
    for frame in fixed_frames(robot):
        links[frame.child] = ET.SubElement(root, "link", name=frame.child)
        _add_joint(root, frame)
    for each in moved:
        _add_link(root, each)
    _dress_base(links[BASE_LINK], robot)
    for name, link in links.items():
        if _is_wheel(name):
            _dress_wheel(link, robot)
        elif name.startswith("caster_"):
            for use in ("visual", "collision"):
                ball = _shape(link, use, "sphere", colour="black")
                ball.set("radius", _number(robot.drive.caster_radius))  # type: ignore[union-attr]
        elif name == CAMERA_LINK:
            _shape(link, "visual", "box", colour="black").set("size", _numbers(_CAMERA))
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _add_link(root: ET.Element, link: Link) -> None:
    """Add a link of an arm, and its joint, as in `joint_states`."""
    frame = link.frame
    element = ET.SubElement(root, "link", name=frame.child)
    for index, part in enumerate(link.shapes):
        visual = ET.SubElement(element, "visual")
        _origin(visual, part.at, _roll_pitch_yaw(part.rotation))
        shape = ET.SubElement(ET.SubElement(visual, "geometry"), part.kind)
        radius, height, _ = part.half
        if part.kind == "box":
            shape.set("size", _numbers([2 * edge for edge in part.half]))
        else:
            shape.set("radius", _number(radius))
        if part.kind == "cylinder":
            shape.set("length", _number(2 * height))
        material = ET.SubElement(visual, "material", name=f"{frame.child} {index}")
        ET.SubElement(material, "color", rgba=_numbers(part.rgba))
    kind = "prismatic" if link.is_slide else "revolute"
    joint = ET.SubElement(root, "joint", name=link.joint, type=kind)
    ET.SubElement(joint, "parent", link=frame.parent)
    ET.SubElement(joint, "child", link=frame.child)
    _origin(joint, frame.translation, _roll_pitch_yaw(frame.rotation))
    ET.SubElement(joint, "axis", xyz=_numbers(link.axis))
    limits = {"lower": link.limits.min, "upper": link.limits.max}
    limits |= {"velocity": link.limits.max_velocity, "effort": link.max_effort}
    ET.SubElement(joint, "limit", {name: _number(value) for name, value in limits.items()})


def _is_wheel(link: str) -> bool:
    return link.startswith("wheel_") or link.endswith("_wheel_link")


def _add_joint(root: ET.Element, frame: FramePose) -> None:
    turns = _is_wheel(frame.child)
    name = frame.child.removesuffix("_link") + "_joint"
    joint = ET.SubElement(root, "joint", name=name, type="continuous" if turns else "fixed")
    ET.SubElement(joint, "parent", link=frame.parent)
    ET.SubElement(joint, "child", link=frame.child)
    _origin(joint, frame.translation, _roll_pitch_yaw(frame.rotation))
    if turns:
        ET.SubElement(joint, "axis", xyz="0 0 1")


def _dress_base(link: ET.Element, robot: RobotModel) -> None:
    _add_mass(link, robot.base_mass, robot.base_inertia, robot.base_centre_of_mass)
    for look in looks(robot):
        shape = _shape(link, "visual", look.kind, look.at, look.colour)
        first, second, third = look.half
        if look.kind == "box":
            shape.set("size", _numbers((2 * first, 2 * second, 2 * third)))
        else:
            shape.set("radius", _number(first))
            shape.set("length", _number(2 * second))
    body = robot.body
    if isinstance(body, CylinderBody):
        hull = _shape(link, "collision", "cylinder", body.centre)
        hull.set("radius", _number(body.radius))
        hull.set("length", _number(body.height))
    else:  # URDF has no polygons: the box around it
        _shape(link, "collision", "box", body.centre).set("size", _numbers(body.size))


def _dress_wheel(link: ET.Element, robot: RobotModel) -> None:
    """Add the shape of a wheel, whose z axis is along the axle."""
    drive = robot.drive
    if isinstance(drive, DifferentialDrive):
        along_x, axle, along_z = drive.wheel_inertia
        _add_mass(link, drive.wheel_mass, (along_x, along_z, axle), (0.0, 0.0, 0.0))
    for use in ("visual", "collision"):
        tyre = _shape(link, use, "cylinder", colour="black")
        tyre.set("radius", _number(drive.wheel_radius))
        tyre.set("length", _number(drive.wheel_width))


def _add_mass(link: ET.Element, mass: float, moments: Sequence[float], at: Vector) -> None:
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, at)
    ET.SubElement(inertial, "mass", value=_number(mass))
    crossed = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    straight = dict(zip(("ixx", "iyy", "izz"), map(_number, moments), strict=True))
    ET.SubElement(inertial, "inertia", {**straight, **crossed})


def _shape(
    link: ET.Element, use: str, kind: str, at: Vector = (0.0, 0.0, 0.0), colour: str = ""
) -> ET.Element:
    """Add a visual or collision shape; return the element for its size."""
    part = ET.SubElement(link, use)
    _origin(part, at)
    shape = ET.SubElement(ET.SubElement(part, "geometry"), kind)
    if use == "visual":
        material = ET.SubElement(part, "material", name=colour)
        ET.SubElement(material, "color", rgba=_numbers(rgba(colour)))
    return shape


def _origin(parent: ET.Element, at: Vector, turned: Vector = (0.0, 0.0, 0.0)) -> None:
    ET.SubElement(parent, "origin", xyz=_numbers(at), rpy=_numbers(turned))


def _roll_pitch_yaw(rotation: Quaternion) -> Vector:
    x, y, z, w = rotation
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def _numbers(values: Sequence[float]) -> str:
    return " ".join(map(_number, values))


def _number(value: float) -> str:
    return f"{value:.9g}"
