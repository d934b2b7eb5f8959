"""Pauses, steps and breakpoints, tick by tick."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.core.errors import BtMissionError


def statuses(play: Any) -> list[str]:
    """Every node with its status, depth first."""
    return [f"{node.name} {node.status.value}" for node in play.executive.nodes]


LEAVES = (
    "  sequence:\n    - check: true\n      name: a\n    - check: true\n      name: b\n"
    "    - check: true\n      name: c\n"
)


def test_a_tick_goes_on_where_it_stopped(play: Any) -> None:
    """What came before the breakpoint is not run again: still the first tick."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.tick()
    assert run.executive.paused == "breakpoint at 'b'"
    assert statuses(run)[1:] == ["a SUCCESS", "b INVALID", "c INVALID"]
    run.tick()
    assert statuses(run)[1:] == ["a SUCCESS", "b INVALID", "c INVALID"]
    run.executive.resume()
    run.tick()
    assert (run.executive.state, run.executive.ticks) == ("success", 1)


def test_a_step_stops_at_the_next_breakpoint(play: Any) -> None:
    """Within the same tick of the tree."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.executive.breakpoints.add("c")
    run.tick()
    run.executive.step()
    run.tick()
    assert run.executive.paused == "breakpoint at 'c'"
    run.executive.step()
    run.tick()
    assert run.executive.state == "success"


@pytest.mark.parametrize(
    "tree",
    [
        "  fallback:\n    - {do}\n    - check: true\n",
        "  parallel:\n    - {do}\n    - check: true\n",
        "  choose:\n    - {do}\n",
        "  when: true\n  do:\n    {do}\n",
        "  guard: true\n  do:\n    {do}\n",
        "  timeout: 5\n  do:\n    {do}\n",
        "  repeat: {{count: 2}}\n  do:\n    {do}\n",
        "  retry: {{attempts: 2}}\n  do:\n    {do}\n",
        "  for_each: {{x: [1, 2]}}\n  do:\n    {do}\n",
        "  force: success\n  do:\n    {do}\n",
        "  invert:\n    invert:\n      {do}\n",
    ],
)
def test_every_parent_passes_a_breakpoint_on(play: Any, tree: str) -> None:
    """And comes to the end that it has without one."""
    run = play(tree.format(do="log: x"))
    run.executive.breakpoints.add("log")
    for _ in range(10):
        run.tick()
        run.executive.resume()
    assert run.executive.state == "success"
    stops = [line for line in run.trace.newest if '"event": "paused"' in line]
    assert len(stops) == (2 if "repeat" in tree or "for_each" in tree else 1)


def test_halted_at_a_breakpoint(play: Any) -> None:
    """A mission that is stopped there ends as elsewhere."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.tick()
    run.executive.interrupt("enough")
    run.tick()
    assert (run.executive.state, run.executive.reason) == ("interrupted", "enough")
    assert run.executive.paused is None


def test_at_a_breakpoint_goals_beside_it_are_cancelled(play: Any) -> None:
    """Nobody watches them during the pause; they start anew after it."""
    run = play("  parallel:\n    - turn: {angle: 9}\n    - sequence: [{wait: 1}, {log: x}]\n")
    run.tick()
    run.turn.accept()
    run.executive.breakpoints.add("log")
    run.tick(25)
    assert run.executive.state == "paused"
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.executive.resume()
    run.tick(2)
    assert len(run.turn.goals) == 2


def test_a_breakpoint_by_name_means_all_of_that_name(play: Any) -> None:
    """Removed, they are gone; one set twice by different names stays with the other."""
    run = play("  sequence: [{log: x}, {log: y}, {wait: 1}]\n")
    points = run.executive.breakpoints
    assert points.add("log") == 2
    assert points.add("0.1") == 1
    points.remove("log")
    with pytest.raises(BtMissionError, match="no breakpoint is set at 'log'"):
        points.remove("log")
    run.tick()
    assert run.executive.paused == "breakpoint at 'log'"
    assert statuses(run)[1:] == ["log SUCCESS", "log INVALID", "wait INVALID"]
