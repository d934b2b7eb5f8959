"""Views mark a mission whose file has another text than the mission that runs."""

from __future__ import annotations

from pathlib import Path

from bt_mission.events.mission_file import CHANGED, FileCheck, MissionFile, sha256_of

TEXT = "mission: m\ntree: {wait: 1}\n"


def test_a_file_that_has_changed_is_noted_until_it_is_what_runs(tmp_path: Path) -> None:
    """A file that is gone, as on another machine, or that is no text, is not noted."""
    path, check = tmp_path / "m.yaml", FileCheck()
    running = MissionFile(str(path), sha256_of(TEXT))
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
    check.look(MissionFile(str(path), sha256_of(other)))  # it was revised
    assert check.note == ""
    check.look(None)
    assert check.note == ""
