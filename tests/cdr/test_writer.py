"""Messages that are kept as bytes are those that rclpy makes."""

from __future__ import annotations

import array

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import BatteryState, JointState
from tf2_msgs.msg import TFMessage

from bt_mission.cdr.writer import MessageTemplate

STAMP = Time(sec=3, nanosec=4)


def test_numbers_and_stamps_are_put_into_their_places():
    """As if the message had been filled; fields that were not named stay."""
    message = Odometry(child_frame_id="base")
    message.header.stamp, message.header.frame_id = STAMP, "odom"
    message.pose.covariance[35] = 0.25
    fields = ("pose.pose.position.x", "pose.pose.position.y", "twist.twist.angular.z")
    kept = MessageTemplate(message, STAMP, [(message, fields)], serialize_message)
    STAMP.sec, STAMP.nanosec = 70, 80
    message.pose.pose.position.x, message.pose.pose.position.y = 1.5, -2.0
    message.twist.twist.angular.z = 0.125
    assert deserialize_message(kept.packed(1.5, -2.0, 0.125), Odometry) == message


def test_lists_are_filled_in_place():
    """As many numbers as there were."""
    message = JointState(name=["left", "right"])
    message.position, message.velocity = array.array("d", (1, 2)), array.array("d", (0, 0))
    parts = [(message, ("position", "velocity"))]
    kept = MessageTemplate(message, message.header.stamp, parts, serialize_message)
    result = deserialize_message(kept.packed(1.0, 5.0, 6.0, 0.0), JointState)
    assert (list(result.position), list(result.velocity)) == ([1.0, 5.0], [6.0, 0.0])


def test_messages_within_a_message_are_parts_of_their_own():
    """Each with its stamp."""
    first, second = TransformStamped(child_frame_id="a"), TransformStamped(child_frame_id="b")
    first.header.stamp = second.header.stamp = STAMP
    both = TFMessage(transforms=[first, second])
    fields = ("transform.translation.x", "transform.rotation.z", "transform.rotation.w")
    kept = MessageTemplate(both, STAMP, [(first, fields), (second, fields)], serialize_message)
    STAMP.sec = 9
    numbers = [0.0, 0.5, 0.75, 1.0, 0.5, 0.75]
    results = deserialize_message(kept.packed(*numbers), TFMessage).transforms
    assert [result.transform.translation.x for result in results] == [0.0, 1.0]
    assert [result.header.stamp.sec for result in results] == [9, 9]
    assert results[1].transform.rotation.z == 0.5


def test_single_precision_is_kept():
    """As the message has it."""
    message = BatteryState(voltage=12.0)
    kept = MessageTemplate(
        message, message.header.stamp, [(message, ("voltage", "percentage"))], serialize_message
    )
    result = deserialize_message(kept.packed(12.0, 0.1), BatteryState)
    assert result.voltage == 12.0
    assert result.percentage == pytest.approx(0.1)
    assert result.percentage != 0.1


@pytest.mark.parametrize(
    ("part", "fields", "words"),
    [
        (Odometry(), ["twist.twist.linear.x"], r"linear\.x is in 0 places of a Odometry"),
        (None, ["twist.twist.linear.x", "pose.pose.position.x"], "in another order than it has"),
    ],
    ids=["a field of another message", "fields in another order"],
)
def test_fields_that_cannot_be_filled_are_refused(part, fields, words):
    """Numbers would be filled in in vain, or into the places of others."""
    message = Odometry()
    with pytest.raises(ValueError, match=words):
        MessageTemplate(message, STAMP, [(part or message, fields)], serialize_message)


def test_as_many_numbers_as_fields_are_wanted():
    """A message with a number left out would carry another one in its place."""
    message = BatteryState()
    parts = [(message, ("voltage", "percentage"))]
    kept = MessageTemplate(message, message.header.stamp, parts, serialize_message)
    for numbers in ([12.0], [12.0, 0.1, 0.2]):
        with pytest.raises(ValueError, match="expected 2 numbers"):
            kept.packed(*numbers)
