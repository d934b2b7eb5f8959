"""What a mission would find in a running graph."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer
from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool

from bt_mission.core.yaml.document import read_text
from bt_mission.ros import graph_check
from bt_mission.sessions.load import load

MISSION = load(
    read_text(
        "mission: m\ntrees:\n"
        "  idle: {do: {service: {name: not_used, type: std_srvs/srv/Trigger}}}\n"
        "  say: {do: {publish: {topic: speech, type: std_msgs/msg/String}}}\n"
        "tree:\n  sequence:\n"
        "    - {turn: {angle: 9}, timeout: 3}\n"
        "    - {turn: {angle: 9}, timeout: 3}\n"
        "    - service: {name: stop, type: std_srvs/srv/Trigger}\n"
        "    - service: {name: /spot, type: std_srvs/srv/Trigger}\n"
        "    - tree: say\n",
        "m.yaml",
    )
)


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A graph with an action, a service of another type, and a topic, for a robot."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = Context()
    rclpy.init(context=context)
    node = Node("servers", context=context, namespace="robot1", enable_rosout=False)
    server = ActionServer(node, Turn, "turn", lambda _: None)
    node.create_service(SetBool, "stop", lambda _, answer: answer)
    node.create_publisher(String, "speech", 10)
    node.create_publisher(String, "speech2", 10)
    node.create_subscription(String, "heard", lambda _: None, 10)
    yield
    server.destroy()
    node.destroy_node()
    context.shutdown()


@pytest.mark.usefixtures("robot")
def test_each_name_is_found_or_missing_or_of_another_type(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once each, in the robot's namespace; trees that are not used ask for nothing."""
    monkeypatch.setattr(graph_check, "LOOK_S", 1.0)
    missing = graph_check.find_missing(MISSION, "robot1")
    assert [
        (finding.wanted.what, finding.wanted.name, finding.is_there) for finding in missing
    ] == [
        ("action", "/robot1/turn", True),
        ("service", "/robot1/stop", False),
        ("service", "/spot", False),
        ("topic", "/robot1/speech", True),
    ]
    assert [str(item.diagnostic()) for item in missing if not item.is_there] == [
        (
            "m.yaml:9:7: error: /robot1/stop is a std_srvs/srv/SetBool in the graph, not a "
            "std_srvs/srv/Trigger [BT-510]"
        ),
        "m.yaml:10:7: error: no service /spot in the graph [BT-510]",
    ]


@pytest.mark.usefixtures("robot")
def test_a_topic_that_is_followed_has_to_be_published(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the type that the mission says; that somebody subscribes to it is not enough."""
    monkeypatch.setattr(graph_check, "LOOK_S", 1.0)
    follow = "".join(
        f"  - {{topic: {topic}, type: std_msgs/msg/{kind}, field: data, as: {name}}}\n"
        for topic, kind, name in (
            ("speech", "String", "a"),
            ("/robot1/speech", "String", "b"),
            ("heard", "String", "c"),
            ("speech2", "Bool", "d"),
        )
    )
    text = f"mission: m\nfollow:\n{follow}tree: {{log: $a $b $c $d}}\n"
    missing = graph_check.find_missing(load(read_text(text, "m.yaml")), "robot1")
    assert [(finding.wanted.name, finding.is_there) for finding in missing] == [
        ("/robot1/speech", True),
        ("/robot1/heard", False),
        ("/robot1/speech2", False),
    ]
    diagnostics = [item.diagnostic() for item in missing if not item.is_there]
    assert [(item.line, item.column, item.code, item.message) for item in diagnostics] == [
        (5, 5, "BT-510", "no publisher of /robot1/heard in the graph"),
        (
            6,
            5,
            "BT-510",
            "/robot1/speech2 is a std_msgs/msg/String in the graph, not a std_msgs/msg/Bool",
        ),
    ]


def test_servers_that_are_not_there_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """After some seconds."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(graph_check, "LOOK_S", 0.5)
    assert graph_check.find_servers("nobody_at_all", ["turn_limit"]) is None
