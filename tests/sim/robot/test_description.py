"""The robot as URDF."""

from xml.etree import ElementTree as ET

import pytest

from bt_mission.core.robot.model import RobotModel, load_robot
from sim.frames import BASE_FOOTPRINT
from sim.robot.description import description
from sim.robot.frames import fixed_frames


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


def parsed(robot: RobotModel) -> ET.Element:
    """What an XML parser makes of it."""
    return ET.fromstring(description(robot))  # noqa: S314 - of our own making


def numbers(text: str | None) -> tuple[float, ...]:
    """The numbers of an attribute."""
    return tuple(map(float, (text or "").split()))
