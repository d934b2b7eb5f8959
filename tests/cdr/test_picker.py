"""What is picked from serialized messages is what they hold, however they are laid out."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from geometry_msgs.msg import TransformStamped, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage

from bt_mission.cdr.decoder import DecodingError, decoder_of
from bt_mission.cdr.picker import Picker, Texts

ODOMETRY = "nav_msgs/msg/Odometry"
NUMBERS = ("header.stamp.sec", "pose.pose.position.y", "twist.twist.angular.z")
names = st.text(st.characters(blacklist_characters="\0", blacklist_categories=["Cs"]), max_size=9)
numbers = st.floats(allow_nan=False)

picker = Picker(decoder_of(ODOMETRY), NUMBERS)


def odometry(sec: int, y: float, turn: float, frame: str = "odom", child: str = "base") -> Odometry:
    """A message with these numbers."""
    message = Odometry(child_frame_id=child)
    message.header.stamp.sec, message.header.frame_id = sec, frame
    message.pose.pose.position.y, message.twist.twist.angular.z = y, turn
    return message


@given(st.lists(st.tuples(st.integers(0, 2**31 - 1), numbers, numbers, names, names), min_size=1))
def test_one_message_after_another(values: Any) -> None:
    """Also where the next one's texts are longer, or of the same length and others."""
    for value in values:
        picked = picker.pick(serialize_message(odometry(*value)))
        assert picked.numbers == value[:3]
        assert (picked.texts["header.frame_id"], picked.texts["child_frame_id"]) == value[3:]


def test_the_numbers_may_depend_on_the_texts() -> None:
    """Of several transforms that which places a frame."""

    def choose(texts: Texts) -> list[str]:
        result = next(path for path, text in texts.items() if text == "wanted")
        return [result.replace("child_frame_id", "transform.translation.x")]

    chosen = Picker(decoder_of("tf2_msgs/msg/TFMessage"), choose)
    for order in (("wanted", "other"), ("others", "wanted"), ("other", "wanted")):
        message = TFMessage()
        for number, child in enumerate(order):
            stamped = TransformStamped(child_frame_id=child)
            stamped.transform.translation.x = 10.0 + number
            message.transforms.append(stamped)
        assert chosen.pick(serialize_message(message)).numbers == (10.0 + order.index("wanted"),)


def test_bytes_of_the_other_order_are_read() -> None:
    """A big-endian robot's."""
    wanted = Picker(decoder_of("geometry_msgs/msg/Twist"), ("linear.x", "angular.z"))
    data = b"\0\0\0\0" + struct.pack(">6d", 1.5, 0, 0, 0, 0, -2.5)
    assert wanted.pick(data).numbers == (1.5, -2.5)
    little = b"\0\1\0\0" + struct.pack("<6d", 1.5, 0, 0, 0, 0, -2.5)
    assert wanted.pick(little).numbers == (1.5, -2.5)


@pytest.mark.parametrize("end", [0, 2, 4, 10, 40, 300])
def test_a_message_that_is_cut_is_refused(end: int) -> None:
    """Also after one that was whole."""
    data = serialize_message(odometry(1, 2.0, 3.0))
    picker.pick(data)
    with pytest.raises(DecodingError, match=f"invalid message of type {ODOMETRY}"):
        picker.pick(data[:end])
    assert picker.pick(data).numbers == (1, 2.0, 3.0)


def test_a_number_that_is_not_there_is_refused() -> None:
    """As is one out of order: they are read from front to back."""
    data = serialize_message(TwistStamped())
    decoder = decoder_of("geometry_msgs/msg/TwistStamped")
    for paths in (("twist.linear.w",), ("twist.linear.y", "twist.linear.x")):
        with pytest.raises(DecodingError):
            Picker(decoder, paths).pick(data)


def test_who_publishes_in_turns_is_known_each_time() -> None:
    """As on `tf`, where the localization and the base have frames of their own."""
    asked: list[str] = []

    def choose(texts: Texts) -> tuple[str, ...]:
        asked.append(texts["header.frame_id"])
        return NUMBERS

    chosen = Picker(decoder_of(ODOMETRY), choose)
    for number in range(10):
        for frame in ("map", "odom", "mop"):
            picked = chosen.pick(serialize_message(odometry(number, 0.5, 1.5, frame)))
            assert (picked.numbers, picked.texts["header.frame_id"]) == ((number, 0.5, 1.5), frame)
    assert asked == ["map", "odom", "mop"]
