"""The executive ends a mission with every goal accounted for, whatever happens."""

from __future__ import annotations

from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.executive.events.events import Event, GoalChanged, NodeChanged

TURN = "  turn: {angle: 90}\n  timeout: 9"
TWO_TURNS = """\
  parallel:
    - turn: {angle: 90}
      timeout: 9
    - action: {name: /other, type: bt_mission_interfaces/action/Turn, goal: {angle: 90}}
      timeout: 9
"""


def test_success_leaves_nothing_behind(play: Any) -> None:
    """A mission that succeeds has sent one goal and left none."""
    run = play(TURN)
    run.tick()
    run.turn.accept()
    run.turn.succeed("done")
    run.tick()
    executive = run.executive
    assert (run.status, executive.reason) == ("success", "")
    assert (executive.goals_sent, executive.goals_left_behind) == (1, ())


def test_failure_names_the_leaf_and_why(play: Any) -> None:
    """The reason is the failing leaf's own."""
    run = play(
        f"  sequence:\n    - {{log: hello}}\n    - {TURN.strip()}".replace(
            "\n  timeout", "\n      timeout"
        )
    )
    run.tick()
    run.turn.reject()
    run.tick()
    assert run.status == "failure"
    assert run.executive.reason == ("'turn' rejected: /turn: its server gave no reason")


def test_interrupt_cancels_every_goal_and_waits_for_the_servers(play: Any) -> None:
    """Both goals are cancelled at once; the mission is done when both have ended."""
    run = play(TWO_TURNS)
    run.tick()
    other = run.servers["/other"]
    run.turn.accept()
    other.accept()
    run.tick()
    run.executive.interrupt("interrupted by Ctrl-C")
    assert len(run.turn.cancels) == len(other.cancels) == 1
    run.turn.cancel("partial")
    run.tick()
    assert run.status == "ending"
    other.cancel("partial")
    run.tick()
    assert run.status == "interrupted"
    assert run.executive.reason == "interrupted by Ctrl-C"
    assert run.executive.goals_left_behind == ()


def test_a_server_that_never_confirms_is_named_after_the_grace_period(play: Any) -> None:
    """The end of a mission is bounded: three seconds of ROS time, then the truth."""
    run = play(TURN)
    run.tick()
    run.turn.accept()
    run.tick()
    run.executive.interrupt("interrupted by Ctrl-C")
    run.tick(59)
    assert run.status == "ending"
    run.tick(2)
    assert run.status == "interrupted"
    goal = run.turn.goal
    assert run.executive.goals_left_behind == (f"/turn goal {goal.short_id} of 'turn' (lost)",)
    assert "orphaned goals: /turn goal" in run.executive.reason


def test_success_with_a_goal_left_behind_is_a_failure(play: Any) -> None:
    """A tree may succeed while a halted goal never ends; the mission then has not."""
    run = play("  parallel: [{turn: {angle: 90}, timeout: 9}, {wait: 0.1}]\n  succeed_when: any")
    run.tick()
    run.turn.accept()
    run.tick(70)
    assert run.root.status is Status.SUCCESS
    assert run.status == "failure"
    assert "orphaned goals" in run.executive.reason


