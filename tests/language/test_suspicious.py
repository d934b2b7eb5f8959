"""Missions that are valid but suspicious, each with the warnings that its author gets beside it."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine
from tests.support.transcripts import assert_written

SUSPICIOUS = Path(__file__).parent / "suspicious"
NAMES = sorted(path.stem for path in SUSPICIOUS.glob("*.yaml"))


@pytest.mark.parametrize("name", NAMES)
def test_a_suspicious_mission_runs_with_its_warnings(name, monkeypatch):
    """The warnings are the expected ones; none of them is an error."""
    monkeypatch.chdir(SUSPICIOUS)
    mission, diagnostics = examine(f"{name}.yaml")
    assert mission is not None
    assert {each.severity for each in diagnostics} == {"warning"}
    assert_written(SUSPICIOUS / f"{name}.txt", "\n".join(map(str, diagnostics)) + "\n")
