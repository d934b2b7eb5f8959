"""A goal drawn on a terminal, and the views for other outputs."""

from __future__ import annotations

import io
from typing import Any

import pytest
from bt_mission_interfaces.action import CameraSweep, ExecuteMission, Turn
from rich.console import Console

from bt_mission.commands.graph import goal_events, goal_views
from bt_mission.commands.graph.interface_description import describe_interface

SWEEP = describe_interface("bt_mission_interfaces/action/CameraSweep")
TURN = describe_interface("bt_mission_interfaces/action/Turn")


def terminal(page: io.StringIO, width: int) -> Console:
    """A terminal of a width."""
    return Console(file=page, width=width, height=24, force_terminal=True, color_system=None)


@pytest.mark.parametrize(
    ("width", "shown"),
    [
        (
            80,
            [
                "goal 0123abcd accepted   3.0 s",
                "  current_image   1       █████░░░░░░░░░░░░░░░ of 4",
                "  current_angle  45  deg  ██████████░░░░░░░░░░ of 90",
            ],
        ),
        (20, ["goal 0123abcd accep…", "  1 current_image", "  45 deg current_an…"]),
    ],
)
def test_feedback_is_a_table_with_units_and_bars(width: int, shown: list[str]) -> None:
    """Towards what the goal asks for; where there is no room, values come first."""
    goal = CameraSweep.Goal(sweep_angle=90.0, image_count=4)
    picture = goal_views.GoalPicture(terminal(io.StringIO(), width), SWEEP, goal)
    picture.show(goal_events.GoalAccepted("0123abcd0000"))
    feedback = CameraSweep.Feedback(current_image=1, current_angle=45.0)
    picture.show(goal_events.FeedbackReceived(feedback, 3.0))
    picture.close()
    page = io.StringIO()
    Console(file=page, width=width).print(picture.picture())
    assert [line.rstrip() for line in page.getvalue().splitlines()] == shown


def test_the_end_stays_on_the_screen() -> None:
    """With the result below it."""
    page = io.StringIO()
    picture = goal_views.GoalPicture(terminal(page, 80), SWEEP, CameraSweep.Goal())
    picture.show(goal_events.ServerAwaited("/sweep"))
    picture.show(goal_events.CancelRequested("because"))
    picture.show(goal_events.CancelRefused())
    result = CameraSweep.Result(image_paths=[f"/a/long/path/image_{i}.png" for i in range(3)])
    canceled = goal_events.GoalOutcome.CANCELED
    end = goal_events.GoalResult(canceled, "canceled: because", result)
    picture.show(goal_events.GoalEnded(end, 2.0))
    text = page.getvalue()
    assert "waiting for a server of /sweep" in text
    assert "the server refused to cancel; asking again each second" in text
    assert [line.rstrip() for line in text.splitlines()][-7:] == [
        "  image_path   ''",
        "  image_paths",
        "    /a/long/path/image_0.png",
        "    /a/long/path/image_1.png",
        "    /a/long/path/image_2.png",
        "  error_code   0  (NONE)",
        "  error_msg    ''",
    ]


def test_a_text_of_several_lines_is_shown_in_as_many() -> None:
    """Such as the summary of a mission."""
    about = describe_interface("bt_mission_interfaces/action/ExecuteMission")
    result = ExecuteMission.Result(summary="ok: success\n  1.00 s", status="success")
    end = goal_events.GoalEnded(
        goal_events.GoalResult(goal_events.GoalOutcome.SUCCEEDED, "succeeded", result), 1.0
    )
    lines = goal_views.event_lines(end, about, {})
    at = lines.index("  summary            ok: success")
    assert lines[at + 1] == "                       1.00 s"


def test_on_a_terminal_feedback_is_drawn_in_place() -> None:
    """States stay above it; a goal that has ended takes its feedback with it."""
    page = io.StringIO()
    view = goal_views.GoalPicture(terminal(page, 80), TURN)
    view.show(goal_events.GoalStateChanged("0123456789", 0.0, "executing", is_end=False))
    view.show(goal_events.FeedbackReceived(Turn.Feedback(current_angle=4.0), 0.5, "0123456789"))
    length = len(page.getvalue())
    view.show(goal_events.GoalStateChanged("0123456789", 1.0, "succeeded", is_end=True))
    view.close()
    text = page.getvalue()
    assert "01234567      0.00 s  executing" in text
    assert "01234567      0.50 s  current_angle 4 deg, remaining_angle 0 deg" in text
    assert "01234567      1.00 s  succeeded" in text[length:]
    assert "current_angle" not in text[length:]


@pytest.mark.parametrize(
    ("is_tty", "term", "json", "kind"),
    [
        (False, "xterm", True, goal_views.GoalObjects),
        (False, "xterm", False, goal_views.GoalLines),
        (True, "dumb", False, goal_views.GoalLines),
        (True, "xterm", False, goal_views.GoalPicture),
    ],
)
def test_what_is_shown_fits_the_output(
    monkeypatch: pytest.MonkeyPatch, is_tty: Any, term: str, json: Any, kind: type
) -> None:
    """In place on a terminal, lines in a pipe and on a dumb terminal, objects for programs."""
    monkeypatch.setenv("TERM", term)
    output = io.StringIO()
    monkeypatch.setattr(output, "isatty", lambda: is_tty)
    view = goal_views.goal_view_for(output, TURN, json=json, plain=False)
    view.close()
    assert isinstance(view, kind)
