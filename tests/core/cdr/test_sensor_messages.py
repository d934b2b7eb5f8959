"""Messages of sensors, decoded, are those that rclpy unpacks, number for number."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import TransformStamped, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from bt_mission.core.cdr.decoder import DecodingError, decoder_of

odometry = decoder_of("nav_msgs/msg/Odometry").decode
transforms = decoder_of("tf2_msgs/msg/TFMessage").decode
scan = decoder_of("sensor_msgs/msg/LaserScan").decode
twist_stamped = decoder_of("geometry_msgs/msg/TwistStamped").decode

texts = st.text(st.characters(blacklist_characters="\0", blacklist_categories=["Cs"]), max_size=9)
doubles = st.floats(allow_nan=False)
singles = st.floats(width=32, allow_nan=False)


def fill_header(header: Any, draw: Any) -> None:
    """Any stamp and frame."""
    header.stamp.sec = draw(st.integers(-(2**31), 2**31 - 1))
    header.stamp.nanosec = draw(st.integers(0, 2**32 - 1))
    header.frame_id = draw(texts)


def fill_numbers(message: Any, draw: Any) -> None:
    """Any value in each field."""
    for name in message.get_fields_and_field_types():
        setattr(message, name, draw(doubles))


@given(st.data())
def test_odometry(data: Any) -> None:
    """Whatever the lengths of the frames' names."""
    message = Odometry()
    fill_header(message.header, data.draw)
    message.child_frame_id = data.draw(texts)
    pose, twist = message.pose.pose, message.twist.twist
    for part in (pose.position, pose.orientation, twist.linear, twist.angular):
        fill_numbers(part, data.draw)
    read = odometry(serialize_message(message))
    assert_same_header(read.header, message.header)
    assert read.child_frame_id == message.child_frame_id
    assert read.pose.pose == {
        "position": numbers(pose.position),
        "orientation": numbers(pose.orientation),
    }
    assert read.twist.twist == {"linear": numbers(twist.linear), "angular": numbers(twist.angular)}


@given(st.data())
def test_commands(data: Any) -> None:
    """Every number of a velocity, and its stamp."""
    message = TwistStamped()
    fill_header(message.header, data.draw)
    for part in (message.twist.linear, message.twist.angular):
        fill_numbers(part, data.draw)
    read = twist_stamped(serialize_message(message))
    assert_same_header(read.header, message.header)
    assert read.twist == {
        "linear": numbers(message.twist.linear),
        "angular": numbers(message.twist.angular),
    }


@given(st.data())
def test_transforms(data: Any) -> None:
    """None, one or several in a message."""
    message = TFMessage()
    for _ in range(data.draw(st.integers(0, 3))):
        stamped = TransformStamped(child_frame_id=data.draw(texts))
        fill_header(stamped.header, data.draw)
        fill_numbers(stamped.transform.translation, data.draw)
        fill_numbers(stamped.transform.rotation, data.draw)
        message.transforms.append(stamped)
    read = transforms(serialize_message(message)).transforms
    assert len(read) == len(message.transforms)
    for mine, its in zip(read, message.transforms, strict=True):
        assert_same_header(mine.header, its.header)
        assert mine.child_frame_id == its.child_frame_id
        transform = its.transform
        assert mine.transform == {
            "translation": numbers(transform.translation),
            "rotation": numbers(transform.rotation),
        }


@given(st.data())
def test_scans(data: Any) -> None:
    """With any number of rays, NaN and infinity among them."""
    message = LaserScan(ranges=data.draw(st.lists(st.floats(width=32), max_size=9)))
    fill_header(message.header, data.draw)
    limits = (
        "angle_min",
        "angle_max",
        "angle_increment",
        "time_increment",
        "scan_time",
        "range_min",
        "range_max",
    )
    for name in limits:
        setattr(message, name, data.draw(singles))
    read = scan(serialize_message(message))
    assert_same_header(read.header, message.header)
    assert [getattr(read, name) for name in limits] == [getattr(message, name) for name in limits]
    assert read.ranges.dtype == np.float32
    assert np.array_equal(read.ranges, np.asarray(message.ranges, np.float32), equal_nan=True)


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (odometry, Odometry(child_frame_id="base")),
        (transforms, TFMessage(transforms=[TransformStamped(child_frame_id="odom")])),
        (scan, LaserScan(ranges=[1.0, 2.0])),
        (twist_stamped, TwistStamped()),
    ],
)
def test_a_message_that_is_cut_is_told_from_a_whole_one(read: Any, message: Any) -> None:
    """Wherever it ends."""
    whole = serialize_message(message)
    needed = len(whole)
    while needed and whole[needed - 1 : needed] == b"\0" and needed % 8:
        needed -= 1  # DDS pads a message to its alignment
    for length in range(needed - 8):
        with pytest.raises(DecodingError):
            read(whole[:length])
    assert read(whole)


def test_the_other_byte_order() -> None:
    """A sender of another architecture says so in the second byte."""
    body = struct.pack(">iII", 7, 8, 5) + b"odom\0" + b"\0" * 3 + struct.pack(">I", 2) + b"b\0"
    body += b"\0" * (-len(body) % 8) + struct.pack(">7d", *range(7)) + bytes(36 * 8)
    body += struct.pack(">6d", *range(6)) + bytes(36 * 8)
    read = odometry(b"\0\0\0\0" + body)
    assert read.header == {"stamp": {"sec": 7, "nanosec": 8}, "frame_id": "odom"}
    assert read.child_frame_id == "b"
    assert (read.pose.pose.orientation.w, read.twist.twist.angular.z) == (6.0, 5.0)


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\7\0\0" + bytes(99), b"\1\1\0\0" + bytes(99)])
def test_what_has_no_header_is_no_message(data: bytes) -> None:
    """Also one of an encoding that is not known here."""
    with pytest.raises(DecodingError, match="no CDR head"):
        odometry(data)


def numbers(message: Any) -> dict[str, float]:
    """The fields of a message."""
    return {name: getattr(message, name) for name in message.get_fields_and_field_types()}


def assert_same_header(mine: Any, its: Any) -> None:
    """Stamp and frame."""
    assert mine == {"stamp": numbers(its.stamp), "frame_id": its.frame_id}
