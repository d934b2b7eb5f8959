"""Missions as goals of ``execute_mission``, over real rclpy."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from bt_mission_interfaces.msg import MissionState
from bt_mission_interfaces.srv import SetBreakpoint
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from std_srvs.srv import Trigger

from bt_mission.core.goal_rate import MOST_LINES
from bt_mission.ros.graph import LATCHED
from bt_mission.sessions.served_missions import ServedMissions
from tests.support.mission_goals import Sent

TURN = "mission: m\ninputs: {angle: 90}\ntree:\n  turn: {angle: $angle}\n  timeout: 60\n"


@pytest.fixture
def send(ros: Any) -> Any:
    """Send a mission to the executive."""
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    return lambda **fields: Sent(ros, client, **fields)


def test_a_mission_runs_and_its_result_tells(ros: Any, send: Any) -> None:
    """Inputs and seed come with the goal; the summary is what `run` would print."""
    ros.serve()
    turn = ros.server()
    mission = send(text=TURN, inputs=["angle=45"], seed=7)
    ros.until(lambda: turn.goals)
    ros.run(1.5)
    turn.goal.feed(current_angle=10.0)
    ros.run(1.0)
    turn.goal.succeed()
    status, result = mission.end()
    assert turn.goal.request.angle == 45.0
    assert (status, result.status, result.error_code, result.error_msg) == (
        "succeeded",
        "success",
        0,
        "",
    )
    assert (result.goals_sent, result.goals_left_behind) == (1, 0)
    assert result.duration == pytest.approx(2.5, abs=0.11)
    assert result.summary.startswith("m: success\n")
    first = mission.feedback[0]
    assert (first.status, first.tip, list(first.running)) == ("running", "turn", ["turn"])
    assert [feedback.doing[0] for feedback in mission.feedback if feedback.doing][-1].startswith(
        "current_angle 10.00"
    )


def test_a_paused_mission_keeps_the_limits_of_its_goals(ros: Any, send: Any) -> None:
    """A step has sent the goal; feedback tells what it does, and its timeout cancels it."""
    ros.serve()
    turn = ros.server()
    ros.call(SetBreakpoint, "/bt_mission/breakpoint", node="turn")
    mission = send(text=TURN.replace("timeout: 60", "timeout: 5"))
    ros.until(lambda: mission.feedback and mission.feedback[-1].status == "paused")
    ros.call(Trigger, "/bt_mission/step")
    ros.until(lambda: turn.goals)
    turn.goal.feed(current_angle=10.0)
    ros.run(4.5)
    assert mission.feedback[-1].doing[0].startswith("current_angle 10.00")
    assert turn.goal.cancels == 0
    ros.run(2.0)
    assert (mission.feedback[-1].status, turn.goal.cancels) == ("paused", 1)
    ros.call(Trigger, "/bt_mission/resume")
    _, result = mission.end()
    assert result.error_msg == "'turn' canceled by timeout: not done within 5 s"


def test_a_mission_that_fails_says_where(ros: Any, send: Any) -> None:
    """As its goal's own result has it."""
    ros.serve()
    turn = ros.server()
    mission = send(text=TURN)
    ros.until(lambda: turn.goals)
    turn.goal.abort(error_code=906, error_msg="a wall")
    status, result = mission.end()
    assert (status, result.status, result.error_code) == ("aborted", "failure", 910)
    assert result.error_msg == "'turn' aborted: /turn: a wall (code 906)"


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (
            {"text": "mission: m\ntree:\n  trun: {}\n"},
            "<text>:3:3: error: unknown node type",
        ),
        ({"path": "no_such_mission"}, "no folder of missions is served"),
        ({}, "expected either a path or a text"),
        ({"text": TURN, "path": "explore"}, "expected either a path or a text"),
        ({"text": TURN, "seed": -2}, "seed: expected an integer from 0"),
        ({"text": TURN, "inputs": ["angle"]}, "inputs: expected NAME=VALUE, got 'angle'"),
        ({"text": TURN, "inputs": ["angel=3"]}, "unknown input 'angel'"),
    ],
)
def test_what_is_not_sound_never_starts(ros: Any, send: Any, goal: Any, words: str) -> None:
    """Aborted, not rejected: a rejection carries no words in ROS."""
    ros.serve()
    status, result = send(**goal).end()
    assert (status, result.status, result.error_code) == ("aborted", "", 909)
    assert words in result.error_msg
    assert "\n" not in result.error_msg  # a leaf, a log and a table have one line for it


