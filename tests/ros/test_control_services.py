"""Services that hold a mission, and topics that tell of it, over real rclpy."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from bt_mission_interfaces.msg import MissionState, StatusChanges, Tree
from bt_mission_interfaces.srv import GetStatuses, PauseMission, SetBreakpoint
from std_srvs.srv import Trigger
from unique_identifier_msgs.msg import UUID

from bt_mission.executive.controls import MOST_BREAKPOINTS
from bt_mission.ros.graph import LATCHED
from bt_mission.ros.status_publisher import CHANGES

TWO = "mission: m\ntree:\n  sequence:\n    - turn: {angle: 90}\n      timeout: 60\n    - wait: 1\n"


@pytest.fixture
def received(ros: Any) -> dict[str, list[Any]]:
    """What the topics carry."""
    received: dict[str, list[Any]] = {"tree": [], "changes": [], "state": []}
    for name, kind, qos in (
        ("tree", Tree, LATCHED),
        ("changes", StatusChanges, CHANGES),
        ("state", MissionState, LATCHED),
    ):
        ros.client.create_subscription(kind, f"/bt_mission/{name}", received[name].append, qos)
    return received


def trigger(ros: Any, name: str) -> tuple[bool, str]:
    """Call one of the services that ask for nothing more."""
    answer = ros.call(Trigger, f"/bt_mission/{name}")
    return answer.success, answer.message


def test_paused_goals_are_cancelled_and_start_anew(ros: Any) -> None:
    """The default; nothing else happens until the mission is resumed."""
    turn, node = ros.turning(TWO, has_controls=True)
    answer = ros.call(PauseMission, "/bt_mission/pause")
    assert (answer.success, answer.message) == (True, "paused")
    ros.run(10.0)
    assert (len(turn.goals), turn.goal.cancels) == (1, 1)
    assert (node.executive.mission_state.status, node.ledger.open_goals) == ("paused", ())
    assert trigger(ros, "resume") == (True, "resumed")
    ros.until(lambda: len(turn.goals) == 2)
    turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.mission_state.status == "success"


def test_paused_goals_may_be_kept(ros: Any) -> None:
    """They run on; what they came to is seen after the pause."""
    turn, node = ros.turning(TWO, has_controls=True)
    answer = ros.call(PauseMission, "/bt_mission/pause", keep_goals=True)
    assert answer.message == "paused; still running: 'turn'"
    turn.goal.succeed()
    ros.run(100.0)
    assert node.executive.root.status.name == "RUNNING"
    trigger(ros, "resume")
    took = ros.until(lambda: node.executive.is_done) - 100
    assert (node.executive.mission_state.status, turn.goal.cancels) == ("success", 0)
    assert took == pytest.approx(1.1, abs=0.2)


def test_a_kept_goal_keeps_its_limits(ros: Any, received: dict[str, list[Any]]) -> None:
    """The timeout of 60 s cancels it in the pause, and the state tells what is under way."""
    turn, _ = ros.turning(TWO, has_controls=True, cancels=None)
    ros.call(PauseMission, "/bt_mission/pause", keep_goals=True)
    ros.run(59.0)
    assert turn.goal.cancels == 0
    ros.run(1.0)
    assert turn.goal.cancels == 1
    turn.goal.answer_cancel()
    turn.goal.cancel()
    ros.run(100.0)
    assert [(state.status, state.reason) for state in received["state"]] == [
        ("running", ""),
        ("paused", "paused on request; still running: 'turn'"),
        ("paused", "paused on request; still running: 'turn' (canceling)"),
        ("paused", "paused on request"),
    ]


def test_steps_are_single_ticks(ros: Any) -> None:
    """One for each call, only while paused."""
    node = ros.mission("mission: m\ntree:\n  wait: 60\n", has_controls=True)
    ros.run(1.0)
    assert trigger(ros, "step") == (False, "the mission is not paused; pause it first")
    ros.call(PauseMission, "/bt_mission/pause")
    ticks = node.executive.ticks
    for _ in range(3):
        assert trigger(ros, "step") == (True, "stepped one tick")
        ros.run(1.0)
    assert node.executive.ticks == ticks + 3


def test_a_breakpoint_pauses_before_its_node_starts(ros: Any) -> None:
    """Not one message goes to the server; the state says where the mission stands."""
    turn = ros.server()
    node = ros.mission(TWO, has_controls=True)
    answer = ros.call(SetBreakpoint, "/bt_mission/breakpoint", node="turn")
    assert (answer.success, list(answer.breakpoints)) == (True, ["turn"])
    ros.run(5.0)
    assert (node.executive.reason, turn.goals) == ("breakpoint at 'turn'", [])
    trigger(ros, "resume")
    ros.until(lambda: turn.goals)
    turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.mission_state.status == "success"


def test_breakpoints_are_listed_and_removed(ros: Any) -> None:
    """A name that is none is told, with the nearest."""
    ros.mission(TWO, has_controls=True)

    def ask(**fields: Any) -> tuple[bool, str, list[str]]:
        answer = ros.call(SetBreakpoint, "/bt_mission/breakpoint", **fields)
        return answer.success, answer.message, list(answer.breakpoints)

    assert ask(node="wiat") == (False, "unknown node 'wiat'; did you mean 'wait'?", [])
    assert ask(node="0.1") == (True, "pauses before '0.1'", ["0.1"])
    assert ask() == (True, "1 set", ["0.1"])
    assert ask(node="wait", remove=True) == (False, "no breakpoint on 'wait'", ["0.1"])
    assert ask(node="0.1", remove=True) == (True, "'0.1' no longer pauses", [])


def test_breakpoints_do_not_grow_without_end(ros: Any) -> None:
    """Each request is answered, also while no mission shows that a name is wrong."""
    ros.serve()
    client = ros.client.create_client(SetBreakpoint, "/bt_mission/breakpoint")

    def ask(*nodes: str) -> list[Any]:
        asked = [client.call_async(SetBreakpoint.Request(node=node)) for node in nodes]
        ros.until(lambda: all(answer.done() for answer in asked))
        return [answer.result() for answer in asked]

    reports = ask(*(f"n{i}" for i in range(300)))
    assert [report.success for report in reports] == [i < MOST_BREAKPOINTS for i in range(300)]
    assert reports[-1].message == "100 breakpoints are set; remove one first"
    assert max(len(report.breakpoints) for report in reports) == MOST_BREAKPOINTS
    known, long = ask("n7", "x" * 5000)
    assert (known.success, known.message) == (True, "pauses before 'n7'")
    assert (long.success, long.message) == (False, "no node has a name of 5,000 characters")


def test_a_stopped_mission_ends_its_goals(ros: Any) -> None:
    """Also one that is paused at a breakpoint; afterwards there is nothing to hold."""
    turn, node = ros.turning(TWO, has_controls=True)
    assert trigger(ros, "stop")[0]
    ros.until(lambda: node.executive.is_done)
    assert (node.executive.mission_state.status, turn.goal.cancels) == ("interrupted", 1)
    for name in ("stop", "resume", "step"):
        assert trigger(ros, name) == (False, "no mission is running")
    assert not ros.call(PauseMission, "/bt_mission/pause").success


def test_changes_make_up_the_statuses(ros: Any, received: dict[str, list[Any]]) -> None:
    """A tool that applies each change to the tree has what the service gives."""
    turn, node = ros.turning(TWO, has_controls=True)
    turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    (tree,) = received["tree"]
    assert [(info.name, info.kind, info.path, info.parent) for info in tree.nodes] == [
        ("m", "Sequence", "0", 0),
        ("turn", "ActionLeaf", "0.0", 0),
        ("wait", "Wait", "0.1", 0),
    ]
    assert [item.sequence for item in received["changes"]] == list(
        range(1, len(received["changes"]) + 1)
    )
    statuses = dict.fromkeys(range(3), (0, ""))
    for message in received["changes"]:
        assert message.run == tree.run
        statuses |= {change.node: (change.status, change.message) for change in message.changes}
    answer = ros.call(GetStatuses, "/bt_mission/statuses")
    assert (answer.run, answer.sequence) == (tree.run, len(received["changes"]))
    assert {status.node: (status.status, status.message) for status in answer.statuses} == statuses
    assert [state.status for state in received["state"]] == ["running", "success"]


def test_nothing_is_said_while_nothing_changes(ros: Any, received: dict[str, list[Any]]) -> None:
    """A mission that waits for an hour is silent for an hour."""
    ros.mission("mission: m\ntree:\n  wait: 7200\n", has_controls=True)
    ros.run(1.0)
    before = {name: len(messages) for name, messages in received.items()}
    assert before == {"tree": 1, "changes": 1, "state": 1}
    ros.run(60.0)
    assert {name: len(messages) for name, messages in received.items()} == before


@pytest.mark.parametrize("name", ["stop", "step", "resume"])
def test_each_of_many_calls_is_answered(ros: Any, name: str) -> None:
    """Without a mission, with the reason why not."""
    ros.serve()
    client = ros.client.create_client(Trigger, f"/bt_mission/{name}")
    asked = [client.call_async(Trigger.Request()) for _ in range(300)]
    ros.until(lambda: all(answer.done() for answer in asked))
    assert {answer.result().message for answer in asked} == {"no mission is running"}


def test_answers_to_other_clients_push_out_none_of_ours(ros: Any) -> None:
    """DDS brings each answer of a server to all of its clients."""
    turn, node = ros.turning(TWO)
    service = Turn.Impl.GetResultService
    client = ros.client.create_client(service, "turn/_action/get_result")
    request = service.Request(goal_id=UUID(uuid=list(node.ledger.open_goals[0].id)))
    for _ in range(30):
        client.call_async(request)
        ros.clock.run_until_quiet()
    turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    assert node.executive.mission_state.status == "success"
