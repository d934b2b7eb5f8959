"""A goal drawn on a terminal."""

from __future__ import annotations

import io

from bt_mission_interfaces.action import CameraSweep, ExecuteMission
from rich.console import Console

from bt_mission.graph_tools.goal_events import (
    CancelRefused,
    CancelRequested,
    FeedbackReceived,
    GoalAccepted,
    GoalEnded,
    GoalOutcome,
    GoalResult,
    ServerAwaited,
)
from bt_mission.graph_tools.goal_views import (
    GoalPicture,
    event_lines,
)
from bt_mission.graph_tools.interface_description import describe_interface

SWEEP = describe_interface("bt_mission_interfaces/action/CameraSweep")


def drawn(width: int) -> str:
    """What a terminal of this width shows, for a goal with feedback."""
    console = Console(
        file=io.StringIO(), width=width, height=24, force_terminal=True, color_system=None
    )
    picture = GoalPicture(console, SWEEP, CameraSweep.Goal(sweep_angle=90.0, image_count=4))
    picture.show(GoalAccepted("0123abcd0000"))
    feedback = CameraSweep.Feedback(current_image=1, current_angle=45.0)
    picture.show(FeedbackReceived(feedback, 3.0))
    picture.close()
    page = io.StringIO()
    Console(file=page, width=width).print(picture.picture())
    return page.getvalue()


def test_feedback_is_a_table_with_units_and_bars() -> None:
    """Towards what the goal asks for."""
    lines = [line.rstrip() for line in drawn(80).splitlines()]
    assert lines == [
        "goal 0123abcd accepted   3.0 s",
        "  current_image   1       █████░░░░░░░░░░░░░░░ of 4",
        "  current_angle  45  deg  ██████████░░░░░░░░░░ of 90",
    ]


def test_on_twenty_columns_values_come_first() -> None:
    """Nothing is wrapped."""
    lines = [line.rstrip() for line in drawn(20).splitlines()]
    assert lines == ["goal 0123abcd accep…", "  1 current_image", "  45 deg current_an…"]


def test_the_end_stays_on_the_screen() -> None:
    """With the result below it."""
    console = Console(file=io.StringIO(), width=80, force_terminal=True, color_system=None)
    picture = GoalPicture(console, SWEEP, CameraSweep.Goal())
    picture.show(ServerAwaited("/sweep"))
    picture.show(CancelRequested("because"))
    picture.show(CancelRefused())
    result = CameraSweep.Result(image_paths=[f"/a/long/path/image_{i}.png" for i in range(3)])
    end = GoalResult(GoalOutcome.CANCELED, "canceled: because", result)
    picture.show(GoalEnded(end, 2.0))
    text = console.file.getvalue()  # type: ignore[attr-defined]
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
    end = GoalEnded(GoalResult(GoalOutcome.SUCCEEDED, "succeeded", result), 1.0)
    lines = event_lines(end, about, {})
    at = lines.index("  summary            ok: success")
    assert lines[at + 1] == "                       1.00 s"
