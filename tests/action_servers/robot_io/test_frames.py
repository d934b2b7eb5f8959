"""Facts about the places of frames on the map."""

from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage

from action_servers.core.maneuver import Refusal
from action_servers.robot_io.sensors import Frames
from bt_mission.base.geometry import Pose2D


def message(*links: tuple[str, str, float, float, float], roll: float = 0.0) -> bytes:
    """A message of transforms: parent, child, x, y, yaw; the yaw is 0 where there is a roll."""
    made = TFMessage()
    for parent, child, x, y, yaw in links:
        stamped = TransformStamped()
        stamped.header.frame_id, stamped.child_frame_id = parent, child
        moved = stamped.transform
        moved.translation.x, moved.translation.y = x, y
        moved.rotation.x, moved.rotation.z = math.sin(roll / 2), math.sin(yaw / 2)
        moved.rotation.w = math.cos((roll or yaw) / 2)
        made.transforms.append(stamped)
    return bytes(serialize_message(made))


@pytest.fixture
def frames() -> Frames:
    """A robot at (1, 2) that faces up, as its odometry and localisation tell."""
    made = Frames("map")
    made.fixed.append(message(("base_link", "base_scan", -0.064, 0.0, 0.0)))
    made.fixed.append(message(("base_footprint", "base_link", 0.0, 0.0, 0.0)))
    made.moving.append(message(("map", "odom", 1.0, 1.0, math.pi / 2)))
    made.moving.append(message(("odom", "base_footprint", 9.0, 9.0, 0.0)))
    made.moving.append(message(("odom", "base_footprint", 1.0, 0.0, 0.0)))
    return made


def pose(result: Pose2D | Refusal) -> tuple[float, float, float]:
    """A pose as a tuple."""
    assert isinstance(result, Pose2D)
    return result.x, result.y, result.yaw


def test_a_frame_of_the_robot_is_found_through_all_between(frames):
    """By the newest of each transform."""
    assert pose(frames.on_map("base_scan")) == pytest.approx((1.0, 1.936, math.pi / 2))


def test_the_map_itself_lies_at_its_origin(frames):
    """Whatever it is called."""
    assert pose(frames.on_map("map")) == (0.0, 0.0, 0.0)


def test_a_frame_that_nobody_publishes_is_refused_with_those_that_are_known(frames):
    """A spelling mistake shows."""
    assert frames.on_map("base_lnk") == Refusal(
        "the frame 'base_lnk' has no transform to 'map' "
        "(known frames: base_footprint, base_link, base_scan, map, odom)"
    )


def test_a_tilted_frame_is_refused(frames):
    """What is ahead in a camera's optical frame is below in the map."""
    frames.fixed.append(message(("base_link", "optical", 0.0, 0.0, 0.0), roll=-math.pi / 2))
    result = frames.on_map("optical")
    assert isinstance(result, Refusal)
    assert "tilted" in result.reason


def test_frames_in_a_circle_end_in_a_refusal():
    """And not in a search without an end."""
    made = Frames("map")
    made.moving.append(message(("a", "b", 0.0, 0.0, 0.0), ("b", "a", 0.0, 0.0, 0.0)))
    assert isinstance(made.on_map("a"), Refusal)


def test_a_transform_without_finite_numbers_is_refused(frames):
    """A localisation that has lost itself publishes such."""
    frames.moving.append(message(("map", "odom", math.nan, 0.0, 0.0)))
    result = frames.on_map("base_link")
    assert isinstance(result, Refusal)
    assert "'map' to 'odom' holds no finite numbers" in result.reason
