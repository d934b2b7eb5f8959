"""The executive ends a mission with every goal accounted for, whatever happens."""

from __future__ import annotations

from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.events.events import Event, GoalChanged, NodeChanged

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
    story = play(TURN)
    story.tick()
    story.turn.accept()
    story.turn.succeed("done")
    story.tick()
    executive = story.executive
    assert (story.status, executive.reason) == ("success", "")
    assert (executive.goals_sent, executive.goals_left_behind) == (1, ())


def test_failure_names_the_leaf_and_why(play: Any) -> None:
    """The reason is the failing leaf's own."""
    story = play(
        f"  sequence:\n    - {{log: hello}}\n    - {TURN.strip()}".replace(
            "\n  timeout", "\n      timeout"
        )
    )
    story.tick()
    story.turn.reject()
    story.tick()
    assert story.status == "failure"
    assert story.executive.reason == ("'turn' rejected: /turn: its server gave no reason")


def test_interrupt_cancels_every_goal_and_waits_for_the_servers(play: Any) -> None:
    """Both goals are cancelled at once; the mission is done when both have ended."""
    story = play(TWO_TURNS)
    story.tick()
    other = story.servers["/other"]
    story.turn.accept()
    other.accept()
    story.tick()
    story.executive.interrupt("interrupted by Ctrl-C")
    assert len(story.turn.cancels) == len(other.cancels) == 1
    story.turn.cancel("partial")
    story.tick()
    assert story.status == "ending"
    other.cancel("partial")
    story.tick()
    assert story.status == "interrupted"
    assert story.executive.reason == "interrupted by Ctrl-C"
    assert story.executive.goals_left_behind == ()


def test_a_server_that_never_confirms_is_named_after_the_grace_period(play: Any) -> None:
    """The end of a mission is bounded: three seconds of ROS time, then the truth."""
    story = play(TURN)
    story.tick()
    story.turn.accept()
    story.tick()
    story.executive.interrupt("interrupted by Ctrl-C")
    story.tick(59)
    assert story.status == "ending"
    story.tick(2)
    assert story.status == "interrupted"
    goal = story.turn.goal
    assert story.executive.goals_left_behind == (f"/turn goal {goal.short_id} of 'turn' (lost)",)
    assert "orphaned goals: /turn goal" in story.executive.reason


def test_success_with_a_goal_left_behind_is_a_failure(play: Any) -> None:
    """A tree may succeed while a halted goal never ends; the mission then has not."""
    story = play("  parallel: [{turn: {angle: 90}, timeout: 9}, {wait: 0.1}]\n  succeed_when: any")
    story.tick()
    story.turn.accept()
    story.tick(70)
    assert story.root.status is Status.SUCCESS
    assert story.status == "failure"
    assert "orphaned goals" in story.executive.reason


def test_an_exception_in_a_leaf_halts_its_siblings(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tree is halted, goals are cancelled, and the mission fails with the cause."""
    story = play("  parallel: [{turn: {angle: 90}, timeout: 9}, {wait: 5, name: faulty}]")
    story.tick()
    story.turn.accept()
    story.tick()
    faulty = next(node for node in story.root.iterate() if node.name == "faulty")

    def explode() -> Status:
        raise RuntimeError("broken leaf")

    monkeypatch.setattr(faulty, "update", explode)
    story.tick()
    assert len(story.turn.cancels) == 1
    story.turn.cancel("partial")
    story.tick()
    assert story.status == "failure"
    assert story.executive.reason.startswith("RuntimeError: broken leaf (test_executive.py:")
    assert story.statuses == "III"


def test_an_exception_while_halting_does_not_keep_the_others_running(
    play: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each node is stopped by itself; what a node raises is added to the reason."""
    story = play("  parallel: [{wait: 5, name: faulty}, {turn: {angle: 90}, timeout: 9}]")
    story.tick()
    story.turn.accept()
    faulty = next(node for node in story.root.iterate() if node.name == "faulty")

    def explode(_: Status) -> None:
        raise RuntimeError("cannot stop")

    monkeypatch.setattr(faulty, "terminate", explode)
    story.executive.interrupt("interrupted")
    assert len(story.turn.cancels) == 1
    story.turn.cancel("partial")
    story.tick()
    assert "stopping 'faulty' raised RuntimeError: cannot stop" in story.executive.reason
    assert story.executive.goals_left_behind == ()


def test_abandon_leaves_at_once_and_names_the_goals(play: Any) -> None:
    """A second Ctrl-C does not wait; the goals still alive stand in the reason."""
    story = play(TURN)
    story.tick()
    story.turn.accept()
    story.tick()
    story.executive.interrupt("interrupted by Ctrl-C")
    story.executive.abandon("left at once")
    assert story.executive.is_done
    assert story.status == "interrupted"
    assert "/turn goal" in story.executive.reason
    assert len(story.turn.cancels) == 1


def test_interrupting_twice_is_the_same_as_once(play: Any) -> None:
    """And after the end it changes nothing."""
    story = play("  wait: 0.05")
    story.tick(2)
    assert story.status == "success"
    story.executive.interrupt("late")
    story.executive.fail("late")
    story.executive.abandon("late")
    assert (story.status, story.executive.reason) == ("success", "")


def test_subscribers_get_each_change_once_with_its_time_and_place(play: Any) -> None:
    """Not one line for each tick: only what changed."""
    story = play("  sequence: [{wait: 0.1, name: rest}, {log: done, name: say}]")
    events: list[Event] = []
    story.executive.events.subscribe(events.append)
    story.tick(3)
    nodes = story.executive.node_infos
    assert [
        (one.time_ns // 1_000_000, nodes[one.node].path, nodes[one.node].name, one.status.value)
        for one in events
        if isinstance(one, NodeChanged) and one.time_ns is not None
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
        story = play(TURN)
        story.tick()
        if reject:
            story.turn.reject()
        else:
            story.turn.accept()
            story.turn.succeed("done")
        story.tick()
        hashes.append(story.trace.sha256)
    assert hashes[0] == hashes[1] != hashes[2]


def test_a_halt_stops_each_leaf_once(play: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """And each goal is handed over once."""
    story = play(TWO_TURNS)
    story.tick(2)
    stopped, events = [], []

    def watched(leaf: Any) -> Any:
        terminate = leaf.terminate

        def stop(status: Status) -> None:
            stopped.append(leaf.name)
            terminate(status)

        return stop

    for leaf in story.executive.running_leaves:
        monkeypatch.setattr(leaf, "terminate", watched(leaf))
    story.executive.events.subscribe(
        lambda event: (
            events.append((event.change, event.owner)) if isinstance(event, GoalChanged) else None
        )
    )
    story.executive.interrupt("enough")
    assert stopped == ["turn", "other"]
    assert events == [("released", "turn"), ("released", "other")]


def test_a_goal_whose_leaf_is_left_running_is_cancelled(play: Any) -> None:
    """A composite of the user's own may end without halting its children."""
    story = play(TWO_TURNS)
    story.tick()
    story.turn.accept()
    story.tick()
    root = story.root

    def tick() -> Any:
        root.status = Status.SUCCESS
        yield root

    root.tick = tick
    story.tick()
    assert len(story.turn.cancels) == 1
    assert [leaf.status for leaf in root.children] == [Status.INVALID, Status.INVALID]
