"""What a terminal shows while a mission runs, and what is left on it at the end."""

from __future__ import annotations

import io
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rich.console import Console

from bt_mission.views.terminal.views import LiveTree, LiveView
from tests.support.played_session import PlayedSession
from tests.support.terminal import shown_by_terminal


class Run:
    """A mission on a terminal that the test reads."""

    def __init__(self, play: Any, text: str, width: int = 100, height: int = 24) -> None:
        self.played = play(text, "mission: test\ninputs: {pace: 1}")
        self.stream = io.StringIO()
        self.console = Console(
            file=self.stream, width=width, height=height, force_terminal=True, _environ={}
        )
        self.view = LiveView(self.console)
        self.session = PlayedSession(self.played.executive)
        self.view.open(self.session)

    def end(self) -> list[str]:
        """End the view; gives what is left on the terminal, without the header's figures."""
        self.view.close()
        rows = shown_by_terminal(self.stream.getvalue())
        return [row.split("   ")[0] if "x real time" in row else row for row in rows if row]


@pytest.fixture
def run(play: Any) -> Any:
    """Begin a run: of this tree, on a terminal of this size."""

    def begin(text: str, **size: int) -> Run:
        return Run(play, text, **size)

    return begin


def test_all_that_a_mission_says_scrolls_by_above_the_tree(run: Any) -> None:
    """Also more than fits beside it, and nothing twice."""
    begun = run("  wait: 1\n")
    begun.view.refresh()
    for number in range(6):
        begun.session.say(begun.view, f"line {number}")
    assert begun.end() == [
        *(f"     2.00 s    line {number}" for number in range(6)),
        "test (waffle, seed 0)",
        "· wait",
    ]


def test_several_lines_are_said_in_as_many(run: Any) -> None:
    """Without what would move the cursor."""
    begun = run("  wait: 1\n")
    begun.session.say(begun.view, "one\ntwo\x1b[2A")
    assert begun.end()[:2] == ["     2.00 s    one", "     2.00 s    two\\x1b[2A"]


BOTH_FAIL = """\
  retry: {attempts: 2}
  do:
    fallback:
      - {check: pace > 2, name: quick look}
      - {turn: {angle: 90}, name: first way, timeout: 30}
      - {turn: {angle: 180}, name: second way, timeout: 30}
"""


def fail_all(played: Any) -> None:
    """Have every goal rejected, until the mission has failed."""
    while not played.executive.is_done:
        played.tick()
        played.turn.reject()


def test_the_last_frame_tells_why_each_node_has_failed(run: Any) -> None:
    """Also of those that py_trees has reset since: a fallback resets what it went on from."""
    begun = run(BOTH_FAIL)
    fail_all(begun.played)
    assert begun.end()[1:] == [
        "✗ test  attempt 2 of 2",
        "  ✗ fallback",
        "    ✗ quick look  does not hold (pace = 1)",
        "    ✗ first way  rejected: /turn: its server gave no reason",
        "    ✗ second way  rejected: /turn: its server gave no reason",
    ]


def test_on_a_low_terminal_the_path_to_the_failure_stays_in_sight(run: Any) -> None:
    """Rows that are not on it give way."""
    begun = run(BOTH_FAIL, height=6)
    fail_all(begun.played)
    assert [row.split()[1] for row in begun.end()[1:]] == ["test", "fallback", "second"]


def test_what_ran_at_ctrl_c_is_shown_as_it_was(run: Any) -> None:
    """With what it did; what had ended, too."""
    begun = run(
        "  sequence:\n"
        "    - {log: hello, name: greet}\n"
        "    - parallel:\n"
        "        - {turn: {angle: 90}, name: left, cancel_when: current_angle >= 60, timeout: 9}\n"
        "        - {wait: 5}\n"
    )
    begun.played.tick()
    begun.played.turn.accept()
    begun.played.turn.feed(Turn.Feedback(current_angle=15.0, remaining_angle=75.0))
    begun.played.tick()
    begun.played.executive.interrupt("interrupted by Ctrl-C")
    begun.played.tick()
    begun.played.turn.cancel()
    begun.played.tick()
    assert begun.end() == [
        "test (waffle, seed 0)",
        "▶ test",
        "  ✓ greet  hello",
        "  ▶ parallel",
        "    ▶ left  ███░░░░░░░░░ 15 of 60  current_angle 15.00, remaining_angle 75.00",
        "    ▶ wait  ░░░░░░░░░░░░ 0.0 of 5 s  5.0 s left",
    ]


def test_the_round_that_was_interrupted_is_named(run: Any) -> None:
    """A node that runs on says other things than when it began to run."""
    begun = run("  repeat: {count: 9}\n  do: {wait: 0.1}\n")
    begun.played.tick(8)
    shown = begun.played.executive.root.feedback_message
    assert shown not in ("", "1 of 9")
    begun.played.executive.interrupt("interrupted by Ctrl-C")
    begun.played.tick()
    assert begun.end()[1] == f"▶ test  {shown}"


def test_on_a_narrow_terminal_the_header_says_how_it_goes(run: Any) -> None:
    """Rather than in which world, with which robot and seed."""
    begun = run("  wait: 1\n", width=30)
    begun.played.tick()
    begun.view.close()
    rows = shown_by_terminal(begun.stream.getvalue())
    assert rows[0] == "test   2.00 s   running"


def test_a_node_that_is_to_run_once_more_has_not_run_yet(run: Any) -> None:
    """Each round of a repeat begins with a clean sheet."""
    begun = run(
        "  repeat: {count: 2}\n  do:\n    sequence:\n      - {wait: 0.1, name: a}\n"
        "      - {wait: 0.1, name: b}\n"
    )
    signs = []
    for _ in range(7):
        begun.played.tick()
        tree = LiveTree(begun.console, begun.played.executive, lambda: "")
        with begun.console.capture() as capture:
            begun.console.print(tree.render())
        rows = shown_by_terminal(capture.get())
        signs.append("".join(row.strip()[0] for row in rows if row.split()[1:2] in (["a"], ["b"])))
    assert signs == ["▶·", "▶·", "✓▶", "✓▶", "✓✓", "▶·", "▶·"]
