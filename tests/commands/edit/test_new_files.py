"""The texts with which new files begin."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.files import kind_of_text
from bt_mission.commands.edit.checks import check_text
from bt_mission.commands.edit.new_files import NEW_FILES

KINDS = ("mission", "mission", "scenario", "requirements", "fleet", "world")


@pytest.mark.parametrize(("name", "kind"), list(zip(NEW_FILES, KINDS, strict=True)))
def test_a_new_file_is_valid(name: str, kind: str, tmp_path: Path) -> None:
    """Each is a file of its kind, without an error or a warning."""
    text = NEW_FILES[name]
    assert kind_of_text(text) == kind
    assert check_text(text, tmp_path / "new.yaml", kind_of_text(text), tmp_path) == ()


def test_a_file_of_trees_needs_no_mission(tmp_path: Path) -> None:
    """Its nodes are checked as those of a mission."""
    wrong = "trees:\n  turn_round:\n    do:\n      turn: {angle: [1]}\n"
    codes = [each.code for each in check_text(wrong, tmp_path / "trees.yaml", "mission", tmp_path)]
    assert codes == ["BT-503"]
