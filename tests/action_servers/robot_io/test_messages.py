"""Facts about translating ROS messages."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import pytest
from bt_mission_interfaces.action import CameraSweep, ExploreForward, Turn
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, JointState, LaserScan

from action_servers.core.maneuver import ErrorCode
from action_servers.robot_io.messages import (
    MOST_RAYS,
    OdometryMessage,
    fill,
    grid_of,
    image_of,
    joints_of,
    odometry_of,
    odometry_picker,
    scan_of,
    speed_limit_of,
    stamp_of,
)
from bt_mission.base.geometry import Twist2D
from bt_mission.base.stamps import NS
from bt_mission.robots.model import load_robot

NOW = Time(sec=12, nanosec=350_000_000)


def quaternion(yaw: float, scale: float = 1.0) -> Quaternion:
    """A turn about the vertical."""
    return Quaternion(z=scale * math.sin(yaw / 2.0), w=scale * math.cos(yaw / 2.0))


def test_equal_times_are_equal_floats():
    """A picture stamped now is not older than now."""
    message = Odometry()
    for nanosec in range(0, 1_000_000_000, 50_000_000):
        message.header.stamp = Time(sec=1_732_112_345, nanosec=nanosec)
        assert stamp_of(message.header) == (1_732_112_345 * NS + nanosec) / NS


def test_scan():
    """Rays are taken over as they are, without a copy."""
    message = LaserScan(angle_min=0.5, angle_increment=0.1, range_min=0.12, range_max=3.5)
    message.header.stamp = NOW
    message.ranges = array.array("f", [1.0, math.inf, math.nan, 0.0])
    scan: Any = scan_of(message)
    assert scan.stamp_s == 12.35
    assert (scan.angle_min, scan.angle_increment) == (0.5, 0.1)
    assert scan.ranges.dtype == np.float32
    np.testing.assert_array_equal(scan.ranges, np.array([1.0, np.inf, np.nan, 0.0]))
    assert np.shares_memory(scan.ranges, np.asarray(message.ranges))


@pytest.mark.parametrize(
    "wrong",
    [
        {"ranges": []},
        {"ranges": array.array("f", [1.0]) * (MOST_RAYS + 1)},
        {"ranges": [math.nan] * 3},
        {"ranges": [0.0, 0.0]},
        {"ranges": [math.nan, 0.0]},
        {"angle_min": math.nan},
        {"angle_min": 1e30},
        {"angle_increment": math.inf},
        {"angle_increment": 1e30},
        {"angle_increment": 0.0},
        {"range_min": math.nan},
        {"range_min": 4.0},
        {"range_max": math.nan},
        {"range_max": 0.0},
        {"range_max": -math.inf},
    ],
)
def test_a_scan_that_says_nothing_is_none(wrong):
    """No rays, too many, or none that measures, invalid directions, or limits without a range.

    Inf is a measurement: nothing is there.
    """
    sound: Any = {"angle_increment": 0.1, "range_min": 0.1, "range_max": 3.0}
    sound |= {"ranges": array.array("f", [math.inf, math.nan])}
    for lidar in (None, load_robot("waffle").lidar):
        assert scan_of(LaserScan(**sound), lidar) is not None
        assert scan_of(LaserScan(**sound | wrong), lidar) is None


def translated(message: Odometry) -> OdometryMessage | None:
    """An odometry message as it comes, serialized."""
    return odometry_of(odometry_picker().pick(serialize_message(message)))


@pytest.mark.parametrize("yaw", [0.0, 1.0, -1.0, 3.1, -3.1])
@pytest.mark.parametrize("scale", [1.0, 0.999, 2.0])
def test_odometry(yaw, scale):
    """Pose and velocity; the quaternion need not be of unit length."""
    message = Odometry()
    message.header.stamp, message.header.frame_id = NOW, "odom"
    message.pose.pose.position.x, message.pose.pose.position.y = 1.0, -2.0
    message.pose.pose.orientation = quaternion(yaw, scale)
    message.twist.twist.linear.x, message.twist.twist.angular.z = 0.2, -0.5
    odometry: Any = translated(message)
    assert (odometry.stamp_s, odometry.frame) == (12.35, "odom")
    assert (odometry.pose.x, odometry.pose.y) == (1.0, -2.0)
    assert odometry.pose.yaw == pytest.approx(yaw)
    assert odometry.velocity == Twist2D(0.2, -0.5)


@pytest.mark.parametrize("field", ["position.x", "position.y", "orientation.z", "orientation.w"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_odometry_that_is_no_number_is_none(field, value):
    """As good as not arrived; so are numbers beyond reason."""
    message = Odometry()
    outer, inner = field.split(".")
    setattr(getattr(message.pose.pose, outer), inner, value)
    assert translated(message) is None


@pytest.mark.parametrize("part", ["linear.x", "linear.y", "angular.z"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_velocity_that_is_no_number_is_none(part, value):
    """Also sideways."""
    message = Odometry()
    message.pose.pose.orientation.w = 1.0
    outer, inner = part.split(".")
    setattr(getattr(message.twist.twist, outer), inner, value)
    assert translated(message) is None


def test_a_force_that_nothing_measures_is_none():
    """NaN, as ros2_control sends it; positions and velocities that are not finite are not taken."""
    message = JointState(name=["a"], position=[1.0], velocity=[0.0], effort=[math.nan])
    readings = joints_of(message)
    assert readings is not None
    assert readings.efforts == {"a": 0.0}
    message.velocity = [math.nan]
    assert joints_of(message) is None


@pytest.mark.parametrize(
    ("percentage", "value", "expected"),
    [
        (False, 0.1, 0.1),
        (True, 50.0, 0.13),
        (False, 0.0, math.inf),
        (True, 0.0, math.inf),
        (False, -0.1, None),
        (False, math.nan, None),
        (False, math.inf, math.inf),
    ],
)
def test_speed_limit(percentage, value, expected):
    """In m/s or in percent of the robot's highest speed; 0 is no limit, as in Nav2."""
    message = SpeedLimit(percentage=percentage, speed_limit=value)
    assert speed_limit_of(message, 0.26) == expected


