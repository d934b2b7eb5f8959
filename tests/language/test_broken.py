"""Broken missions, each with the whole message that its author gets, kept beside it."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine

BROKEN = Path(__file__).parent / "broken"
NAMES = sorted(path.stem for path in BROKEN.glob("*.yaml"))


def message_of(file: str) -> str:
    """Return everything that is said of a mission file, as `bt-mission check` says it."""
    _, faults = examine(file)
    return "\n".join(str(fault) for fault in faults)


@pytest.mark.parametrize("name", NAMES)
def test_a_broken_mission_gets_its_located_message(name, monkeypatch):
    """The message is the expected one, to the letter: place, words, hint, line and caret."""
    monkeypatch.chdir(BROKEN)
    expected = (BROKEN / f"{name}.txt").read_text(encoding="utf-8")
    assert message_of(f"{name}.yaml") + "\n" == expected
    assert ": error: " in expected


def test_there_are_at_least_twenty():
    """The issue asks for twenty broken missions; every message stands beside its mission."""
    assert len(NAMES) >= 20
    assert sorted(path.stem for path in BROKEN.glob("*.txt")) == NAMES
