"""Messages on a real topic."""

from __future__ import annotations

from typing import Any

import pytest
from std_msgs.msg import Bool, String

from bt_mission.core.dds.liveliness import RECORDER
from bt_mission.core.errors import BtMissionError
from bt_mission.language.message_types import UnknownType
from bt_mission.ros.clients import TopicPublisher
from bt_mission.ros.interface_types import FillError


def test_a_message_reaches_whoever_listens(rig: Any) -> None:
    """Readers are counted, and each gets it once."""
    writer = TopicPublisher(rig.node("mission"), "lamp", "std_msgs/msg/Bool")
    assert (writer.name, writer.count_readers()) == ("/lamp", 0)
    messages: list[Bool] = []
    rig.node("lamp").create_subscription(Bool, "lamp", messages.append, 10)
    rig.settle(lambda: writer.count_readers() == 1)
    writer.publish(writer.prepare({"data": True}))
    rig.settle(lambda: bool(messages))
    assert [message.data for message in messages] == [True]


def test_a_recorder_does_not_count_as_a_reader(rig: Any) -> None:
    """A mission that waits for somebody to listen waits on while it is recorded."""
    node = rig.node("mission")
    writer = TopicPublisher(node, "lamp", "std_msgs/msg/Bool")
    (publisher,) = (known for known in node.publishers if known.topic_name == writer.name)
    rig.node(RECORDER).create_subscription(Bool, "lamp", lambda _: None, 10)
    rig.settle(lambda: publisher.get_subscription_count() == 1)
    assert writer.count_readers() == 0


def test_a_value_that_does_not_fit_is_refused(rig: Any) -> None:
    """Before anything is sent."""
    writer = TopicPublisher(rig.node("mission"), "lamp", "std_msgs/msg/Bool")
    with pytest.raises(FillError, match="expected a boolean"):
        writer.prepare({"data": 3})


def test_a_type_that_is_not_installed_is_refused(rig: Any) -> None:
    """With the nearest that is."""
    with pytest.raises(UnknownType, match="std_msgs/msg/Bool"):
        TopicPublisher(rig.node("mission"), "lamp", "std_msgs/msg/Boool")


def test_a_topic_of_another_type_is_refused(rig: Any) -> None:
    """DDS would leave the two unmatched without a word."""
    node = rig.node("lamp")
    node.create_subscription(String, "lamp", lambda _: None, 10)
    other = rig.node("mission")
    rig.settle(lambda: bool(dict(other.get_topic_names_and_types()).get("/lamp")))
    with pytest.raises(BtMissionError, match=r"/lamp is a std_msgs/msg/String, not a std_msgs"):
        TopicPublisher(other, "lamp", "std_msgs/msg/Bool")
