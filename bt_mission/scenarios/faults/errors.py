"""Errors for mistakes in a test or a scenario."""

from __future__ import annotations

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.errors import BtMissionError


class ScenarioError(BtMissionError):
    """A test or a scenario asks for something that is not there."""

    code = "BT-904"


def no_such(what: str, name: str, valid: list[str]) -> ScenarioError:
    """Return the error for an unknown name, with the known ones."""
    near = did_you_mean(name, valid)
    hint = f"; {near}" if near else ""
    return ScenarioError(f"unknown {what} '{name}' (known: {listed(valid)}){hint}")
