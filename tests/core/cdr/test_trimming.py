"""What rclpy adds to messages is taken away."""

from __future__ import annotations

from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu, JointState

from bt_mission.core.cdr.decoder import Decoder
from bt_mission.core.cdr.definitions import Definitions, share_folders
from bt_mission.core.cdr.trimming import Trim

DEFINITIONS = Definitions(share_folders())


def decoder(name: str) -> Decoder:
    """That of a type of sensor_msgs."""
    return Decoder(f"sensor_msgs/msg/{name}", DEFINITIONS.of(f"sensor_msgs/msg/{name}"))


def test_a_message_of_known_length_is_left_alone() -> None:
    """Nothing is even looked at."""
    taken: list[bytes] = []
    take = taken.append
    assert Trim(decoder("Imu"), has_one_shape=False).before(take) is take
    assert len(serialize_message(Imu())) == 4 + 8 + 4 + 1 + 3 + 8 * (4 + 9 + 3 + 9 + 3 + 9)


def test_room_for_a_sequence_that_is_empty_is_taken_away() -> None:
    """ROS reckons with its first element."""
    message = JointState(name=["left", "right"], position=[1.0, 2.0], velocity=[3.0, 4.0])
    data = serialize_message(message)
    for has_one_shape in (True, False):
        taken: list[bytes] = []
        take = Trim(decoder("JointState"), has_one_shape=has_one_shape).before(taken.append)
        take(data)
        take(data)
        assert taken == [data[:-4], data[:-4]]
