"""Missions with errors or only with warnings, each with all that its author gets beside it."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine
from tests.support.transcripts import assert_written

HERE = Path(__file__).parent
FILES = sorted(HERE.glob("broken/*.yaml")) + sorted(HERE.glob("suspicious/*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_mission_gets_its_located_diagnostics(path, monkeypatch):
    """All of it is as expected: place, words, hint, code, line and caret; warnings stop nothing."""
    monkeypatch.chdir(path.parent)
    mission, diagnostics = examine(path.name)
    severities = {each.severity for each in diagnostics}
    assert (mission is None, "error" in severities) == (path.parent.name == "broken",) * 2
    assert severities
    assert_written(path.with_suffix(".txt"), "\n".join(map(str, diagnostics)) + "\n")


def test_every_text_belongs_to_a_mission():
    """Nothing is left of missions that are gone."""
    texts = sorted(HERE.glob("broken/*.txt")) + sorted(HERE.glob("suspicious/*.txt"))
    assert texts == [path.with_suffix(".txt") for path in FILES]
