"""What tests ask for by names that are none."""

from __future__ import annotations

from typing import Any

from bt_mission.faults.errors import ScenarioError, no_such


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