def grid(width: int = 3, resolution: float = 0.05, y: float = -2.0) -> OccupancyGrid:
    """A map of 3 x 2 cells, as told in its description or not."""
    message = OccupancyGrid()
    message.info.resolution, message.info.width, message.info.height = resolution, width, 2
    message.info.origin.position.x, message.info.origin.position.y = -1.0, y
    message.data = array.array("b", [0, 100, -1, 1, 2, 3] if width else [])
    return message


def test_grid():
    """Rows run along y."""
    result: Any = grid_of(grid())
    assert result.cells.tolist() == [[0, 100, -1], [1, 2, 3]]
    assert result.resolution == pytest.approx(0.05)
    assert (result.origin_x, result.origin_y) == (-1.0, -2.0)


@pytest.mark.parametrize(
    "wrong",
    [{"width": width} for width in (0, 2)]
    + [{"resolution": value} for value in (0.0, math.nan, math.inf, 1e-30)]
    + [{"y": value} for value in (math.nan, math.inf, 1e308)],
)
def test_a_grid_that_does_not_fit_or_is_at_no_place_is_none(wrong):
    """Size and cells must agree, and a cell must have a size and finite numbers."""
    assert grid_of(grid(**wrong)) is None


@pytest.mark.parametrize(
    ("encoding", "pixel", "rgb"),
    [
        ("rgb8", [1, 2, 3], [1, 2, 3]),
        ("bgr8", [1, 2, 3], [3, 2, 1]),
        ("rgba8", [1, 2, 3, 9], [1, 2, 3]),
        ("bgra8", [1, 2, 3, 9], [3, 2, 1]),
        ("mono8", [7], [7, 7, 7]),
    ],
)
def test_image_encodings(encoding, pixel, rgb):
    """Every common one becomes red, green, blue; bytes that fill a row up are left out."""
    row = [*pixel, *pixel, 0, 0]
    message = Image(height=2, width=2, step=len(row), encoding=encoding, data=bytes(row * 2))
    image = image_of(message)
    assert (image.height, image.width) == (2, 2)
    assert image.rgb.tolist() == [[rgb, rgb]] * 2


def test_an_encoding_that_is_not_known_is_told_with_those_that_are():
    """A depth camera on the topic of a colour camera."""
    with pytest.raises(ValueError, match=r"one of rgb8, bgr8, rgba8, bgra8, mono8, got '16UC1'"):
        image_of(Image(height=1, width=1, step=2, encoding="16UC1", data=bytes(2)))


@pytest.mark.parametrize(("height", "step", "count"), [(2, 3, 6), (2, 6, 11), (0, 6, 0)])
def test_an_image_whose_size_does_not_fit_is_told(height, step, count):
    """Instead of a picture that is torn."""
    message = Image(height=height, width=2, step=step, encoding="rgb8", data=bytes(count))
    with pytest.raises(ValueError, match=r"an image of 2 x \d pixels, rgb8"):
        image_of(message)


def test_a_field_that_is_not_there_is_told_with_those_that_are():
    """The name of the message, too."""
    with pytest.raises(
        AttributeError,
        match="Turn_Result has no field 'angel', only angle_turned, error_code, error_msg",
    ):
        fill(Turn.Result(), {"angel": 1.0}, lambda: NOW)


@pytest.mark.parametrize("action", [ExploreForward, Turn, CameraSweep])
def test_error_codes_are_those_of_the_interfaces(action):
    """The same name and number, wherever an interface names one."""
    named = {code.name: int(code) for code in ErrorCode}
    for name in ("NONE", "UNKNOWN", "STOPPED", "NO_ODOMETRY", "BLOCKED"):
        assert getattr(action.Result, name) == named[name]
    for name, number in named.items():
        assert getattr(action.Result, name, number) == number
