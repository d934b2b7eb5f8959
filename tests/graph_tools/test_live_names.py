"""Names of the running graph, for shells that complete a word."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.msg import MissionState
from std_msgs.msg import String
from std_srvs.srv import SetBool

from bt_mission.graph_tools.graph_query import LIVE_LOOK_S, LIVE_QUIET_S
from bt_mission.sessions.scripted_server import ScriptedServer


@pytest.fixture
def graph(ros: Any) -> Any:
    """Two actions, a topic and a service of others; one node lies in a namespace."""
    ros.server("turn")
    ScriptedServer(ros.node("spinner"), "nav2_msgs/action/Spin", "robot1/spin")
    ros.client.create_publisher(String, "speech", 1)
    ros.client.create_service(SetBool, "switch", lambda _, answer: answer)
    return ros


@pytest.mark.parametrize(
    ("kind", "some"),
    [
        ("actions", ["/robot1/spin", "/turn"]),
        ("topics", ["/speech"]),
        ("services", ["/switch"]),
    ],
)
def test_names_of_a_kind_are_printed(graph: Any, type_in: Any, kind: str, some: list[str]) -> None:
    """One a line; those that ROS hides are left out."""
    done = type_in("completion", "--names", kind)
    assert (done.code, done.err) == (0, "")
    assert set(some) <= set(done.lines)
    assert not any("/_" in name for name in done.lines)
    assert done.lines == sorted(done.lines)


def test_executives_are_those_that_watch_can_show(ros: Any, type_in: Any) -> None:
    """By their state; names as `watch` takes them."""
    ros.client.create_publisher(MissionState, "/robot1/bt_mission/state", 1)
    ros.client.create_publisher(String, "/robot2/other/state", 1)
    expected = ["/robot1/bt_mission"]
    assert type_in("completion", "--names", "executives").lines == expected


def test_namespaces_are_those_of_nodes(ros: Any, type_in: Any) -> None:
    """Without the root, which is where nothing is given."""
    ros.mission("mission: m\ntree: {wait: 9}\n", namespace="robot1")
    assert type_in("completion", "--names", "namespaces").lines == ["/robot1"]


def test_a_graph_with_nobody_in_it_is_left_soon(ros: Any, hand: Any, type_in: Any) -> None:
    """Without a word: somebody is typing."""
    ros.drop(ros.client)
    begin_ns = hand.now_ns
    done = type_in("completion", "--names", "actions")
    assert (done.code, done.out, done.err) == (0, "", "")
    assert hand.now_ns - begin_ns <= (LIVE_LOOK_S + 0.1) * 1e9


def test_a_graph_that_is_known_is_left_sooner(graph: Any, hand: Any, type_in: Any) -> None:
    """When nothing new has come up for a moment."""
    begin_ns = hand.now_ns
    assert type_in("completion", "--names", "actions").lines == ["/robot1/spin", "/turn"]
    assert hand.now_ns - begin_ns <= (LIVE_QUIET_S + 0.2) * 1e9


def test_a_domain_that_is_none_is_no_error_while_typing(
    monkeypatch: pytest.MonkeyPatch, type_in: Any
) -> None:
    """The command itself will tell."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "abc")
    done = type_in("completion", "--names", "topics")
    assert (done.code, done.out, done.err) == (0, "", "")
