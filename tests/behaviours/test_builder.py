"""Each kind of the mission language becomes a behaviour with these statuses, tick by tick.

Letters are statuses from the root down: R running, S success, F failure, I not ticked (invalid).
"""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.action import Turn

from bt_mission.behaviours.leaves import LeafProgress
from bt_mission.ros.interface_types import fill


def result(angle: float = 0.0) -> Any:
    """What /turn gives back."""
    return Turn.Result(angle_turned=angle)


def feedback(current: float, remaining: float = 0.0) -> Any:
    """What /turn says on the way."""
    return Turn.Feedback(current_angle=current, remaining_angle=remaining)


def test_wait_ends_at_its_exact_time(play: Any) -> None:
    """A wait entered at a tick runs for its seconds of ROS time."""
    run = play("  wait: 1.0")
    assert run.tick() == "R"
    assert run.tick(19) == "R"
    assert run.tick() == "S"


def test_repeat_runs_its_child_count_times(play: Any) -> None:
    """One round a tick; the count is read when the repeat starts."""
    run = play("  repeat: {count: $n}\n  do: {log: again}", "mission: t\ninputs: {n: 3}")
    assert run.tick() == "RS"
    assert run.tick() == "RS"
    assert run.tick() == "SS"
    assert run.logged == ["again"] * 3


def test_repeat_reads_a_random_count_once(play: Any) -> None:
    """The count that was drawn at the start is the one that holds."""
    tree = "  repeat: {count: 'round(uniform(2, 9))'}\n  do: {log: again}"
    run = play(tree)
    run.tick(20)
    assert f"{len(run.logged)} of {len(run.logged)}" == run.root.feedback_message


def test_log_fills_in_variables(play: Any) -> None:
    """``$name`` and ``${expression}`` are read when the node is reached."""
    run = play("  log: 'at $speed m/s, ${speed * 2}'", "mission: t\ninputs: {speed: 0.5}")
    run.tick()
    assert run.logged == ["at 0.5 m/s, 1"]


def test_a_long_line_is_cut_and_its_length_logged(play: Any) -> None:
    """A list of pictures does not flood a terminal."""
    run = play("  log: $word", f"mission: t\ninputs: {{word: {'x' * 1_001}}}")
    run.tick()
    assert run.logged == [f"{'x' * 1_000} ... (1,001 characters)"]


def test_an_action_sends_its_resolved_goal(play: Any) -> None:
    """Expressions of the goal are evaluated when the leaf starts."""
    run = play("  turn: {angle: '$a * 2'}\n  timeout: 9", "mission: t\ninputs: {a: 45}")
    run.tick()
    (request,) = run.turn.requests
    assert fill(Turn.Goal(), request).angle == 90


def test_outputs_are_written_from_the_result(play: Any) -> None:
    """A later node reads them."""
    run = play(
        "  sequence:\n"
        "    - {turn: {angle: 90}, timeout: 9, outputs: {angle_turned: turned}}\n"
        "    - log: turned $turned deg"
    )
    run.tick()
    run.turn.accept()
    run.turn.succeed(result(89.5))
    run.tick()
    assert run.logged == ["turned 89.5 deg"]


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
    run.turn.feed(feedback(44.0))
    run.tick()
    assert run.turn.cancels == []
    run.turn.feed(feedback(46.0))
    run.tick()
    assert run.turn.cancels == [run.turn.goal]
    run.turn.cancel(result(46.5))
    assert run.tick() == "SSS"
    assert run.logged == ["turned 46.5 deg"]


def test_a_cancelled_goal_is_a_failure_unless_said_otherwise(play: Any) -> None:
    """``on_cancel`` is failure by default; the reason names the condition and the values."""
    run = play("  turn: {angle: 90}\n  timeout: 9\n  cancel_when: current_angle > 45")
    run.tick()
    run.turn.accept()
    run.turn.feed(feedback(50.0))
    run.tick()
    run.turn.cancel(result())
    assert run.tick() == "F"
    assert run.executive.reason == (
        "'turn' canceled by condition: current_angle > 45 (current_angle = 50)"
    )


def test_timeout_of_a_goal(play: Any) -> None:
    """The limit of the mission file is the attempt's."""
    run = play("  turn: {angle: 90}\n  timeout: 1")
    run.tick()
    run.turn.accept()
    run.tick(20)
    assert run.turn.cancels == []
    run.tick()
    assert run.turn.cancels == [run.turn.goal]


def test_progress_is_measured_towards_the_conditions_bound(play: Any) -> None:
    """The live view draws feedback against the bound, or time against the timeout."""
    run = play("  turn: {angle: 90}\n  timeout: 10\n  cancel_when: current_angle >= 45")
    run.tick()
    run.turn.accept()
    run.tick()
    assert run.root.progress.label == "s"
    assert run.root.progress.limit == 10
    run.turn.feed(feedback(15.0))
    run.tick()
    assert (run.root.progress.label, run.root.progress.value, run.root.progress.limit) == (
        "current_angle",
        15.0,
        45.0,
    )


def test_progress_without_a_condition_is_the_goals_own_measure(play: Any) -> None:
    """The angle turned of the angle to turn, rather than the time of the timeout."""
    run = play("  turn: {angle: -90}\n  timeout: 10")
    run.tick()
    run.turn.goal.request = Turn.Goal(angle=-90.0)
    run.turn.accept()
    run.turn.feed(feedback(-15.0, -75.0))
    run.tick()
    assert run.root.progress == LeafProgress("current_angle", 15.0, 90.0)


def after_turning(play: Any, angle: float, *node: str) -> Any:
    """Play a node that comes after a turn, whose result it reads as ``$n``."""
    lines = "\n".join(f"{'    - ' if i == 0 else '      '}{line}" for i, line in enumerate(node))
    first = "    - {turn: {angle: 9}, timeout: 9, outputs: {angle_turned: n}}"
    run = play(f"  sequence:\n{first}\n{lines}")
    run.tick()
    run.turn.accept()
    run.turn.succeed(result(angle))
    return run


@pytest.mark.parametrize(
    ("node", "value", "words"),
    [
        (["wait: $n"], -1, "<text>:5:7: 'wait' cannot start: expected seconds, 0 or more, got -1"),
        (["wait: 1 / $n"], 0, "'wait' cannot start: division by zero"),
        (["wait: $n"], float("inf"), "expected seconds, 0 or more, got inf"),
        (["wait: $n"], float("nan"), "expected seconds, 0 or more, got nan"),
        (
            ["repeat: {count: $n}", "do: {log: x}"],
            1.5,
            "expected an integer of at least 1, got 1.5",
        ),
        (
            ["repeat: {count: $n}", "do: {log: x}"],
            -1,
            "expected an integer of at least 1, got -1",
        ),
        (
            ["retry: {attempts: $n}", "do: {log: x}"],
            0,
            "expected an integer of at least 1, got 0",
        ),
        (["turn: {angle: 9}", "timeout: $n"], 0, "expected seconds above 0, got 0"),
    ],
)
def test_a_value_that_is_wrong_only_at_run_time_fails_the_mission_with_its_place(
    play: Any, node: list[str], value: float, words: str
) -> None:
    """No traceback: the mission fails and says which node could not start, and why."""
    run = after_turning(play, value, *node)
    run.tick(2)
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
