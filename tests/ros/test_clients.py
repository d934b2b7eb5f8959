"""Publishers, subscriptions and clients of real topics and services."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Bool, Int32, String
from std_srvs.srv import SetBool

from bt_mission.base.dds.liveliness import RECORDER
from bt_mission.base.errors import BtMissionError
from bt_mission.language.message_types import UnknownType
from bt_mission.ros.clients import RosServiceClient, TopicPublisher
from bt_mission.ros.interface_types import FillError
from bt_mission.ros.observable_publisher import ObservableNode
from bt_mission.ros.subscriber import LatestMessageSubscriber

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT_LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
INT = "std_msgs/msg/Int32"


def serve(node: Any, name: str) -> list[bool]:
    """Answer on a service; gives what was asked."""
    asked: list[bool] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request.data)
        response.success = request.data
        response.message = "seen"
        return response

    node.create_service(SetBool, name, answer)
    return asked


# ---- what does not fit -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "wrong", "nearest"),
    [
        (LatestMessageSubscriber, "std_msgs/msg/Int31", "std_msgs/msg/Int32"),
        (TopicPublisher, "std_msgs/msg/Boool", "std_msgs/msg/Bool"),
        (RosServiceClient, "std_srvs/srv/SetBol", "std_srvs/srv/SetBool"),
    ],
)
def test_a_type_that_is_not_installed_is_refused(
    rig: Any, kind: Any, wrong: str, nearest: str
) -> None:
    """With the nearest one."""
    with pytest.raises(UnknownType, match=f"{wrong} is not installed; did you mean '{nearest}'"):
        kind(rig.node("mine"), "n", wrong)


@pytest.mark.parametrize(
    ("kind", "wrong", "message"),
    [
        (LatestMessageSubscriber, INT, f"/n is published as std_msgs/msg/String, not as {INT}"),
        (TopicPublisher, INT, f"/n is a std_msgs/msg/String, not a {INT}"),
        (
            RosServiceClient,
            "std_srvs/srv/Trigger",
            "/n is a std_srvs/srv/SetBool, not a std_srvs/srv/Trigger",
        ),
    ],
)
def test_a_name_of_another_type_is_refused(rig: Any, kind: Any, wrong: str, message: str) -> None:
    """DDS would leave the two unmatched without a word."""
    other, node = rig.node("other"), rig.node("mine")
    if kind is RosServiceClient:
        serve(other, "n")
    elif kind is TopicPublisher:
        other.create_subscription(String, "n", lambda _: None, 10)
        rig.settle(lambda: "/n" in dict(node.get_topic_names_and_types()))
    else:
        other.create_publisher(String, "n", 10)
    with pytest.raises(BtMissionError, match=message):
        kind(node, "n", wrong)


@pytest.mark.parametrize(
    ("kind", "type_name"),
    [(TopicPublisher, "std_msgs/msg/Bool"), (RosServiceClient, "std_srvs/srv/SetBool")],
)
def test_a_value_that_does_not_fit_is_refused(rig: Any, kind: Any, type_name: str) -> None:
    """Before anything is sent."""
    with pytest.raises(FillError, match="data: expected a boolean"):
        kind(rig.node("mine"), "n", type_name).prepare({"data": 3})


# ---- services --------------------------------------------------------------------------------


def test_an_answer_is_handed_over_once(rig: Any) -> None:
    """When the node's executor serves it, and not within the call."""
    client, server = rig.node("client"), rig.node("server")
    caller = RosServiceClient(client, "ask", "std_srvs/srv/SetBool")
    assert caller.name == "/ask"
    rig.settle()
    assert not caller.is_ready()
    asked = serve(server, "ask")
    rig.settle(caller.is_ready)
    answers: list[Any] = []
    caller.call(caller.prepare({"data": True}), answers.append)
    assert answers == []
    rig.settle(lambda: len(answers) > 0)
    rig.settle()
    assert asked == [True]
    assert [(answer.success, answer.message) for answer in answers] == [(True, "seen")]


