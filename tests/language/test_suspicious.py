"""Missions that are valid but suspicious, each with the warnings that its author gets beside it."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine

SUSPICIOUS = Path(__file__).parent / "suspicious"
NAMES = sorted(path.stem for path in SUSPICIOUS.glob("*.yaml"))


@pytest.mark.parametrize("name", NAMES)
def test_a_suspicious_mission_runs_with_its_warnings(name, monkeypatch):
    """The warnings are the expected ones, to the letter; none of them is an error."""
    monkeypatch.chdir(SUSPICIOUS)
    mission, faults = examine(f"{name}.yaml")
    assert mission is not None
    output = "\n".join(str(fault) for fault in faults)
    assert output + "\n" == (SUSPICIOUS / f"{name}.txt").read_text(encoding="utf-8")
    assert {fault.severity for fault in faults} == {"warning"}
