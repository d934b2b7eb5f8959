"""A watched tree as rows of text."""

from __future__ import annotations

import pytest

from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.views.terminal.lines import log_line, whole_tree
from bt_mission.views.terminal.marks import (
    ASCII_SIGNS,
    SIGNS,
    clean,
    fit,
    marks_for,
    stopwatch,
    text_of,
)
from bt_mission.views.terminal.tree_rows import Outline, tree_row
from tests.support.watched import S, ScriptedExecutive, known


@pytest.fixture
def mission() -> MissionState:
    """Half way through driving, with a breakpoint at the turn."""
    executive = ScriptedExecutive()
    executive.begin()
    executive.change(explore="running", look_around="running")
    executive.change(8.4, look_around="success: canceled by condition: enough", repeat="running")
    executive.change(drive="running")
    executive.now_ns += S
    progress = executive.progress("drive", 1.208, 2.0, "travelled 1.21")
    executive.detail(2.5, running=(progress,), breakpoints=("turn away",))
    return known(executive)


def test_a_tree_reads_without_colour(mission: MissionState):
    """Status, name, time in state, progress, words; a mark for the breakpoint."""
    assert list(whole_tree(mission, SIGNS, 100)) == [
        "explore   11.90 s   running",
        " ▶ explore  11.90 s",
        "   ✓ look around  8.40 s  canceled by condition: enough",
        "   ▶ repeat  3.50 s",
        "     ▶ drive  2.50 s  ███████░░░░░ 1.21 of 2  travelled 1.21",
        "●    · turn away",
    ]


def test_it_reads_without_utf_8(mission: MissionState):
    """Other signs, the same facts."""
    lines = list(whole_tree(mission, ASCII_SIGNS, None))
    assert lines[2] == "   + look around  8.40 s  canceled by condition: enough"
    assert lines[4] == "     > drive  2.50 s  #######..... 1.21 of 2  travelled 1.21"
    assert lines[5] == "*    - turn away"
    assert all(line.isascii() for line in lines)


@pytest.mark.parametrize("width", [5, 20, 40])
def test_no_row_is_wider_than_the_terminal(mission: MissionState, width: int):
    """What does not fit is cut, with a sign."""
    lines = list(whole_tree(mission, SIGNS, width))[1:]
    assert max(len(line) for line in lines) <= width
    assert lines[1].endswith("…")


def test_bars_give_way_to_figures_and_those_to_percent(mission: MissionState):
    """The less room, the less there is to read; the indent shrinks, too."""
    assert (
        list(whole_tree(mission, SIGNS, 45))[4] == "     ▶ drive  2.50 s  1.21 of 2  travelled 1…"
    )
    assert list(whole_tree(mission, SIGNS, 20))[4] == "   ▶ drive 60%  tra…"


def test_a_folded_node_says_how_much_it_hides(mission: MissionState):
    """In brackets after its name."""
    assert mission.tree is not None
    outline = Outline(mission.tree.nodes)
    outline.fold(2)
    assert text_of(tree_row(mission, outline, 2, 80, SIGNS)) == "   ▶ repeat [+2]  3.50 s"


def test_a_tree_of_two_thousand_levels_is_arranged() -> None:
    """Without recursion; the indent of a row ends at a third of the width."""
    executive = ScriptedExecutive("\n".join("  " * i + f"n{i}" for i in range(2_000)))
    executive.begin()
    deep = known(executive)
    assert deep.tree is not None
    outline = Outline(deep.tree.nodes)
    row = text_of(tree_row(deep, outline, 1_999, 30, SIGNS))
    assert row == " " * 11 + "· n1999"
    outline.fold(1_999)  # a leaf does not fold
    for top in (10, 5):  # a fold within another one
        outline.fold(top)
        assert (len(outline.rows), outline.row_of(1_999)) == (top + 1, top)
    assert outline.reveal(8) == 8
    assert outline.folded == {10}


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("drive", "drive"),
        ("\x1b[31mred\x07", "\\x1b[31mred\\x07"),
        ("a\nb", "a\\nb"),
        ("\u202eesrever", "\\u202eesrever"),
        ("\x9b2J", "\\x9b2J"),
        ("größer 走", "größer 走"),
    ],
)
def test_names_with_control_characters_move_nothing(text: str, shown: str):
    """They are shown as their codes."""
    assert clean(text, SIGNS) == shown
    assert clean(text, ASCII_SIGNS).isascii()


def test_wide_characters_count_twice():
    """A row of Chinese names is cut where the terminal ends, too."""
    assert fit([("走走走", "")], 5, SIGNS) == [("走走…", "")]
    assert fit([("ab", ""), ("cd", "")], 2, SIGNS) == [("a…", "")]


@pytest.mark.parametrize(
    ("time_s", "shown"),
    [(0, "0.00 s"), (8.44, "8.44 s"), (59.99, "59.99 s"), (59.996, "1:00"), (3725, "1:02:05")],
)
def test_durations(time_s: float, shown: str):
    """As `run` has them, below a minute."""
    assert stopwatch(round(time_s * S)) == shown


def test_lines_of_the_log_have_the_time_since_the_start():
    """As the plain lines of a run have."""
    assert log_line(LogEntry(3 * S, None, "", "hello"), S, SIGNS) == "     2.00 s    hello"


def test_signs_are_chosen_by_the_encoding():
    """A stream without one has ASCII."""
    assert marks_for("utf-8") is SIGNS
    assert marks_for("ascii") is marks_for(None) is marks_for("latin-1") is ASCII_SIGNS
