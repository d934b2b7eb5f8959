"""A behaviour that a user has written in Python, wired to the variables of a mission."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.runtime import MissionFailure, Scope


def make(
    kind: type[Behaviour],
    name: str,
    inputs: Callable[[], Mapping[str, Any]],
    outputs: Mapping[str, str],
    scope: Scope,
    place: str,
) -> Behaviour:
    """A behaviour of a user's, whose inputs are set at each entry and outputs read at each end.

    :param inputs: gives the values of attributes.
    :param outputs: attribute to variable.
    :raises MissionFailure: when its constructor raises.
    """
    try:
        leaf = kind(name)
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise MissionFailure(f"{place}: {kind.__name__}({name!r}) raised {why}") from error
    initialise, terminate = leaf.initialise, leaf.terminate

    def begin() -> None:
        for attribute, value in inputs().items():
            setattr(leaf, attribute, value)
        initialise()

    def end(new_status: Status) -> None:
        terminate(new_status)
        if new_status is not Status.INVALID:
            for attribute, variable in outputs.items():
                if not hasattr(leaf, attribute):
                    message = f"{place}: '{name}' has no attribute '{attribute}' to give"
                    raise MissionFailure(message)
                scope.values[variable] = getattr(leaf, attribute)

    leaf.initialise = begin  # type: ignore[method-assign]  # this one behaviour is wired, no class
    leaf.terminate = end  # type: ignore[method-assign]
    return leaf
