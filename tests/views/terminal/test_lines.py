"""A run in plain lines, and what its leaves came to, in columns."""

from __future__ import annotations

import io
from typing import Any

import pytest

from bt_mission.executive.events.events import NodeChanged
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.leaf_statistics import LeafSummary
from bt_mission.views.terminal.followed import FollowedLines
from bt_mission.views.terminal.lines import (
    MOST_ROWS,
    PlainLines,
    RequirementLines,
    leaf_table,
    whole_tree,
)
from bt_mission.views.terminal.marks import ASCII_SIGNS, SIGNS
from tests.support.watched import S, ScriptedExecutive, known, requirement, tree

DRIVE = LeafSummary("drive", "0.0", 12, {"canceled by condition": 2, "succeeded": 10}, 85.5, 16.1)
LOG = LeafSummary("log", "0.1", 3, {"success": 3}, 0.0, 0.0)
CHECK = LeafSummary("check", "0.2", 1, {"failure": 1}, 0.0, 0.0)


WAIT = LeafSummary("wait", "0", 1, {"success": 1}, 2.0, None)
BOTH = LeafSummary("a", "0", 6, {"succeeded": 4, "success": 1, "failure": 1}, 1.0, None)


@pytest.mark.parametrize(
    ("leaves", "lines"),
    [
        pytest.param(
            [DRIVE, LOG, CHECK],
            [
                "  leaf   runs     time   driven  outcomes",
                "  drive    12  85.50 s  16.10 m  10 succeeded, 2 canceled by condition",
                "  check     1   0.00 s   0.00 m  failed",
            ],
            id="what took no time and succeeded is left out",
        ),
        pytest.param(
            [WAIT],
            ["  leaf  runs    time  outcomes", "  wait     1  2.00 s  succeeded"],
            id="no column for distances that are not known",
        ),
        pytest.param(
            [BOTH],
            ["  leaf  runs    time  outcomes", "  a        6  1.00 s  5 succeeded, 1 failed"],
            id="one word for goals and statuses",
        ),
        pytest.param([LOG], [], id="nothing to tell"),
    ],
)
def test_columns_stand_below_each_other(leaves: list[LeafSummary], lines: list[str]) -> None:
    """Of leaves, with their outcomes."""
    assert leaf_table(leaves, 80, SIGNS) == lines


def test_lines_fit_the_terminal() -> None:
    """Long names are cut, and so are lines; wide characters count twice."""
    long = LeafSummary("n" * 50, "0", 1, {"succeeded": 1}, 1.0, 1.0)
    wide = LeafSummary("扉\x1b", "1", 1, {"succeeded": 1}, 1.0, 1.0)
    lines = leaf_table([long, wide], 40, SIGNS)
    assert lines[1].startswith(f"  {'n' * 27}…     1")
    assert lines[1].endswith("…")
    assert lines[2].startswith("  扉\\x1b" + " " * 27 + "1")
    assert all(line.isascii() for line in leaf_table([long, wide], 40, ASCII_SIGNS))


def test_of_many_leaves_those_that_ran_longest_are_shown() -> None:
    """In the order of their starts; how many there are besides is said."""
    many = [LeafSummary(f"leaf {n}", str(n), 1, {"success": 1}, n + 1.0, None) for n in range(50)]
    lines = leaf_table(many, 80, SIGNS)
    assert len(lines) == MOST_ROWS + 2
    assert lines[1].split()[:2] == ["leaf", "30"]
    assert lines[-1] == "  and 30 leaves that ran for less time"


def test_what_others_do_to_a_mission_is_in_the_plain_lines(play: Any) -> None:
    """Breakpoints, the pauses that they make, steps, and the end of a pause."""
    run = play("  sequence: [{log: one}, {wait: 9}]\n")
    stream = io.StringIO()
    executive = run.executive
    lines = PlainLines(stream, executive, lambda: 0, lambda: run.now_ns)
    executive.events.subscribe(
        lambda event: lines.on_change(event) if isinstance(event, NodeChanged) else None
    )
    executive.after_tick.append(lines.refresh)
    executive.breakpoints.add("wait")
    run.tick()
    executive.step()
    run.tick()
    executive.breakpoints.remove("wait")
    executive.breakpoints.add("0.0")
    executive.resume()
    run.tick()
    executive.pause("paused on request")
    run.tick()
    executive.interrupt("interrupted by Ctrl-C")
    run.tick()
    assert [line.split("s  ", 1)[1].strip() for line in stream.getvalue().splitlines()] == [
        "breakpoint set at 'wait'",
        "mission paused  breakpoint at 'wait'",
        "mission stepped",
        "> wait",
        "breakpoint set at 'log'",
        "breakpoint removed from 'wait'",
        "mission running",
        "mission paused on request",
        "- wait  8.9 s left",
    ]


def test_requirements_are_told_when_their_verdict_is_another_one() -> None:
    """What is open is no news; a violation is said by the mission, unless that was missed."""
    lines = RequirementLines()
    begun = tree()

    def lines_of(name: str, verdict: str, margin: str = "") -> list[str]:
        return list(lines.take(requirement(name, verdict, margin, time_ns=3 * S), begun))

    assert lines_of("slow", "open", "0.2") == []
    assert lines_of("slow", "violated", "-0.1") == []
    assert lines_of("late", "violated") == ["     2.00 s    requirement late: violated at 0.50 s"]
    assert lines_of("late", "violated", "-0.3") == []
    assert lines_of("ends", "holds") == ["     2.00 s    requirement ends: holds at 0.50 s"]


def test_a_tree_is_followed_by_its_requirements() -> None:
    """As `watch --once` prints it."""
    executive = ScriptedExecutive("patrol\n  go")
    executive.begin()
    executive.judge(is_slow="violated -0.1")
    lines = list(whole_tree(known(executive), SIGNS, 60))
    assert lines[-2:] == [
        "requirements",
        "  ✗ violated is slow -0.1 m/s  at 0.50 s  speed by odometry…",
    ]


def test_a_mission_that_is_joined_in_the_middle_is_shown_as_it_is() -> None:
    """The tree waits for the statuses of its nodes; from the start on it is shown at once."""
    joined, begun = ScriptedExecutive(), ScriptedExecutive()
    tree = joined.begin()
    joined.change(look_around="success: 45 deg")
    joined.change(1.0, drive="running")
    joined.forget()
    lines = FollowedLines(MissionFeed(MissionState()), SIGNS)
    assert [*lines.take(tree)] == []
    shown = [*lines.take(joined.statuses)]
    assert [line.split("  0.")[0].strip() for line in shown[1:4]] == [
        "· explore",
        "✓ look around  45 deg",
        "· repeat",
    ]
    assert [line.strip() for line in lines.take(joined.change(1.0, drive="failure: blocked"))] == [
        "2.00 s  ✗ drive  blocked"
    ]
    lines = FollowedLines(MissionFeed(MissionState()), SIGNS)
    assert [*lines.take(begun.begin())] == []
    shown = [*lines.take(begun.change(look_around="running"))]
    assert [line.strip() for line in shown[1:]] == [
        "· explore",
        "· look around",
        "· repeat",
        "· drive",
        "· turn away",
        "0.00 s  ▶ look around",
    ]
