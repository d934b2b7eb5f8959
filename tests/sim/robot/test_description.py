"""The robot's frames, as the URDF of a TurtleBot3 has them, and the robot as URDF."""

import math
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bt_mission.robots.model import RobotModel, load_robot
from sim.frames import BASE_FOOTPRINT
from sim.physics.names import STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.robot.description import description, fixed_frames
from sim.simulation import Simulation
from sim.world.loader import load_world


@pytest.fixture(params=["waffle", "burger"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    """Two shipped robots."""
    return load_robot(request.param)


def parsed(robot: RobotModel) -> ET.Element:
    """What an XML parser makes of it."""
    return ET.fromstring(description(robot))  # noqa: S314 - of our own making


def part(element: ET.Element | None, path: str) -> ET.Element:
    """A part of an element, which is there."""
    assert element is not None
    result = element.find(path)
    assert result is not None, path
    return result


def numbers(text: str | None) -> tuple[float, ...]:
    """The numbers of an attribute."""
    return tuple(map(float, (text or "").split()))


def test_a_waffle_has_every_frame_of_its_urdf_once() -> None:
    """One tree below base_footprint; metres in their parents, unit quaternions."""
    frames = {frame.child: frame for frame in fixed_frames(load_robot("waffle"))}
    assert len(frames) == len(fixed_frames(load_robot("waffle")))
    assert {child: frame.parent for child, frame in frames.items()} == {
        "base_link": "base_footprint",
        "wheel_left_link": "base_link",
        "wheel_right_link": "base_link",
        "caster_back_left_link": "base_link",
        "caster_back_right_link": "base_link",
        "imu_link": "base_link",
        "base_scan": "base_link",
        "camera_link": "base_link",
        "camera_rgb_frame": "camera_link",
        "camera_rgb_optical_frame": "camera_rgb_frame",
    }
    assert frames["base_link"].translation == pytest.approx((0, 0, 0.010))
    assert frames["base_scan"].translation == pytest.approx((-0.064, 0, 0.122))
    assert frames["wheel_left_link"].translation == pytest.approx((0, 0.144, 0.023))
    assert frames["camera_rgb_frame"].translation == pytest.approx((0.005, 0.018, 0.013))
    assert all(math.hypot(*frame.rotation) == pytest.approx(1) for frame in frames.values())


def test_a_burger_has_one_caster_and_no_camera() -> None:
    """Its caster's frame has no side in its name."""
    children = {frame.child for frame in fixed_frames(load_robot("burger"))}
    assert "caster_back_link" in children
    assert not any("camera" in child for child in children)


def test_links_and_joints_stand_where_tf_has_them(robot: RobotModel) -> None:
    """`tf_static`, and `base_footprint`; joints of wheels are named as in `joint_states`."""
    root, fixed = parsed(robot), fixed_frames(robot)
    links = {link.get("name") for link in root.findall("link")}
    assert links == {BASE_FOOTPRINT, *(frame.child for frame in fixed)}
    for frame in fixed:
        joint = part(root, f"joint/child[@link='{frame.child}']/..")
        assert part(joint, "parent").get("link") == frame.parent
        assert numbers(part(joint, "origin").get("xyz")) == pytest.approx(frame.translation)
    turning = {joint.get("name") for joint in root.findall("joint[@type='continuous']")}
    assert turning == {"wheel_left_joint", "wheel_right_joint"}


@pytest.mark.parametrize(
    ("link", "rpy"),
    [
        ("camera_rgb_optical_frame", (-math.pi / 2, 0, -math.pi / 2)),
        ("wheel_left_link", (-math.pi / 2, 0, 0)),
    ],
)
def test_directions_are_those_of_tf(link: str, rpy: tuple[float, ...]) -> None:
    """Roll, pitch and yaw."""
    joint = part(parsed(load_robot("waffle")), f"joint/child[@link='{link}']/..")
    assert numbers(part(joint, "origin").get("rpy")) == pytest.approx(rpy, abs=1e-6)


def test_what_has_a_mass_has_a_positive_one(robot: RobotModel) -> None:
    """Base and wheels; moments of inertia are positive, too, and of a body that can be."""
    bodies = parsed(robot).findall("link/inertial")
    assert len(bodies) == 3
    base = part(parsed(robot), "link[@name='base_link']/inertial/origin")
    assert numbers(base.get("xyz")) == pytest.approx(robot.base_centre_of_mass)
    for body in bodies:
        assert float(part(body, "mass").get("value", "0")) > 0
        inertia = part(body, "inertia")
        moments = sorted(float(inertia.get(name, "0")) for name in ("ixx", "iyy", "izz"))
        assert 0 < moments[0] <= moments[2] <= moments[0] + moments[1]


def test_every_shape_has_a_size(robot: RobotModel) -> None:
    """Above zero; those that are seen have a colour."""
    root = parsed(robot)
    shapes = [shape for geometry in root.iter("geometry") for shape in geometry]
    assert len(shapes) > 10
    for shape in shapes:
        assert all(size > 0 for value in shape.attrib.values() for size in numbers(value))
    for visual in root.iter("visual"):
        colour = part(visual, "material/color").get("rgba")
        assert all(0 <= share <= 1 for share in numbers(colour))


def test_a_robot_drawn_from_its_description_stands_as_in_tf() -> None:
    """URDF with the positions of `joint_states` gives the frames of `tf`, wherever the arm is."""
    simulation = Simulation(
        load_world("empty_arena"), [RobotSpawn(load_robot("waffle_arm"))], seed=1
    )
    (robot,) = simulation.robots
    assert robot.links is not None
    assert robot.servos is not None
    robot.servos.command(("joint1", "joint2"), (0.7, 0.4))
    simulation.advance_to(simulation.time_ns + 200 * STEP_NS)
    root = ET.fromstring(description(robot.robot, robot.links.all))  # noqa: S314 - ours
    positions = dict(zip(robot.servos.names, robot.servos.readings["position"], strict=True))
    frames = robot.links.frames
    sent = np.array(robot.links.places()).reshape(len(frames), 7)
    assert positions["joint1"] == pytest.approx(0.7, abs=0.02)
    for frame, (x, y, z, *quaternion) in zip(frames, sent, strict=True):
        joint = part(root, f"joint/child[@link='{frame.child}']/..")
        origin = part(joint, "origin")
        place = np.array(numbers(origin.get("xyz")))
        turn = Rotation.from_euler("xyz", numbers(origin.get("rpy")))
        axis = np.array(numbers(part(joint, "axis").get("xyz")))
        way = positions[joint.get("name", "")] * axis
        if joint.get("type") == "prismatic":
            place = place + turn.apply(way)
        else:
            turn *= Rotation.from_rotvec(way)
        assert place == pytest.approx((x, y, z), abs=1e-6)
        assert (turn.inv() * Rotation.from_quat(quaternion)).magnitude() < 1e-6
        part(root, f"link[@name='{frame.child}']/visual")
    parents = [frame.parent.removesuffix("_link") for frame in frames]
    assert parents == ["base", "joint1", "joint2", "joint3", "joint4", "joint4"]
