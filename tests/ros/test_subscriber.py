"""Messages of real topics, whatever quality of service they are sent with."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Int32, String

from bt_mission.core.errors import BtMissionError
from bt_mission.language.message_types import UnknownType
from bt_mission.ros.subscriber import LatestMessageSubscriber

LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
BEST_EFFORT_LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
TYPE = "std_msgs/msg/Int32"


def numbers_of(reader: LatestMessageSubscriber) -> list[int]:
    """Listen; gives the list to which each message's number is added."""
    numbers: list[int] = []
    reader.listen(lambda message: numbers.append(message.data))
    return numbers


@pytest.mark.parametrize("qos", [10, qos_profile_sensor_data, BEST_EFFORT_LATCHED])
def test_every_publisher_is_heard_once(rig: Any, qos: Any) -> None:
    """Reliable or not."""
    publisher = rig.node("talker").create_publisher(Int32, "n", qos)
    reader = LatestMessageSubscriber(rig.node("listener"), "n", TYPE)
    numbers = numbers_of(reader)
    rig.settle()
    publisher.publish(Int32(data=7))
    rig.settle()
    assert (reader.name, numbers) == ("/n", [7])


def test_a_latched_message_from_before_is_heard(rig: Any) -> None:
    """As soon as it has come, and again by whoever listens later."""
    publisher = rig.node("talker").create_publisher(Int32, "n", LATCHED)
    publisher.publish(Int32(data=7))
    reader = LatestMessageSubscriber(rig.node("listener"), "n", TYPE)
    first = numbers_of(reader)
    rig.settle(lambda: first != [])
    assert numbers_of(reader) == [7]


def test_a_latched_publisher_that_comes_later_is_found(rig: Any) -> None:
    """By looking around; the wait for it does so at every tick."""
    listener = rig.node("listener")
    reader = LatestMessageSubscriber(listener, "n", TYPE)
    numbers = numbers_of(reader)
    assert len(list(listener.subscriptions)) == 1
    publisher = rig.node("talker").create_publisher(Int32, "n", LATCHED)
    publisher.publish(Int32(data=7))

    def has_message() -> bool:
        reader.look_around()
        return numbers != []

    rig.settle(has_message)
    assert set(numbers) == {7}
    assert len(list(listener.subscriptions)) == 2


def test_who_leaves_hears_nothing_more(rig: Any) -> None:
    """Others do."""
    publisher = rig.node("talker").create_publisher(Int32, "n", 10)
    reader = LatestMessageSubscriber(rig.node("listener"), "n", TYPE)
    numbers = numbers_of(reader)
    gone: list[Any] = []
    reader.listen(gone.append)
    reader.leave(gone.append)
    reader.leave(gone.append)
    rig.settle()
    publisher.publish(Int32(data=7))
    rig.settle()
    assert (numbers, gone) == ([7], [])


def test_silence_is_explained(rig: Any) -> None:
    """Nobody, or publishers that say nothing."""
    reader = LatestMessageSubscriber(rig.node("listener"), "n", TYPE)
    assert reader.why_silent() == "it has no publisher"
    rig.node("talker").create_publisher(Int32, "n", 10)
    assert reader.why_silent() == "its publishers are silent"


def test_a_topic_of_another_type_is_refused(rig: Any) -> None:
    """Its messages would never come."""
    rig.node("talker").create_publisher(String, "n", 10)
    with pytest.raises(
        BtMissionError, match=f"/n is published as std_msgs/msg/String, not as {TYPE}"
    ):
        LatestMessageSubscriber(rig.node("listener"), "n", TYPE)


def test_a_type_that_is_not_installed_is_refused(rig: Any) -> None:
    """With the nearest one."""
    with pytest.raises(UnknownType, match="did you mean 'std_msgs/msg/Int32'"):
        LatestMessageSubscriber(rig.node("listener"), "n", "std_msgs/msg/Int31")
