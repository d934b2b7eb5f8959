"""``list`` and ``info``: what there is in a graph."""

from __future__ import annotations

import json
from typing import Any

import pytest
from bt_mission_interfaces.msg import MissionState
from std_msgs.msg import String

from bt_mission.commands.graph import graph_query
from tests.support.graph import TURN


def test_actions_are_listed_with_type_and_server(graph: Any, type_in: Any) -> None:
    """In the order of their names; for programs with their clients."""
    done = type_in("actions", "list")
    assert done.lines == [
        "/robot1/spin  nav2_msgs/action/Spin              /spinner",
        "/turn         bt_mission_interfaces/action/Turn  /turn_server",
    ]
    objects = json.loads(type_in("actions", "list", "--json").out)
    nodes = {"servers": ["/turn_server"], "clients": []}
    assert objects[1] == {"name": "/turn", "types": [TURN], **nodes}


@pytest.mark.parametrize(("kind", "name"), [("topics", "/speech"), ("services", "/switch")])
def test_hidden_names_are_left_out_unless_asked_for(
    graph: Any, type_in: Any, kind: str, name: str
) -> None:
    """An action's topics and services are its own affair."""
    shown = type_in(kind, "list")
    assert name in shown.out
    assert "_action" not in shown.out
    everything = type_in(kind, "list", "--all")
    part = "feedback" if kind == "topics" else "send_goal"
    assert f"/turn/_action/{part}" in everything.out
    names = [entry["name"] for entry in json.loads(type_in(kind, "list", "--json").out)]
    assert name in names
    assert not any("_action" in text for text in names)


def test_an_empty_graph_is_said_to_be_empty(ros: Any, type_in: Any) -> None:
    """With the time that was looked for; programs get an empty list."""
    done = type_in("actions", "list", "--wait", "2")
    assert (done.code, done.out) == (0, "")
    assert done.err == "no actions in the graph (looked for 2 s)\n"
    assert json.loads(type_in("actions", "list", "--json", "--wait", "2").out) == []


def test_what_only_we_take_part_in_is_no_topic(ros: Any, type_in: Any) -> None:
    """Every node has some of its own, ours too."""
    ros.drop(ros.client)
    ros.node("beat").create_timer(0.1, lambda: None)
    names = [entry["name"] for entry in json.loads(type_in("topics", "list", "--json").out)]
    assert names == ["/parameter_events"], "of the node 'beat'"


def test_a_graph_is_known_when_nothing_new_has_come_for_a_second(ros: Any, hand: Any) -> None:
    """What comes up meanwhile begins the second anew."""
    hand.at(0.5, lambda: ros.server("turn"))
    graph_query.query_graph(hand)
    assert 1.5 <= ros.now_s <= 1.6


def test_ctrl_c_ends_looking(ros: Any, hand: Any, type_in: Any) -> None:
    """With the code of an interruption."""
    hand.at(0.5, hand.press_ctrl_c)
    assert type_in("actions", "info", "/turn").code == 130


def test_info_tells_of_fields_and_nodes(graph: Any, type_in: Any) -> None:
    """Types, units, defaults and comments, as the author of the action wrote them."""
    done = type_in("actions", "info", "/turn")
    assert done.lines[:4] == [
        "/turn  bt_mission_interfaces/action/Turn",
        "  Turn on the spot by an angle.",
        "served by  /turn_server",
        "used by    nobody",
    ]
    assert (
        "  angular_velocity  float32  rad/s  = 0  magnitude of the turning speed; 0 takes the "
        "server's default" in done.lines
    )
    assert "  current_angle    float32  deg    angle turned so far; left positive" in done.lines
    assert "    BLOCKED      906  uint16  an obstacle, or something unseen, is in the way" in (
        done.lines
    )
    data = json.loads(type_in("actions", "info", "/turn", "--json").out)
    assert data["goal"][0] == {
        "name": "angle",
        "type": "float32",
        "unit": "deg",
        "default": 0.0,
        "text": "how far to turn; left (anticlockwise) is positive, no wrapping",
    }
    assert data["constants"]["result"]["BLOCKED"] == "906"


def test_info_unfolds_messages_within_messages(ros: Any, type_in: Any) -> None:
    """Indented; a point's coordinates have its unit."""
    ros.server("back", "nav2_msgs/action/BackUp")
    done = type_in("actions", "info", "/back")
    cells = [line.split() for line in done.lines]
    assert ["target", "geometry_msgs/Point", "m", "x:"] in [row[:4] for row in cells]
    assert cells.count(["x", "float64", "m", "=", "0"]) == 1


def test_several_types_under_one_name_ask_for_one(
    type_in: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rather than take the first; DDS lets two processes have them."""
    types = ["std_msgs/msg/Bool", "std_msgs/msg/String"]
    monkeypatch.setitem(graph_query._LOOK_UP, "topic", lambda _: [("/mixed", types)])
    done = type_in("topics", "echo", "/mixed", "--once")
    assert done.code == 2
    both = ", ".join(types)
    assert f"/mixed has several types ({both}): choose one with --type" in done.err


# ---- names for shells that complete a word -------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "some"),
    [("actions", ["/robot1/spin", "/turn"]), ("topics", ["/speech"]), ("services", ["/switch"])],
)
def test_names_of_a_kind_are_printed(
    graph: Any, hand: Any, type_in: Any, kind: str, some: list[str]
) -> None:
    """One a line, once nothing new has come for a moment; those that ROS hides are left out."""
    begin_ns = hand.now_ns
    done = type_in("completion", "--names", kind)
    assert hand.now_ns - begin_ns <= (graph_query.LIVE_QUIET_S + 0.2) * 1e9
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
    assert hand.now_ns - begin_ns <= (graph_query.LIVE_LOOK_S + 0.1) * 1e9


def test_a_domain_that_is_none_is_no_error_while_typing(
    monkeypatch: pytest.MonkeyPatch, type_in: Any
) -> None:
    """The command itself will tell."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "abc")
    done = type_in("completion", "--names", "topics")
    assert (done.code, done.out, done.err) == (0, "", "")
