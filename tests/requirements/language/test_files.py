"""Requirements in files of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.requirements.checks import with_requirements
from bt_mission.sessions.load import load

MISSION = "mission: rest\nrequirements:\n  is slow: always speed < 1\ntree:\n  wait: 1\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "requirements:\n  is slow: always speed < 2\n",
            "'is slow' already exists",
        ),
        ("requirements:\n  a: always sped < 2\n", "unknown signal 'sped'"),
        ('requirements:\n  a: never failed("drive")\n', "unknown node: 'drive'"),
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
        with_requirements(load(MISSION), [file])
    assert any(message in fault.message for fault in refused.value.diagnostics)
    assert {fault.file for fault in refused.value.diagnostics} == {str(file)}


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    """By its name."""
    with pytest.raises(InputError, match=r"nowhere\.yaml"):
        with_requirements(load(MISSION), [tmp_path / "nowhere.yaml"])
