"""A mission that is watched, without a view: its pace, and what may be asked of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.executive.events.mission_file import CHANGED, FileCheck, MissionOrigin, sha256_of
from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.executive.events.watched_mission import (
    RealTimeFactor,
    WatchedMission,
    possible_verbs,
)
from tests.support.watched import S, ScriptedExecutive


def test_the_factor_is_taken_over_the_last_seconds():
    """A mission that has become faster is soon shown as such."""
    pace = RealTimeFactor()
    assert pace.factor is None
    for tenth in range(101):
        pace.note(tenth * S, tenth / 10)
    assert pace.factor == pytest.approx(10.0)
    for tenth in range(1, 101):
        pace.note(100 * S + tenth * 2 * S, 10 + tenth / 10)
    assert pace.factor == pytest.approx(20.0)


def test_time_that_begins_anew_is_no_backwards_pace():
    """The simulation was started again."""
    pace = RealTimeFactor()
    pace.note(50 * S, 0.0)
    pace.note(51 * S, 1.0)
    pace.note(1 * S, 2.0)
    assert pace.factor is None
    pace.note(2 * S, 3.0)
    assert pace.factor == pytest.approx(1.0)


def test_a_breakpoint_is_set_where_there_is_a_node():
    """And nowhere else."""
    executive, watched = ScriptedExecutive(), WatchedMission()
    assert watched.toggled_breakpoint(0) is None
    executive.begin()
    assert watched.take(executive.take(needs_statuses=True), 0.0)
    assert watched.toggled_breakpoint(3) == ControlRequest(Verb.BREAK, "0.1.0")
    assert watched.toggled_breakpoint(99) is None


@pytest.mark.parametrize(
    ("status", "verbs"),
    [
        ("", ()),
        ("success", ()),
        ("interrupted", ()),
        ("paused", (Verb.RESUME, Verb.STEP, Verb.STOP, Verb.BREAK)),
        ("running", (Verb.PAUSE, Verb.PAUSE_KEEPING_GOALS, Verb.STOP, Verb.BREAK)),
    ],
)
def test_what_may_be_asked_follows_from_the_state(status: str, verbs: tuple[Verb, ...]):
    """Nothing of a mission that has ended, or is not there."""
    assert possible_verbs(status) == verbs


TEXT = "mission: m\ntree: {wait: 1}\n"


def test_a_file_that_has_changed_is_noted_until_it_is_what_runs(tmp_path: Path) -> None:
    """A file that is gone, as on another machine, or that is no text, is not noted."""
    path, check = tmp_path / "m.yaml", FileCheck()
    running = MissionOrigin(str(path), sha256_of(TEXT))
    notes = []
    for text in (None, TEXT, TEXT + "# more\n", "other", TEXT):
        path.unlink(missing_ok=True)
        if text is not None:
            path.write_text(text)
        check.look(running)
        notes.append(check.note)
    assert notes == ["", "", CHANGED, CHANGED, ""]
    path.write_bytes(b"\xff")
    check.look(running)
    assert check.note == ""
    path.write_text(other := "mission: other")
    check.look(running)
    assert check.note == CHANGED
    check.look(MissionOrigin(str(path), sha256_of(other)))  # it was revised
    assert check.note == ""
    check.look(None)
    assert check.note == ""
