"""Each kind of the mission language becomes a behaviour with these statuses, tick by tick.

Letters are statuses from the root down: R running, S success, F failure, I not ticked (invalid).
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn

from bt_mission.executive.behaviours.builder import revise_tree
from bt_mission.executive.behaviours.leaves import LeafProgress
from bt_mission.ros.interface_types import fill
from bt_mission.sessions.load import load


def test_a_long_line_is_cut_and_its_length_logged(play: Any) -> None:
    """A list of pictures does not flood a terminal."""
    run = play("  log: $word", f"mission: t\ninputs: {{word: {'x' * 1_001}}}")
    run.tick()
    assert run.logged == [f"{'x' * 1_000} ... (1,001 characters)"]


def test_outputs_of_a_goal_cancelled_by_its_condition_are_written_too(play: Any) -> None:
    """A server returns a result when it is cancelled; ``on_cancel: success`` goes on with it."""
    run = play(
        "  sequence:\n"
        "    - turn: {angle: 90}\n"
        "      timeout: 9\n"
        "      cancel_when: current_angle > 45\n"
        "      on_cancel: success\n"
        "      outputs: {angle_turned: turned}\n"
        "    - log: turned $turned deg"
    )
    run.tick()
    run.turn.accept()
    run.turn.feed(Turn.Feedback(current_angle=44.0))
    run.tick()
    assert run.turn.cancels == []
    run.turn.feed(Turn.Feedback(current_angle=46.0))
    run.tick()
    assert run.turn.cancels == [run.turn.goal]
    run.turn.cancel(Turn.Result(angle_turned=46.5))
    assert run.tick() == "SSS"
    assert run.logged == ["turned 46.5 deg"]


def test_a_cancelled_goal_is_a_failure_unless_said_otherwise(play: Any) -> None:
    """``on_cancel`` is failure by default; the reason names the condition and the values."""
    run = play("  turn: {angle: 90}\n  timeout: 9\n  cancel_when: current_angle > 45")
    run.tick()
    run.turn.accept()
    run.turn.feed(Turn.Feedback(current_angle=50.0))
    run.tick()
    run.turn.cancel(Turn.Result())
    assert run.tick() == "F"
    assert run.executive.reason == (
        "'turn' canceled by condition: current_angle > 45 (current_angle = 50)"
    )


TREE = "  repeat: {count: 4}\n  do:\n    turn: {angle: %s}\n    timeout: %s\n"


def finish_goals(run: Any, count: int = 1) -> None:
    """Have the server accept and end one goal after another."""
    for _ in range(count):
        run.tick()
        run.turn.accept()
        run.turn.succeed()
        run.tick()


def test_a_goal_is_filled_once_when_its_leaf_starts(play: Any) -> None:
    """In each round; a revised node sends what it says now, with its limit."""
    run = play(TREE % (90, 60))
    asked: list[Any] = []

    def prepare(fields: Any) -> Any:
        asked.append(dict(fields))
        return fields

    run.turn.prepare = prepare
    finish_goals(run, 2)
    assert asked == run.turn.requests == [{"angle": 90}] * 2
    revise_tree(load(f"mission: test\ntree:\n{TREE % (45, 1)}"), run.scope)
    finish_goals(run)
    assert asked[2:] == run.turn.requests[2:] == [{"angle": 45}]
    assert_limit(run, 1)


def test_what_reads_a_variable_is_computed_for_each_goal(play: Any) -> None:
    """Fields and limits."""
    run = play(TREE % ("$angle * 2", "$limit"), "mission: m\ninputs: {angle: 90, limit: 60}")
    for angle in (90, 45):
        run.scope.values["angle"] = angle
        finish_goals(run)
        assert fill(Turn.Goal(), run.turn.requests[-1]).angle == 2 * angle
    run.scope.values["limit"] = 1
    assert_limit(run, 1)


def assert_limit(run: Any, seconds: int) -> None:
    """The next goal is cancelled after its time, to the tick."""
    run.tick()
    run.turn.accept()
    run.tick(20 * seconds)
    assert run.turn.cancels == []
    run.tick()
    assert run.turn.cancels == [run.turn.goal]


@pytest.mark.parametrize(
    ("angle", "condition", "progress"),
    [
        (90, "\n  cancel_when: current_angle >= 45", LeafProgress("current_angle", 15.0, 45.0)),
        (-90, "", LeafProgress("current_angle", 15.0, 90.0)),
    ],
    ids=["towards the bound of its condition", "of the angle to turn"],
)
def test_progress_is_measured_by_the_feedback(
    play: Any, angle: int, condition: str, progress: LeafProgress
) -> None:
    """Before the first feedback it is the time, of the timeout."""
    run = play(f"  turn: {{angle: {angle}}}\n  timeout: 10{condition}")
    run.tick()
    run.turn.goal.request = Turn.Goal(angle=float(angle))
    run.turn.accept()
    run.tick()
    assert (run.root.progress.label, run.root.progress.limit) == ("s", 10)
    turned = math.copysign(15.0, angle)
    run.turn.feed(Turn.Feedback(current_angle=turned, remaining_angle=angle - turned))
    run.tick()
    assert run.root.progress == progress


@pytest.mark.parametrize(
    ("node", "value", "words"),
    [
        ("wait: $n", -1, "<text>:5:7: 'wait' cannot start: expected seconds, 0 or more, got -1"),
        ("wait: 1 / $n", 0, "'wait' cannot start: division by zero"),
        ("wait: $n", float("inf"), "expected seconds, 0 or more, got inf"),
        ("wait: $n", float("nan"), "expected seconds, 0 or more, got nan"),
        ("{repeat: {count: $n}, do: {log: x}}", 1.5, "expected an integer of at least 1, got 1.5"),
        ("{repeat: {count: $n}, do: {log: x}}", -1, "expected an integer of at least 1, got -1"),
        ("{retry: {attempts: $n}, do: {log: x}}", 0, "expected an integer of at least 1, got 0"),
        ("{turn: {angle: 9}, timeout: $n}", 0, "expected seconds above 0, got 0"),
    ],
)
def test_a_value_that_is_wrong_only_at_run_time_fails_the_mission_with_its_place(
    play: Any, node: str, value: float, words: str
) -> None:
    """No traceback: the mission fails and says which node could not start, and why."""
    turn = "{turn: {angle: 9}, timeout: 9, outputs: {angle_turned: n}}"
    run = play(f"  sequence:\n    - {turn}\n    - {node}")
    run.tick()
    run.turn.accept()
    run.turn.succeed(Turn.Result(angle_turned=value))
    run.tick(3)
    assert run.status == "failure"
    assert words in run.executive.reason


def test_a_missing_output_fails_the_mission_with_its_name(play: Any) -> None:
    """A goal that ended without a result wrote nothing; whoever reads it says so."""
    run = play(
        "  sequence:\n"
        "    - fallback:\n"
        "        - {turn: {angle: 90}, timeout: 9, outputs: {angle_turned: turned}}\n"
        "        - {log: rejected}\n"
        "    - log: turned $turned deg"
    )
    run.tick()
    run.turn.reject()
    run.tick(2)
    assert run.status == "failure"
    assert "'$turned' has no value" in run.executive.reason


def test_random_draws_repeat_with_the_seed_and_differ_between_nodes(play: Any) -> None:
    """Each node has a generator of its own, so a node added elsewhere does not shift its draws."""
    tree = "  sequence: [{log: '${uniform(0, 1)}'}, {log: '${uniform(0, 1)}'}]"
    lines = []
    for seed in (1, 1, 2):
        run = play(tree, f"mission: t\nseed: {seed}")
        run.tick()
        lines.append(tuple(run.logged))
    assert lines[0] == lines[1] != lines[2]
    assert lines[0][0] != lines[0][1]


def test_trees_are_built_without_a_runtime(play: Any) -> None:
    """Names come from the file, or from the kind or the action; the root has the mission's."""
    run = play("  sequence:\n    - {wait: 1, name: rest}\n    - {turn: {angle: 9}, timeout: 1}")
    assert [node.name for node in run.root.iterate()] == ["rest", "turn", "test"]
