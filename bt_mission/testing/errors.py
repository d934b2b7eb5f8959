"""What goes wrong by a mistake of a test."""

from __future__ import annotations

from typing import Any

from bt_mission.core.diagnostics import did_you_mean, listed
from bt_mission.core.errors import BtMissionError


class ScenarioError(BtMissionError):
    """A test asks for something that is not there."""


class UnknownVariableError(ScenarioError, KeyError):
    """A test asks for a variable that the mission does not have, or not yet."""

    def __str__(self) -> str:
        """Return the message as it is; KeyError would quote it."""
        return str(self.args[0])


class RunVariables(dict[str, Any]):
    """The variables of a mission; an unknown name is an error that tells those that are there."""

    def __missing__(self, name: str) -> Any:
        raise UnknownVariableError(*no_such("variable", name, sorted(self)).args)


class RequirementResults(dict[str, Any]):
    """What requirements came to; an unknown name is an error that tells those that there are."""

    def __missing__(self, name: str) -> Any:
        raise no_such("requirement", name, list(self))


def no_such(what: str, name: str, valid: list[str]) -> ScenarioError:
    """The error for a name that is none, with those that are."""
    near = did_you_mean(name, valid)
    hint = f"; {near}" if near else ""
    return ScenarioError(f"there is no {what} '{name}', but: {listed(valid)}{hint}")
