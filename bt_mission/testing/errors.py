"""Errors for unknown names in tests."""

from __future__ import annotations

from typing import Any

from bt_mission.scenarios.faults.errors import ScenarioError, no_such


class UnknownVariableError(ScenarioError, KeyError):
    """A test asks for a variable that the mission does not have, or not yet."""

    def __str__(self) -> str:
        """Return the message as it is; KeyError would quote it."""
        return str(self.args[0])


class RunVariables(dict[str, Any]):
    """The variables of a mission; an unknown name is an error with the known ones."""

    def __missing__(self, name: str) -> Any:
        raise UnknownVariableError(*no_such("variable", name, sorted(self)).args)


class RequirementResults(dict[str, Any]):
    """The verdicts of requirements; an unknown name is an error with the known ones."""

    def __missing__(self, name: str) -> Any:
        raise no_such("requirement", name, list(self))
