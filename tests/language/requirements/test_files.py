"""Requirements in files of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.language.checks.requirements import with_requirements
from bt_mission.language.loader import load_text
from bt_mission.sessions.load import convert

MISSION = "mission: rest\nrequirements:\n  is slow: always speed < 1\ntree:\n  wait: 1\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "requirements:\n  is slow: always speed < 2\n",
            "a requirement 'is slow' already",
        ),
        ("requirements:\n  a: always sped < 2\n", "unknown signal 'sped'"),
        ('requirements:\n  a: never failed("drive")\n', "no node is named 'drive'"),
        ("a: always speed < 2\n", "unknown key 'a'"),
        ("- always speed < 2\n", "expected a mapping"),
        ("", "the file is empty"),
    ],
)
def test_a_fault_in_such_a_file_has_its_place(tmp_path: Path, text: str, message: str) -> None:
    """It names that file, not the mission's."""
    file = tmp_path / "extra.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as refused:
        with_requirements(load_text(MISSION), [file])
    assert any(message in fault.message for fault in refused.value.faults)
    assert {fault.file for fault in refused.value.faults} == {str(file)}


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    """By its name."""
    with pytest.raises(InputError, match=r"nowhere\.yaml"):
        with_requirements(load_text(MISSION), [tmp_path / "nowhere.yaml"])


def test_xml_refuses_what_it_cannot_keep(tmp_path: Path) -> None:
    """With the place, and what to do."""
    file = tmp_path / "rest.yaml"
    file.write_text(MISSION)
    with pytest.raises(InputError) as refused:
        convert(file)
    (fault,) = refused.value.faults
    assert (fault.line, fault.message) == (3, "the requirement 'is slow': XML has no counterpart")
    assert "--require" in (fault.hint or "")
