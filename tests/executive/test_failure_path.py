"""What made a tree fail is told from the root down to the leaf."""

from __future__ import annotations

from typing import Any

from bt_mission.executive.report import FailurePath, report_on
from bt_mission.executive.trace import Trace
from bt_mission.sessions.load import load

TREE = """\
  sequence:
    - {log: hello}
    - retry: {attempts: 2}
      do:
        fallback:
          - {turn: {angle: 90}, name: first way, timeout: 30}
          - {turn: {angle: 180}, name: second way, timeout: 30}
"""


def report_of(run: Any, virtual_s: float) -> Any:
    """The report of a mission that has ended after so many seconds."""
    mission = load(f"mission: test\ntree:\n{TREE}")
    return report_on(mission, run.executive, Trace(), virtual_s, 1.0)


def test_a_failure_is_named_by_the_path_to_it(play: Any) -> None:
    """In the report for programs and in the summary for people."""
    run = play(TREE)
    while not run.executive.is_done:
        run.tick()
        run.turn.reject()
    report = report_of(run, 1.0)
    assert report.failure == FailurePath(
        nodes=("test", "retry", "fallback", "second way"),
        path="0.1.0.1",
        message="rejected: /turn: its server gave no reason",
        time_s=1.0,
    )
    assert report.as_text().splitlines()[:2] == [
        "test: failure: 'second way' rejected: /turn: its server gave no reason",
        "  test > retry > fallback > second way, at 1.00 s",
    ]
    assert report.as_dict()["failure"]["nodes"] == ("test", "retry", "fallback", "second way")


def test_the_summary_counts_in_words_that_fit(play: Any) -> None:
    """One goal is no goals."""
    run = play("  turn: {angle: 90}\n")
    run.tick()
    run.turn.reject()
    run.tick(2)
    assert report_of(run, 1.0).as_text().splitlines()[-1] == "  1 goal sent, 0 orphaned"


def test_what_has_not_failed_has_no_path(play: Any) -> None:
    """Neither a success nor what was interrupted before any node had failed."""
    run = play("  wait: 0.1\n")
    run.tick(9)
    assert report_of(run, 1.0).failure is None
    run = play(TREE)
    run.tick()
    run.executive.interrupt("interrupted by Ctrl-C")
    run.turn.reject()
    run.tick(2)
    report = report_of(run, 1.0)
    assert (report.status, report.failure) == ("interrupted", None)
    assert report.as_text().splitlines()[0] == "test: interrupted by Ctrl-C"


def test_a_failure_that_was_caught_before_is_not_on_the_path(play: Any) -> None:
    """The first fallback went on, the second did not."""
    run = play(
        "  sequence:\n"
        "    - fallback:\n"
        "        - {turn: {angle: 90}, name: caught, timeout: 30}\n"
        "        - {log: went on}\n"
        "    - {turn: {angle: 90}, name: fatal, timeout: 30}\n"
    )
    while not run.executive.is_done:
        run.tick()
        run.turn.reject()
    assert report_of(run, 1.0).failure.nodes == ("test", "fatal")
