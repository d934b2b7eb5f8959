"""Missions as goals of ``execute_mission``, over real rclpy, and their requirements."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from bt_mission_interfaces.msg import MissionState, Requirements
from bt_mission_interfaces.srv import SetBreakpoint
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from std_srvs.srv import Trigger

from action_servers.core.maneuver import ErrorCode
from bt_mission.base.dds.liveliness import EXECUTIVE_LOST
from bt_mission.base.goal_rate import MOST_LINES
from bt_mission.ros.graph import LATCHED
from bt_mission.sessions.mission_server import VIOLATED
from bt_mission.sessions.served_missions import ServedMissions
from tests.support.mission_goals import Sent
from tests.support.project import ROOT

TURN = "mission: m\ninputs: {angle: 90}\ntree:\n  turn: {angle: $angle}\n  timeout: 60\n"


@pytest.fixture
def send(ros: Any) -> Any:
    """Send a mission to the executive."""
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    return lambda **fields: Sent(ros, client, **fields)


@pytest.fixture
def turning(ros: Any, send: Any) -> Any:
    """Serve a mission until its server has the goal; gives that server and the mission."""

    def start(habits: dict[str, Any] | None = None, **options: Any) -> tuple[Any, Sent]:
        ros.serve(**options)
        turn = ros.server(**habits or {})
        mission = send(text=TURN)
        ros.until(lambda: turn.goals)
        return turn, mission

    return start


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


def test_a_mission_that_fails_says_where(turning: Any) -> None:
    """As its goal's own result has it."""
    turn, mission = turning()
    turn.goal.abort(error_code=906, error_msg="a wall")
    status, result = mission.end()
    assert (status, result.status, result.error_code) == ("aborted", "failure", 910)
    assert result.error_msg == "'turn' aborted: /turn: a wall (code 906)"


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ({"text": "mission: m\ntree:\n  trun: {}\n"}, "<text>:3:3: error: unknown node type"),
        ({"path": "patrol"}, "no folder of missions is served; start `serve` with --missions DIR"),
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


def test_a_cancel_ends_every_goal_first(ros: Any, turning: Any) -> None:
    """The server takes its time to stop; the mission is canceled only then."""
    turn, mission = turning({"cancels": None})
    mission.cancel()
    ros.until(lambda: turn.goal.cancels)
    turn.goal.answer_cancel()
    ros.run(1.0)
    assert not mission.is_done
    turn.goal.cancel()
    status, result = mission.end()
    assert (status, result.status, result.error_code) == ("canceled", "interrupted", 901)
    assert (result.error_msg, result.goals_left_behind) == ("canceled", 0)


def test_a_newer_mission_replaces_the_one_that_runs(ros: Any, send: Any, turning: Any) -> None:
    """It waits until the goals of the older have ended; one that waits is replaced as well."""
    turn, first = turning({"cancels": None})
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


@pytest.mark.parametrize(
    "goal",
    [{"path": "nonsense"}, {"text": "mission: m\ntree:\n  trun: {}\n"}, {"text": TURN, "seed": -2}],
)
def test_what_cannot_run_replaces_nothing(
    ros: Any, send: Any, turning: Any, goal: dict[str, Any]
) -> None:
    """Neither the mission that runs nor the one that waits; those end as if it had never come."""
    turn, first = turning({"cancels": None})
    assert send(**goal).end()[1].error_code == 909
    assert turn.goal.cancels == 0
    second = send(text=TURN, inputs=["angle=2"])
    assert send(**goal).end()[1].error_code == 909
    assert (first.is_done, second.is_done) == (False, False)
    turn.goal.answer_cancel()
    turn.goal.cancel()
    assert first.end()[1].error_msg == "replaced by a newer mission"
    ros.until(lambda: len(turn.goals) == 2)
    turn.goal.succeed()
    assert second.end()[0] == "succeeded"


def test_a_behaviour_that_cannot_be_made_replaces_nothing(
    ros: Any, send: Any, turning: Any, tmp_path: Any
) -> None:
    """Its constructor raises before the mission that runs is asked to end."""
    (tmp_path / "mine.py").write_text(
        "import py_trees\nclass Mine(py_trees.behaviour.Behaviour):\n"
        "    def __init__(self, name):\n        raise ZeroDivisionError('oh')\n"
        "    def update(self): ...\n"
    )
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ntree:\n  python: mine.py:Mine\n")
    ros.serve(ServedMissions((tmp_path,), allow_python=True, allow_text=True))
    turn, first = turning({"cancels": None})
    result = send(path=str(path)).end()[1]
    assert result.error_code == 909
    assert "ZeroDivisionError: oh (mine.py:4)" in result.error_msg
    assert (turn.goal.cancels, first.is_done) == (0, False)


def test_a_mission_that_waits_is_as_it_was_sent(ros: Any, turning: Any, tmp_path: Any) -> None:
    """Its file may change in the meantime."""
    turn, first = turning({"cancels": None}, missions=ServedMissions((tmp_path,), allow_text=True))
    (tmp_path / "later.yaml").write_text(TURN.replace("90", "2"))
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    second = Sent(ros, client, path="later")
    (tmp_path / "later.yaml").write_text("mission: broken\n")
    turn.goal.answer_cancel()
    turn.goal.cancel()
    assert first.end()[0] == "aborted"
    ros.until(lambda: len(turn.goals) == 2)
    assert turn.goal.request.angle == 2.0
    turn.goal.succeed()
    assert second.end()[0] == "succeeded"


