"""Broken missions, each with the whole message that its author gets, kept beside it."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine
from tests.support.transcripts import assert_written

BROKEN = Path(__file__).parent / "broken"
NAMES = sorted(path.stem for path in BROKEN.glob("*.yaml"))


def message_of(file: str) -> str:
    """Return all diagnostics of a mission file as `bt-mission check` prints them."""
    _, diagnostics = examine(file)
    return "\n".join(map(str, diagnostics))


@pytest.mark.parametrize("name", NAMES)
def test_a_broken_mission_gets_its_located_message(name, monkeypatch):
    """The whole message is the expected one: place, words, hint, code, line and caret."""
    monkeypatch.chdir(BROKEN)
    actual = message_of(f"{name}.yaml") + "\n"
    assert ": error: " in actual
    assert_written(BROKEN / f"{name}.txt", actual)


def test_there_are_at_least_twenty():
    """The issue asks for twenty broken missions; every message stands beside its mission."""
    assert len(NAMES) >= 20
    assert sorted(path.stem for path in BROKEN.glob("*.txt")) == NAMES
