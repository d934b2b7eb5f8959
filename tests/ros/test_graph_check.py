"""What a mission would find in a running graph."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import SetBool

from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read_text
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
    monkeypatch.setattr(graph_check, "LOOK_S", 1.0)
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
def test_each_name_is_found_or_missing_or_of_another_type() -> None:
    """Once each, in the robot's namespace; trees that are not used ask for nothing."""
    missing = graph_check.find_missing(MISSION, "robot1")
    assert [(each.wanted.what, each.wanted.name, each.is_there) for each in missing] == [
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
def test_servers_that_get_no_goal_are_named() -> None:
    """A second one of an action, and one whose feedback no client receives."""
    context = Context()
    rclpy.init(context=context)
    node = Node("more", context=context, namespace="robot1", enable_rosout=False)
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    servers = [
        ActionServer(node, Turn, "turn", lambda _: None),
        ActionServer(node, Turn, "dock", lambda _: None, status_pub_qos_profile=best_effort),
    ]
    dock = "action: {name: dock, type: bt_mission_interfaces/action/Turn, goal: {angle: 9}}"
    text = f"mission: m\ntree:\n  sequence:\n    - turn: {{angle: 9}}\n    - {dock}\n"
    diagnostics = [each.diagnostic() for each in graph_check.find_missing(load(text), "robot1")]
    for server in servers:
        server.destroy()
    node.destroy_node()
    context.shutdown()
    assert [(each.code, each.line) for each in diagnostics] == [("BT-914", 4), ("BT-917", 5)]
    assert "/robot1/turn has 2 servers (/robot1/more, /robot1/servers)" in diagnostics[0].message
    assert (
        "/robot1/dock: its server /robot1/more publishes status with best effort and volatile, an "
        "action client needs reliable and transient local"
    ) in diagnostics[1].message


@pytest.mark.usefixtures("robot")
def test_a_topic_that_is_followed_has_to_be_published() -> None:
    """As the type that the mission says; that somebody subscribes to it is not enough."""
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
    other = "/robot1/speech2 is a std_msgs/msg/String in the graph, not a std_msgs/msg/Bool"
    assert [(item.line, item.column, item.code, item.message) for item in diagnostics] == [
        (5, 5, "BT-510", "no publisher of /robot1/heard in the graph"),
        (6, 5, "BT-510", other),
    ]


LISTED = """\
# ros2 action list -t
/robot1/navigate_to_pose [nav2_msgs/action/NavigateToPose]
/spin [bt_mission_interfaces/action/Turn]
/robot1/backup [nav2_msgs/action/BackUp]
/robot2/backup [nav2_msgs/action/BackUp]
# bt-mission actions list, services list, topics list
/my/turn  bt_mission_interfaces/action/Turn  /bt_mission_servers
/stop     std_srvs/srv/SetBool, std_srvs/srv/Trigger
topic     type                 publishers  subscribers
/speech   std_msgs/msg/String  1           0
"""
DRIVES = """\
mission: drives
tree:
  sequence:
    - {navigate_to_pose: {pose: [1, 0, 0]}, timeout: 9}
    - {spin: {target_yaw: 1}, timeout: 9}
    - {back_up: {target: [1, 0, 0], speed: 0.1}, timeout: 9}
    - {turn: {angle: 90}, timeout: 9}
    - service: {name: stop, type: std_srvs/srv/Trigger}
    - {explore_forward: {fwd_velocity: 0.1, stopping_distance: 0.5}, timeout: 9}
    - publish: {topic: speech, type: std_msgs/msg/String}
"""


def test_a_saved_listing_says_where_each_name_is(tmp_path: Path) -> None:
    """In the lines of `ros2` and of `bt-mission`, also when the graph runs no more."""
    listing = tmp_path / "robot.txt"
    listing.write_text(LISTED, encoding="utf-8")
    findings = graph_check.find_missing_in(listing, load(read_text(DRIVES, "m.yaml")))
    assert [(finding.wanted.name, finding.is_there, finding.hint) for finding in findings] == [
        (
            "/navigate_to_pose",
            False,
            "/robot1/navigate_to_pose has this type; give --namespace robot1",
        ),
        ("/spin", False, None),
        (
            "/backup",
            False,
            "/robot1/backup, /robot2/backup have this type; give the --namespace of one of them",
        ),
        ("/turn", False, "/my/turn has this type; give --namespace my"),
        ("/stop", True, None),
        ("/explore_forward", False, None),
        ("/speech", True, None),
    ]
    (spin,) = [finding for finding in findings if finding.wanted.name == "/spin"]
    assert spin.diagnostic().message == (
        "/spin is a bt_mission_interfaces/action/Turn in the graph, not a nav2_msgs/action/Spin"
    )


@pytest.mark.parametrize(
    ("listed", "message"),
    [
        (
            "/turn\n",
            (
                "robot.txt:1: expected a name and its type, such as 'nav2_msgs/action/Spin', "
                "'std_srvs/srv/Trigger', 'std_msgs/msg/String', got '/turn'; list the graph with "
                "'ros2 action list -t'"
            ),
        ),
        ("\n", "robot.txt lists no action, service or topic; save 'ros2 action list -t'"),
    ],
)
def test_a_listing_without_types_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: str, message: str
) -> None:
    """With what to type instead."""
    monkeypatch.chdir(tmp_path)
    Path("robot.txt").write_text(listed, encoding="utf-8")
    with pytest.raises(BtMissionError) as refused:
        graph_check.find_missing_in(Path("robot.txt"), MISSION)
    assert (refused.value.code, str(refused.value)) == ("BT-513", message)


@pytest.mark.usefixtures("robot")
def test_an_action_whose_fields_differ_is_of_another_release(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As between Humble or Kilted and Jazzy: the name of the type is the same."""
    monkeypatch.setattr(graph_check, "type_hash_of", lambda *_: None)
    turn, *_ = graph_check.find_missing(MISSION, "robot1")
    assert str(turn.diagnostic()) == (
        "m.yaml:7:7: error: /robot1/turn: bt_mission_interfaces/action/Turn has other fields in "
        "the graph than here, so no goal arrives; install the same release of its package on both "
        "sides [BT-510]"
    )


def test_servers_that_are_not_there_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """After some seconds."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(graph_check, "LOOK_S", 0.5)
    assert graph_check.find_servers("nobody_at_all", ["turn_limit"]) is None