def test_a_mission_that_waits_can_be_cancelled(send: Any, turning: Any) -> None:
    """The one that runs has been told to end all the same."""
    turn, first = turning({"cancels": None})
    second = send(text=TURN)
    second.cancel()
    assert second.end()[0] == "canceled"
    turn.goal.answer_cancel()
    turn.goal.cancel()
    assert first.end()[0] == "aborted"
    assert len(turn.goals) == 1


def test_by_parameter_a_newer_mission_is_refused(ros: Any, send: Any, turning: Any) -> None:
    """Rejected while one runs, welcome afterwards."""
    turn, first = turning(on_new_goal="refuse")
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


def test_closing_ends_the_mission_and_refuses_others(ros: Any, send: Any, turning: Any) -> None:
    """As Ctrl-C does."""
    _, mission = turning()
    ros.served.close("interrupted by Ctrl-C")
    status, result = mission.end()
    assert (status, result.error_msg) == ("aborted", "interrupted by Ctrl-C")
    ros.until(lambda: not ros.served.is_busy)
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


def test_of_many_refused_missions_some_are_told(ros: Any) -> None:
    """Each is answered."""
    ros.serve().close("closed")
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    asked = [client.send_goal_async(ExecuteMission.Goal()) for _ in range(300)]
    ros.until(lambda: all(answer.done() for answer in asked))
    assert not any(answer.result().accepted for answer in asked)
    assert 0 < ros.logged.count("mission refused: closed") <= MOST_LINES


@pytest.mark.parametrize("allowed", [False, True])
def test_where_two_robots_are_one_a_mission_needs_leave(
    ros: Any, send: Any, *, allowed: bool
) -> None:
    """Such as a simulation beside a robot; somebody may have a reason."""
    for name in ("robot", "simulation"):
        ros.node(name).create_publisher(Odometry, "odom", 10)
    ros.serve(allow_duplicates=allowed)
    status, result = send(text="mission: m\ntree: {log: hello}\n").end()
    assert (status, result.error_code) == (("succeeded", 0) if allowed else ("aborted", 909))
    publishers = "/odom has 2 publishers (/robot, /simulation): "
    assert result.error_msg.startswith(publishers) is not allowed


# ---- requirements ----------------------------------------------------------------------------


JUDGED = """\
mission: m
requirements:
  is quick: always time < 1.22
  ends: eventually succeeded("later")
tree:
  wait: {}
  name: later
"""


def test_a_violated_requirement_aborts_the_goal(ros: Any, send: Any) -> None:
    """As it gives `run` the exit code 1; the summary has every verdict."""
    ros.serve()
    status, result = send(text=JUDGED.format(2)).end()
    assert (status, result.status, result.error_code) == ("aborted", "success", VIOLATED)
    # what decides is the last instant
    assert result.error_msg.startswith("requirement is quick: violated by 0.78 s at 2.00 s")
    *_, quick, ends = result.summary.splitlines()
    assert quick == f"  {result.error_msg}"
    assert ends.startswith("  requirement ends: holds")


def test_requirements_that_hold_are_in_the_summary(ros: Any, send: Any) -> None:
    """Its goal succeeds."""
    ros.serve()
    status, result = send(text=JUDGED.format(1)).end()
    assert (status, result.error_code, result.error_msg) == ("succeeded", 0, "")
    assert "requirement is quick: holds by 0.22 s" in result.summary


def test_the_requirements_of_the_next_mission_replace_those_of_the_last(
    ros: Any, send: Any
) -> None:
    """On the topic for tools, also where it has none."""
    reports: list[list[str]] = []
    ros.serve()
    ros.client.create_subscription(
        Requirements,
        "/bt_mission/requirements",
        lambda message: reports.append([requirement.name for requirement in message.requirements]),
        LATCHED,
    )
    send(text=JUDGED.format(1)).end()
    send(text="mission: m\ntree: {wait: 1}\n").end()
    assert reports[0] == ["is quick", "ends"]
    assert reports[-1] == []


def test_the_code_of_a_violation_is_that_of_the_definition() -> None:
    """Constants are no part of a type, so interfaces without it have the same hash."""
    text = (ROOT / "interfaces/bt_mission_interfaces/action/ExecuteMission.action").read_text()
    assert f"uint16 VIOLATED={VIOLATED} " in text
    assert VIOLATED not in (EXECUTIVE_LOST, *ErrorCode)


MEASURED = """\
mission: m
requirements:
  starts once: always count(starts(running("later"))) <= 1
  goes evenly: always abs(rate(time) - 1) < 0.5
  is late: eventually mean(time) over 0.5 s > 0.9
  takes its time: >-
    whenever ends(running("later")):
    time - value(time) at last starts(running("later")) > 1
observe: 1
tree:
  sequence:
    - wait: 0.3
    - {wait: 1.2, name: later}
"""


def test_counts_means_and_rates_need_no_simulation(ros: Any, send: Any) -> None:
    """A served mission is judged by what its executive knows, also in an observation."""
    ros.serve()
    status, result = send(text=MEASURED).end()
    assert (status, result.status, result.error_code) == ("succeeded", "success", 0)
    assert [line.strip() for line in result.summary.splitlines() if "requirement" in line] == [
        "requirement starts once: holds by 0 at 0.30 s",
        "requirement goes evenly: holds by 0.5 at 2.10 s",
        "requirement is late: holds by 1.35 s at 2.50 s",
        "requirement takes its time: holds by 0.2 s at 1.50 s",
    ]