def test_an_exception_in_a_leaf_halts_its_siblings(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tree is halted, goals are cancelled, and the mission fails with the cause."""
    run = play("  parallel: [{turn: {angle: 90}, timeout: 9}, {wait: 5, name: faulty}]")
    run.tick()
    run.turn.accept()
    run.tick()
    faulty = next(node for node in run.root.iterate() if node.name == "faulty")

    def explode() -> Status:
        raise RuntimeError("broken leaf")

    monkeypatch.setattr(faulty, "update", explode)
    run.tick()
    assert len(run.turn.cancels) == 1
    run.turn.cancel("partial")
    run.tick()
    assert run.status == "failure"
    assert run.executive.reason.startswith("RuntimeError: broken leaf (test_executive.py:")
    assert run.statuses == "III"


def test_an_exception_while_halting_does_not_keep_the_others_running(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each node is stopped by itself; what a node raises is added to the reason."""
    run = play("  parallel: [{wait: 5, name: faulty}, {turn: {angle: 90}, timeout: 9}]")
    run.tick()
    run.turn.accept()
    faulty = next(node for node in run.root.iterate() if node.name == "faulty")

    def explode(_: Status) -> None:
        raise RuntimeError("cannot stop")

    monkeypatch.setattr(faulty, "terminate", explode)
    run.executive.interrupt("interrupted")
    assert len(run.turn.cancels) == 1
    run.turn.cancel("partial")
    run.tick()
    assert "stopping 'faulty' raised RuntimeError: cannot stop" in run.executive.reason
    assert run.executive.goals_left_behind == ()


def test_abandon_leaves_at_once_and_names_the_goals(play: Any) -> None:
    """A second Ctrl-C does not wait; the goals still alive stand in the reason."""
    run = play(TURN)
    run.tick()
    run.turn.accept()
    run.tick()
    run.executive.interrupt("interrupted by Ctrl-C")
    run.executive.abandon("left at once")
    assert run.executive.is_done
    assert run.status == "interrupted"
    assert "/turn goal" in run.executive.reason
    assert len(run.turn.cancels) == 1


def test_interrupting_twice_is_the_same_as_once(play: Any) -> None:
    """And after the end it changes nothing."""
    run = play("  wait: 0.05")
    run.tick(2)
    assert run.status == "success"
    run.executive.interrupt("late")
    run.executive.fail("late")
    run.executive.abandon("late")
    assert (run.status, run.executive.reason) == ("success", "")


def test_subscribers_get_each_change_once_with_its_time_and_place(play: Any) -> None:
    """Not one line for each tick: only what changed."""
    run = play("  sequence: [{wait: 0.1, name: rest}, {log: done, name: say}]")
    events: list[Event] = []
    run.executive.events.subscribe(events.append)
    run.tick(3)
    nodes = run.executive.node_infos
    assert [
        (
            event.time_ns // 1_000_000,
            nodes[event.node].path,
            nodes[event.node].name,
            event.status.value,
        )
        for event in events
        if isinstance(event, NodeChanged) and event.time_ns is not None
    ] == [
        (1050, "0.0", "rest", "RUNNING"),
        (1050, "0", "test", "RUNNING"),
        (1150, "0.0", "rest", "SUCCESS"),
        (1150, "0.1", "say", "SUCCESS"),
        (1150, "0", "test", "SUCCESS"),
    ]


def test_the_same_play_gives_the_same_trace(play: Any) -> None:
    """The trace's hash repeats; another event changes it."""
    hashes = []
    for reject in (False, False, True):
        run = play(TURN)
        run.tick()
        if reject:
            run.turn.reject()
        else:
            run.turn.accept()
            run.turn.succeed("done")
        run.tick()
        hashes.append(run.trace.sha256)
    assert hashes[0] == hashes[1] != hashes[2]


def test_a_halt_stops_each_leaf_once(play: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """And each goal is handed over once."""
    run = play(TWO_TURNS)
    run.tick(2)
    stopped, events = [], []

    def watched(leaf: Any) -> Any:
        terminate = leaf.terminate

        def stop(status: Status) -> None:
            stopped.append(leaf.name)
            terminate(status)

        return stop

    for leaf in run.executive.running_leaves:
        monkeypatch.setattr(leaf, "terminate", watched(leaf))
    run.executive.events.subscribe(
        lambda event: (
            events.append((event.change, event.owner)) if isinstance(event, GoalChanged) else None
        )
    )
    run.executive.interrupt("enough")
    assert stopped == ["turn", "other"]
    assert events == [("released", "turn"), ("released", "other")]


def test_a_goal_whose_leaf_is_left_running_is_cancelled(play: Any) -> None:
    """A composite of the user's own may end without halting its children."""
    run = play(TWO_TURNS)
    run.tick()
    run.turn.accept()
    run.tick()
    root = run.root

    def tick() -> Any:
        root.status = Status.SUCCESS
        yield root

    root.tick = tick
    run.tick()
    assert len(run.turn.cancels) == 1
    assert [leaf.status for leaf in root.children] == [Status.INVALID, Status.INVALID]
