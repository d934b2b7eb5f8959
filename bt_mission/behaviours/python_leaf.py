"""A behaviour that a user has written in Python, wired to the variables of a mission."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.evaluator import Evaluator
from bt_mission.behaviours.runtime import MissionFailure, placed
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.plugins import find_class


def python_leaf(node: PythonNode, values: Evaluator) -> Behaviour:
    """Return a behaviour of a user's, its inputs set at each entry and outputs read at each end.

    Raises:
        MissionFailure: when it is not there, or its constructor raises.
    """
    name, place, scope = node.label, values.place, values.context.scope
    with placed(place):
        kind = find_class(node.target, values.context.file)
    try:
        leaf = kind(name)
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise MissionFailure(f"{place}: {kind.__name__}({name!r}) raised {why}") from error
    initialise, terminate = leaf.initialise, leaf.terminate

    def begin() -> None:
        for attribute, value in values.resolve(node.inputs).items():
            setattr(leaf, attribute, value)
        initialise()

    def end(new_status: Status) -> None:
        terminate(new_status)
        if new_status is not Status.INVALID:
            for attribute, variable in node.outputs.items():
                if not hasattr(leaf, attribute):
                    message = f"{place}: '{name}' has no attribute '{attribute}' to give"
                    raise MissionFailure(message)
                scope.values[variable] = getattr(leaf, attribute)

    leaf.initialise = begin  # type: ignore[method-assign]  # this one behaviour is wired, no class
    leaf.terminate = end  # type: ignore[method-assign]
    return leaf
