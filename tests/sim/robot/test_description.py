"""The robot as URDF."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bt_mission.core.robot.model import RobotModel, load_robot
from sim.frames import BASE_FOOTPRINT
from sim.physics.names import STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.robot.description import description
from sim.robot.frames import fixed_frames
from sim.simulation import Simulation
from sim.world.loader import load_world


@pytest.fixture(params=["waffle", "burger"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    """Each shipped robot."""
    return load_robot(request.param)


def test_links_are_the_frames_of_tf(robot: RobotModel) -> None:
    """All of `tf_static`, and `base_footprint`, which `tf` moves."""
    links = {link.get("name") for link in parsed(robot).findall("link")}
    fixed = fixed_frames(robot)
    assert links == {BASE_FOOTPRINT, *(frame.child for frame in fixed)}


def test_joints_stand_where_tf_has_them(robot: RobotModel) -> None:
    """Parent, child and place; those of the wheels are named as in `joint_states`."""
    joints = parsed(robot).findall("joint")
    result = {}
    for joint in joints:
        parent, child, origin = (joint.find(name) for name in ("parent", "child", "origin"))
        assert parent is not None
        assert child is not None
        assert origin is not None
        result[child.get("link")] = (parent.get("link"), numbers(origin.get("xyz")))
    for frame in fixed_frames(robot):
        parent_name, place = result[frame.child]
        assert parent_name == frame.parent
        assert place == pytest.approx(frame.translation)
    turning = {joint.get("name") for joint in joints if joint.get("type") == "continuous"}
    assert turning == {"wheel_left_joint", "wheel_right_joint"}


def test_directions_are_those_of_tf() -> None:
    """Roll, pitch and yaw of the camera's optical frame and of a wheel."""
    root = parsed(load_robot("waffle"))
    turned = {
        joint.find("child").get("link"): numbers(joint.find("origin").get("rpy"))  # type: ignore[union-attr]
        for joint in root.findall("joint")
    }
    quarter = 1.5707963
    assert turned["camera_rgb_optical_frame"] == pytest.approx((-quarter, 0, -quarter), abs=1e-6)
    assert turned["wheel_left_link"] == pytest.approx((-quarter, 0, 0), abs=1e-6)


def test_what_has_a_mass_has_a_positive_one(robot: RobotModel) -> None:
    """Base and wheels; moments of inertia are positive, too, and of a body that can be."""
    bodies = parsed(robot).findall("link/inertial")
    assert len(bodies) == 3
    for body in bodies:
        mass, inertia = body.find("mass"), body.find("inertia")
        assert mass is not None
        assert inertia is not None
        assert float(mass.get("value", "0")) > 0
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
        colour = visual.find("material/color")
        assert colour is not None
        assert all(0 <= part <= 1 for part in numbers(colour.get("rgba")))


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
        joint = root.find(f"joint/child[@link='{frame.child}']/..")
        assert joint is not None
        origin, axis, name = joint.find("origin"), joint.find("axis"), joint.get("name", "")
        assert origin is not None
        assert axis is not None
        place = np.array(numbers(origin.get("xyz")))
        turn = Rotation.from_euler("xyz", numbers(origin.get("rpy")))
        way = positions[name] * np.array(numbers(axis.get("xyz")))
        if joint.get("type") == "prismatic":
            place = place + turn.apply(way)
        else:
            turn *= Rotation.from_rotvec(way)
        assert place == pytest.approx((x, y, z), abs=1e-6)
        assert (turn.inv() * Rotation.from_quat(quaternion)).magnitude() < 1e-6
    parents = [frame.parent.removesuffix("_link") for frame in frames]
    assert parents == ["base", "joint1", "joint2", "joint3", "joint4", "joint4"]
    assert all(root.find(f"link[@name='{frame.child}']/visual") is not None for frame in frames)


def parsed(robot: RobotModel) -> ET.Element:
    """What an XML parser makes of it."""
    return ET.fromstring(description(robot))  # noqa: S314 - of our own making


def numbers(text: str | None) -> tuple[float, ...]:
    """The numbers of an attribute."""
    return tuple(map(float, (text or "").split()))
