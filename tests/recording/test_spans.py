"""When nodes ran, out of changes."""

from __future__ import annotations

from bt_mission.recording.model import RecordedChange, Span
from bt_mission.recording.spans import spans_of


def test_a_node_runs_from_its_start_to_its_end() -> None:
    """Again and again; one that ends at once has run for no time."""
    changes = [
        RecordedChange(1, 0, "running", ""),
        RecordedChange(1, 1, "success", "at once"),
        RecordedChange(3, 1, "running", "go"),
        RecordedChange(5, 1, "halted", ""),
        RecordedChange(6, 0, "failure", "no"),
    ]
    assert spans_of(3, changes, 9) == (
        (Span(1, 6, "failure", "no"),),
        (Span(1, 1, "success", "at once"), Span(3, 5, "halted", "")),
        (),
    )


def test_a_node_that_has_not_ended_runs_to_the_end_of_the_recording() -> None:
    """And says what it said when it started."""
    assert spans_of(1, [RecordedChange(2, 0, "running", "go")], 9) == (
        (Span(2, 9, "running", "go"),),
    )
