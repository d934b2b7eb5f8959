"""``bt-mission actions send``: each way in which a goal can end has a code and words of its own."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from rcl_interfaces.msg import Log

from bt_mission.commands.graph.form_fields import example
from bt_mission.commands.graph.interface_description import describe_interface
from bt_mission.commands.graph.values import read_fields
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.sessions.scripted_server import ScriptedServer
from tests.support.graph import TURN


def test_a_goal_that_succeeds(ros: Any, hand: Any, type_in: Any) -> None:
    """Feedback with its units, a line per change; then the result, with the names of codes."""
    server = ros.server()

    def work() -> None:
        server.goal.feed(current_angle=10.0, remaining_angle=80.0)
        server.goal.feed(current_angle=10.0, remaining_angle=80.0)
        server.goal.feed(current_angle=20.0, remaining_angle=70.0)

    hand.when(lambda: server.goals, lambda: None)
    hand.at(1.0, work)
    hand.at(2.0, lambda: server.goal.succeed(angle_turned=90.1, error_code=907))
    done = type_in("actions", "send", "/turn", "angle: 90")
    assert (done.code, done.err) == (0, "")
    assert done.lines[0] == f"goal {server.goal.id.hex()[:8]} accepted"
    assert [line.partition(" s  ")[2] for line in done.lines[1:3]] == [
        "current_angle 10 deg, remaining_angle 80 deg",
        "current_angle 20 deg, remaining_angle 70 deg",
    ]
    assert done.lines[3].startswith("succeeded after ")
    assert done.lines[4:] == [
        "  angle_turned  90.1 deg",
        "  error_code    907  (MOTORS_OFF)",
        "  error_msg     ''",
    ]
    assert server.goal.request.angle == 90.0


@pytest.mark.parametrize(
    ("accepts", "move", "options", "code", "line"),
    [
        (True, "abort", (), 1, "/turn aborted the goal after"),
        (False, "", (), 3, "/turn rejected the goal; its server gave no reason"),
        (True, "cancel", (), 4, "canceled: by another client after"),
        (True, "", ("--timeout", "2"), 4, "canceling: not done within 2 s"),
    ],
    ids=["aborted", "rejected", "cancelled by somebody else", "not done in time"],
)
def test_each_end_has_its_code(
    ros: Any, hand: Any, type_in: Any, accepts: Any, move: str, options: Any, code: int, line: str
) -> None:
    """And a line that says what has happened; the result says why."""
    server = ros.server(accepts=accepts)
    if move:
        hand.when(lambda: server.goals, lambda: getattr(server.goal, move)(error_msg="no scan"))
    done = type_in("actions", "send", "/turn", "{}", *options)
    assert done.code == code
    assert any(shown.startswith(line) for shown in done.lines), done.out
    assert ("  error_msg     no scan" in done.lines) is bool(move)
    assert server.goal.cancels == len(options) // 2


def test_a_rejection_is_explained_by_the_log_of_the_server(
    ros: Any, hand: Any, type_in: Any
) -> None:
    """The answer of an action has no words; the newest warning of a node that serves it has."""
    server = ros.server(accepts=None)
    publisher = ros.client.create_publisher(Log, "/rosout", 10)

    def reject() -> None:
        for level, name, text in (
            (Log.WARN, "other", "not mine"),
            (Log.INFO, "turn_server.turn", "only news"),
            (Log.WARN, "turn_server.turn", "angle: too\x1b[31m large"),
        ):
            publisher.publish(Log(level=level, name=name, msg=text))
        server.goal.reject()

    hand.when(lambda: server.goals, reject)
    done = type_in("actions", "send", "/turn", "{}")
    assert done.lines == ["/turn rejected the goal; its log says: angle: too\\x1b[31m large"]


def test_ctrl_c_cancels_and_waits_for_the_end(ros: Any, hand: Any, type_in: Any) -> None:
    """The result of a cancelled goal is shown; the code is that of the goal, not of Ctrl-C."""
    server = ros.server(cancels=None)
    hand.at(1.0, hand.press_ctrl_c)
    hand.at(2.0, lambda: server.goal.answer_cancel(0))
    hand.at(3.0, lambda: server.goal.cancel(angle_turned=12.0))
    done = type_in("actions", "send", "/turn", "angle: 90")
    assert done.code == 4
    assert done.lines[1] == "canceling: interrupted by Ctrl-C"
    assert done.lines[2].startswith("canceled: interrupted by Ctrl-C after 3.00 s")
    assert done.lines[3] == "  angle_turned  12 deg"
    assert server.goal.cancels == 2  # asked again after a second without an answer


def test_a_second_ctrl_c_leaves_and_names_the_goal(ros: Any, hand: Any, type_in: Any) -> None:
    """At once, whatever becomes of it."""
    server = ros.server(cancels=None)
    hand.at(1.0, hand.press_ctrl_c)
    hand.at(2.0, hand.press_ctrl_c)
    done = type_in("actions", "send", "/turn", "{}")
    short = server.goal.id.hex()[:8]
    assert done.code == 130
    assert done.lines[-1] == (
        f"ended at once by a second Ctrl-C; orphaned goal: /turn goal {short} of 'you' (canceling)"
    )


def test_a_server_that_dies_is_lost(ros: Any, hand: Any, type_in: Any) -> None:
    """The goal is named, since nobody knows what became of it."""
    node = ros.node("mortal")
    server = ScriptedServer(node, TURN, "turn")
    hand.when(lambda: server.goals, lambda: None)
    hand.at(2.0, lambda: ros.drop(node))
    done = type_in("actions", "send", "/turn", "{}")
    short = server.goal.id.hex()[:8]
    assert done.code == 6
    assert done.lines[-1] == (
        f"/turn has gone from the graph; orphaned goal: /turn goal {short} of 'you' (active)"
    )


def test_without_a_server_it_says_what_it_looked_for(ros: Any, type_in: Any) -> None:
    """And what there is instead, with the nearest name."""
    ros.server("spin", "nav2_msgs/action/Spin")
    ros.server("turn")
    done = type_in("actions", "send", "/tur", "--wait", "2")
    assert (done.code, done.out) == (5, "")
    assert done.err == (
        "no action /tur in the graph (looked for 2 s); there are: /spin, /turn; "
        "did you mean '/turn'? [BT-901]\n"
    )
    given = type_in("actions", "send", "/tur", "{}", "--type", TURN, "--wait", "2")
    assert (given.code, given.lines) == (
        5,
        ["waiting for a server of /tur", "no server of /tur after 2 s"],
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["/turn", "angel: 90"], ["goal:1:1: error: no field 'angel'", "did you mean 'angle'?"]),
        (["/turn", "angle: fast"], ["goal:1:8: error: expected a number (float32), got string"]),
        (["/turn", "{angle: 9"], ["goal:1:1: error: this '{' has no closing"]),
        (["/turn", "90"], ["goal:1:1: error: expected fields of the goal of bt_mission_interf"]),
        (["/turn", "--type", "a/action/B"], ["the action type a/action/B is not installed"]),
        (
            ["/turn", "{}", "--type", "nav2_msgs/action/Spin"],
            ["/turn is a bt_mission_interfaces/act"],
        ),
        (["/t urn"], ["expected the name of an action", "must not contain characters"]),
        (["a//b"], ["expected the name of an action", "repeated"]),
    ],
)
def test_bad_input_exits_with_2_and_sends_nothing(
    ros: Any, type_in: Any, arguments: list[str], words: list[str]
) -> None:
    """Each fault with its place and what to do."""
    server = ros.server()
    done = type_in("actions", "send", *arguments)
    assert (done.code, done.out) == (2, "")
    assert all(word in done.err for word in words), done.err
    assert server.goals == []


@pytest.mark.parametrize("arguments", [[], ["-"]])
def test_without_a_goal_nothing_is_sent(
    ros: Any, type_in: Any, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    """It shows the fields, and a command to be changed, which is valid as it stands."""
    monkeypatch.setattr("sys.stdin", io.StringIO(" \n"))
    server = ros.server()
    done = type_in("actions", "send", "/turn", *arguments)
    assert (done.code, done.out, server.goals) == (2, "", [])
    first, *fields, such, others = done.err.splitlines()
    assert first == "no goal was given; the fields of a goal of /turn:"
    assert [line.split()[:3] for line in fields] == [
        ["angle", "deg", "float32"],
        ["angular_velocity", "rad/s", "float32"],
    ]
    assert such == (
        "give the fields needed, such as: "
        "bt-mission actions send /turn '{angle: 0.0, angular_velocity: 0.0}'"
    )
    assert others.startswith("'{}' sends a goal with all defaults")


def test_the_example_of_a_pose_is_its_short_form(ros: Any, type_in: Any) -> None:
    """Also in a list; what is shown can be read."""
    ros.server("navigate_to_pose", "nav2_msgs/action/NavigateToPose")
    done = type_in("actions", "send", "/navigate_to_pose")
    assert "'{pose: [1.0, 0.5, 0.0], behavior_tree: BEHAVIOR_TREE}'" in done.err
    for name in ("navigate_to_pose", "follow_waypoints", "back_up", "execute_mission"):
        part = describe_interface(ACTION_NAMES[name].type).part("goal")
        assert set(read_fields(example(part), part.shape, "goal")) == set(part.shape.fields)


def test_programs_read_an_object_a_line(ros: Any, hand: Any, type_in: Any) -> None:
    """Every feedback, and the whole result."""
    server = ros.server("fibonacci", "example_interfaces/action/Fibonacci")
    hand.when(lambda: server.goals, lambda: None)
    hand.at(1.0, lambda: server.goal.feed(sequence=[0, 1]))
    hand.at(1.5, lambda: server.goal.succeed(sequence=list(range(100))))
    done = type_in("actions", "send", "/fibonacci", "order: 3", "--json")
    objects = [json.loads(line) for line in done.lines]
    assert done.code == 0
    assert [event["event"] for event in objects] == ["accepted", "feedback", "ended"]
    assert {item["goal"] for item in objects} == {server.goal.id.hex()}
    assert objects[1]["feedback"] == {"sequence": [0, 1]}
    assert (objects[2]["status"], len(objects[2]["result"]["sequence"])) == ("succeeded", 100)


def test_a_goal_can_come_from_standard_input(
    ros: Any, hand: Any, type_in: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A dash stands for it."""
    monkeypatch.setattr("sys.stdin", io.StringIO("angle: 45\nangular_velocity: 1\n"))
    server = ros.server()
    hand.when(lambda: server.goals, lambda: server.goal.succeed(angle_turned=45.0))
    assert type_in("actions", "send", "turn", "-").code == 0
    assert (server.goal.request.angle, server.goal.request.angular_velocity) == (45.0, 1.0)
