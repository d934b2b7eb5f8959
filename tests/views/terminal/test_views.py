"""The live tree fits its terminal, and can be read without colour and without UTF-8."""

from __future__ import annotations

import io
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rich.console import Console

from bt_mission.views.terminal.views import LiveTree, LiveView, PlainView
from tests.support.played_session import PlayedSession

TREE = """\
  sequence:
    - {log: hello, name: greet}
    - turn: {angle: 90}
      name: turn left
      timeout: 10
      cancel_when: current_angle >= 45
    - {wait: 1, name: rest}
"""


@pytest.fixture
def picture(play: Any) -> Any:
    """Play up to some feedback; gives the lines of the picture on a terminal of this size."""

    def draw(current: float, width: int = 80, height: int = 24, encoding: str = "utf-8") -> Any:
        run = play(TREE)
        run.tick()
        run.turn.accept()
        run.turn.feed(Turn.Feedback(current_angle=current, remaining_angle=90 - current))
        run.tick()
        stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        console = Console(file=stream, width=width, height=height, color_system=None)
        with console.capture() as capture:
            console.print(LiveTree(console, run.executive, lambda: "test   0.1 s").render())
        return capture.get().rstrip("\n").split("\n")

    return draw


def test_status_progress_and_feedback_stand_in_one_line(picture: Any) -> None:
    """What is done, what runs and how far, what is still to come."""
    assert [line.rstrip() for line in picture(15.0, width=100)] == [
        "test   0.1 s",
        "▶ test",
        "  ✓ greet  hello",
        "  ▶ turn left  ████░░░░░░░░ 15 of 45  current_angle 15.00, remaining_angle 75.00",
        "  · rest",
    ]


def test_without_utf_8_it_is_drawn_in_ascii(picture: Any) -> None:
    """Other signs, the same facts."""
    lines = picture(45.0, encoding="ascii")
    assert lines[2].startswith("  + greet")
    assert "############ 45 of 45" in lines[3]
    assert lines[4].rstrip() == "  - rest"


@pytest.mark.parametrize("width", [20, 40, 80])
def test_no_line_is_wider_than_the_terminal(picture: Any, width: int) -> None:
    """What does not fit is cut, not wrapped."""
    lines = picture(15.0, width=width)
    assert len(lines) == 5
    assert max(len(line) for line in lines) <= width


def test_on_a_low_terminal_the_running_leaf_stays_in_sight(picture: Any) -> None:
    """Rows above it give way."""
    lines = picture(15.0, height=5)
    assert len(lines) == 3
    assert any("turn left" in line for line in lines)


def test_feedback_that_is_no_number_has_no_bar(picture: Any) -> None:
    """A NaN must not end what shows it."""
    assert "of 45" not in picture(float("nan"))[3]


def paused_with_a_goal(play: Any) -> Any:
    """A session that is paused while its goal is under way."""
    run = play("  turn: {angle: 90}\n")
    run.tick()
    run.turn.accept()
    run.executive.pause("by hand", keep_goals=True)
    session = PlayedSession(run.executive, world="arena")
    return session, run


def test_the_title_names_the_world_of_the_run(play: Any) -> None:
    """Not that of the mission's file, which another one may replace."""
    stream = io.StringIO()
    PlainView(stream).open(paused_with_a_goal(play)[0])
    assert stream.getvalue() == "test in arena (waffle, seed 0)\n"


def test_where_no_world_is_simulated_none_is_named(play: Any) -> None:
    """An attached mission drives wherever the robot is."""
    stream = io.StringIO()
    session, _ = paused_with_a_goal(play)
    session.world = None
    PlainView(stream).open(session)
    assert stream.getvalue() == "test (waffle, seed 0)\n"


def test_a_pause_is_in_the_plain_lines_with_what_is_under_way(play: Any) -> None:
    """A line for each change of it, and one for its end."""
    stream = io.StringIO()
    session, run = paused_with_a_goal(play)
    view = PlainView(stream)
    view.open(session)
    view.refresh()
    view.refresh()
    run.turn.succeed()
    run.tick()
    view.refresh()
    session.executive.resume()
    view.refresh()
    assert [line.strip() for line in stream.getvalue().splitlines()[1:]] == [
        "2.00 s    mission paused  by hand; still running: 'turn'",
        "2.00 s    mission paused  by hand",
        "2.00 s    mission running",
    ]


def test_a_pause_is_above_the_live_tree_with_what_is_under_way(play: Any) -> None:
    """Instead of the state."""
    console = Console(file=io.StringIO(), width=120, force_terminal=True)
    view = LiveView(console)
    view.open(paused_with_a_goal(play)[0])
    view.refresh()
    view.close()
    drawn = console.file.getvalue()  # type: ignore[attr-defined]  # a StringIO
    assert "paused: by hand; still running: 'turn'" in drawn