def test_a_behaviour_that_cannot_be_made_ends_no_server(ros: Any, send: Any, tmp_path: Any) -> None:
    """A user's class raises in its constructor."""
    ros.serve(ServedMissions((tmp_path,), allow_python=True, allow_text=True))
    (tmp_path / "mine.py").write_text(
        "import py_trees\nclass Mine(py_trees.behaviour.Behaviour):\n"
        "    def __init__(self, name):\n        raise ZeroDivisionError('oh')\n"
        "    def update(self): ...\n"
    )
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ntree:\n  python: mine.py:Mine\n")
    status, result = send(path=str(path)).end()
    assert (status, result.error_code in (900, 909)) == ("aborted", True)
    assert "ZeroDivisionError" in result.error_msg
    ros.server()
    assert send(text=TURN).accepted


def test_a_file_outside_is_neither_read_nor_run(ros: Any, send: Any, tmp_path: Any) -> None:
    """A client learns nothing of it, and nothing is imported."""
    outside, inside = tmp_path / "outside", tmp_path / "inside"
    outside.mkdir()
    inside.mkdir()
    (outside / "token.yaml").write_text("token: swordfish\n")
    (outside / "leaf.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()\n")
    (outside / "m.yaml").write_text("mission: m\ntree: {python: 'leaf.py:X'}\n")
    ros.serve(ServedMissions((inside,)))
    for name in ("token", "m"):
        status, result = send(path=str(outside / f"{name}.yaml")).end()
        assert (status, result.error_code) == ("aborted", 909)
        assert "no such mission in the folders that are served" in result.error_msg
        assert "swordfish" not in result.error_msg
    assert not (tmp_path / "ran").exists()


def test_by_default_nothing_is_offered(ros: Any, send: Any) -> None:
    """The reason names the options that open it."""
    ros.serve(ServedMissions())
    assert "--missions DIR" in send(path="patrol").end()[1].error_msg
    assert "--allow-text" in send(text=TURN).end()[1].error_msg


def test_a_cancel_ends_every_goal_first(ros: Any, send: Any) -> None:
    """The server takes its time to stop; the mission is canceled only then."""
    ros.serve()
    turn = ros.server(cancels=None)
    mission = send(text=TURN)
    ros.until(lambda: turn.goals)
    mission.cancel()
    ros.until(lambda: turn.goal.cancels)
    turn.goal.answer_cancel()
    ros.run(1.0)
    assert not mission.is_done
    turn.goal.cancel()
    status, result = mission.end()
    assert (status, result.status, result.error_code) == ("canceled", "interrupted", 901)
    assert (result.error_msg, result.goals_left_behind) == ("canceled", 0)


def test_a_newer_mission_replaces_the_one_that_runs(ros: Any, send: Any) -> None:
    """It waits until the goals of the older have ended; one that waits is replaced as well."""
    ros.serve()
    turn = ros.server(cancels=None)
    first = send(text=TURN, inputs=["angle=1"])
    ros.until(lambda: turn.goals)
    second = send(text=TURN, inputs=["angle=2"])
    third = send(text=TURN, inputs=["angle=3"])
    status, result = second.end()
    assert (status, result.error_code) == ("aborted", 901)
    assert result.error_msg == "replaced by a newer mission"
    assert (len(turn.goals), first.is_done) == (1, False)
    turn.goal.answer_cancel()
    turn.goal.cancel()
    status, result = first.end()
    assert (status, result.status) == ("aborted", "interrupted")
    assert result.error_msg == "replaced by a newer mission"
    ros.until(lambda: len(turn.goals) == 2)
    turn.goal.succeed()
    assert third.end()[0] == "succeeded"
    assert turn.goal.request.angle == 3.0


