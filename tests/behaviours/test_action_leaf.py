"""What a leaf computes for each of its goals."""

from __future__ import annotations

from typing import Any

from bt_mission.behaviours.builder import revise_tree
from bt_mission.sessions.load import load

TREE = "  repeat: {count: 4}\n  do:\n    turn: {angle: %s}\n    timeout: %s\n"


def finish_goals(run: Any, count: int) -> None:
    """Have the server accept and end one goal after another."""
    for _ in range(count):
        run.tick()
        run.turn.accept()
        run.turn.succeed()
        run.tick()


def prepared_by(run: Any) -> list[Any]:
    """Return what the server's client is asked to fill from now on."""
    asked: list[Any] = []
    prepare = run.turn.prepare

    def count(fields: Any) -> Any:
        asked.append(dict(fields))
        return prepare(fields)

    run.turn.prepare = count
    return asked


def test_a_goal_is_filled_when_the_leaf_starts(play: Any) -> None:
    """Once for each goal that the leaf sends."""
    run = play(TREE % (90, 60))
    asked = prepared_by(run)
    finish_goals(run, 3)
    assert asked == [{"angle": 90}] * 3
    assert run.turn.requests == [{"angle": 90}] * 3


def test_what_reads_a_variable_is_computed_for_each_goal(play: Any) -> None:
    """Fields and limits."""
    run = play(TREE % ("$angle", "$limit"), "mission: m\ninputs: {angle: 90, limit: 60}")
    for angle, limit in ((90, 60.0), (45, 30.0)):
        run.scope.values |= {"angle": angle, "limit": limit}
        finish_goals(run, 1)
        (leaf,) = (node for node in run.executive.nodes if node.name == "turn")
        assert run.turn.requests[-1]["angle"].as_value() == angle
        assert leaf._limits.goal == limit


def test_a_revised_node_sends_what_it_says_now(play: Any) -> None:
    """Also where neither version computes anything."""
    run = play(TREE % (90, 60))
    finish_goals(run, 2)
    revise_tree(load(f"mission: test\ntree:\n{TREE % (45, 30)}"), run.scope)
    finish_goals(run, 1)
    (leaf,) = (node for node in run.executive.nodes if node.name == "turn")
    assert [request["angle"] for request in run.turn.requests] == [90, 90, 45]
    assert leaf._limits.goal == 30