def test_a_forgotten_call_is_not_heard_of_any_more(rig: Any) -> None:
    """The server is asked all the same; the next call has its own answer."""
    client, server = rig.node("client"), rig.node("server")
    caller = RosServiceClient(client, "ask", "std_srvs/srv/SetBool")
    asked = serve(server, "ask")
    rig.settle(caller.is_ready)
    late: list[Any] = []
    answers: list[Any] = []
    forget = caller.call(caller.prepare({"data": True}), late.append)
    forget()
    caller.call(caller.prepare({"data": False}), answers.append)
    rig.settle(lambda: len(answers) > 0)
    rig.settle()
    assert asked == [True, False]
    assert late == []
    assert [answer.success for answer in answers] == [False]


# ---- topics ----------------------------------------------------------------------------------


def test_a_message_reaches_whoever_listens(rig: Any) -> None:
    """Readers are counted, and each gets it once; a recorder does not count as a reader."""
    node = rig.node("mission")
    writer = TopicPublisher(node, "lamp", "std_msgs/msg/Bool")
    (publisher,) = (known for known in node.publishers if known.topic_name == "/lamp")
    rig.node(RECORDER).create_subscription(Bool, "lamp", lambda _: None, 10)
    rig.settle(lambda: publisher.get_subscription_count() == 1)
    assert (writer.name, writer.count_readers()) == ("/lamp", 0)
    messages: list[Bool] = []
    rig.node("lamp").create_subscription(Bool, "lamp", messages.append, 10)
    rig.settle(lambda: writer.count_readers() == 1)
    writer.publish(writer.prepare({"data": True}))
    rig.settle(lambda: bool(messages))
    assert [message.data for message in messages] == [True]


def numbers_of(reader: LatestMessageSubscriber) -> list[int]:
    """Listen; gives the list to which each message's number is added."""
    numbers: list[int] = []
    reader.listen(lambda message: numbers.append(message.data))
    return numbers


@pytest.mark.parametrize("qos", [10, qos_profile_sensor_data, BEST_EFFORT_LATCHED])
def test_every_publisher_is_heard_once(rig: Any, qos: Any) -> None:
    """Reliable or not, until the listener leaves; others stay."""
    publisher = rig.node("talker").create_publisher(Int32, "n", qos)
    reader = LatestMessageSubscriber(rig.node("listener"), "n", INT)
    numbers = numbers_of(reader)
    gone: list[Any] = []
    reader.listen(gone.append)
    reader.leave(gone.append)
    reader.leave(gone.append)
    rig.settle()
    publisher.publish(Int32(data=7))
    rig.settle()
    assert (reader.name, numbers, gone) == ("/n", [7], [])


def test_a_latched_message_from_before_is_heard(rig: Any) -> None:
    """As soon as it has come, and again by whoever listens later."""
    publisher = rig.node("talker").create_publisher(Int32, "n", LATCHED)
    publisher.publish(Int32(data=7))
    reader = LatestMessageSubscriber(rig.node("listener"), "n", INT)
    first = numbers_of(reader)
    rig.settle(lambda: first != [])
    assert numbers_of(reader) == [7]


def test_a_latched_publisher_that_comes_later_is_found(rig: Any) -> None:
    """By looking around; the wait for it does so at every tick."""
    listener = rig.node("listener")
    reader = LatestMessageSubscriber(listener, "n", INT)
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


def test_silence_is_explained(rig: Any) -> None:
    """Nobody, or publishers that say nothing."""
    reader = LatestMessageSubscriber(rig.node("listener"), "n", INT)
    assert reader.why_silent() == "it has no publisher"
    rig.node("talker").create_publisher(Int32, "n", 10)
    assert reader.why_silent() == "its publishers are silent"


def test_nodes_of_a_stage_make_the_handlers_of_events_that_are_asked_for(context: Any) -> None:
    """And no others, which their executor does not serve; rclpy would make two for each."""
    node = ObservableNode(
        "observable", context=context, enable_rosout=False, start_parameter_services=False
    )
    lost = PublisherEventCallbacks(liveliness=lambda _: None, use_default_callbacks=False)
    result = SubscriptionEventCallbacks(liveliness=lambda _: None, use_default_callbacks=False)
    entities: list[Any] = [
        node.create_publisher(String, "a", 10),
        node.create_subscription(String, "a", lambda _: None, 10),
        node.create_publisher(String, "a", 10, event_callbacks=lost),
        node.create_subscription(String, "a", lambda _: None, 10, event_callbacks=result),
    ]
    assert [len(entity.event_handlers) for entity in entities] == [0, 0, 1, 1]
    node.destroy_node()