def test_a_mission_that_waits_can_be_cancelled(ros: Any, send: Any) -> None:
    """The one that runs has been told to end all the same."""
    ros.serve()
    turn = ros.server(cancels=None)
    first = send(text=TURN)
    ros.until(lambda: turn.goals)
    second = send(text=TURN)
    second.cancel()
    assert second.end()[0] == "canceled"
    turn.goal.answer_cancel()
    turn.goal.cancel()
    assert first.end()[0] == "aborted"
    assert len(turn.goals) == 1


def test_by_parameter_a_newer_mission_is_refused(ros: Any, send: Any) -> None:
    """Rejected while one runs, welcome afterwards."""
    ros.serve(on_new_goal="refuse")
    turn = ros.server()
    first = send(text=TURN)
    ros.until(lambda: turn.goals)
    assert not send(text=TURN).accepted
    assert ros.logged[-1] == "mission refused: another mission runs (on_new_goal: refuse)"
    turn.goal.succeed()
    assert first.end()[0] == "succeeded"
    assert send(text=TURN).accepted


def test_a_mission_cannot_wait_for_its_own_executive(ros: Any, send: Any) -> None:
    """It would replace itself; the goal is aborted with advice, and the mission goes on."""
    ros.serve()
    mission = send(
        text="mission: m\ntree:\n  fallback:\n"
        "    - execute_mission: {text: 'mission: n'}\n      timeout: 9\n"
        "    - log: went on\n"
    )
    assert mission.end()[0] == "succeeded"
    assert "went on" in ros.logged


def test_closing_ends_the_mission_and_refuses_others(ros: Any, send: Any) -> None:
    """As Ctrl-C does."""
    serve = ros.serve()
    turn = ros.server()
    mission = send(text=TURN)
    ros.until(lambda: turn.goals)
    serve.close("interrupted by Ctrl-C")
    status, result = mission.end()
    assert (status, result.error_msg) == ("aborted", "interrupted by Ctrl-C")
    ros.until(lambda: not serve.is_busy)
    assert not send(text=TURN).accepted


def test_the_state_is_latched_from_the_start(ros: Any, send: Any) -> None:
    """A tool that looks sees idle before the first mission."""
    states: list[str] = []
    ros.client.create_subscription(
        MissionState, "/bt_mission/state", lambda message: states.append(message.status), LATCHED
    )
    ros.serve()
    send(text="mission: m\ntree:\n  wait: 1\n").end()
    ros.run(0.2)
    assert states == ["idle", "running", "success"]


def test_no_mission_starts_where_two_robots_are_one(ros: Any, send: Any) -> None:
    """A simulation beside a robot; with leave it starts all the same."""
    nodes = [ros.node(name) for name in ("robot", "simulation")]
    for node in nodes:
        node.create_publisher(Odometry, "odom", 10)
    ros.serve()
    status, result = send(text=TURN).end()
    assert (status, result.error_code) == ("aborted", 909)
    assert result.error_msg.startswith("/odom has 2 publishers (/robot, /simulation): ")


def test_with_leave_a_mission_starts_all_the_same(ros: Any, send: Any) -> None:
    """For whoever has a reason to."""
    for name in ("robot", "simulation"):
        ros.node(name).create_publisher(Odometry, "odom", 10)
    ros.serve(allow_duplicates=True)
    assert send(text="mission: m\ntree: {log: hello}\n").end()[0] == "succeeded"


def test_of_many_refused_missions_some_are_told(ros: Any) -> None:
    """Each is answered."""
    ros.serve().close("closed")
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    asked = [client.send_goal_async(ExecuteMission.Goal()) for _ in range(300)]
    ros.until(lambda: all(answer.done() for answer in asked))
    assert not any(answer.result().accepted for answer in asked)
    assert 0 < ros.logged.count("mission refused: closed") <= MOST_LINES
