"""A behaviour that a user has written in Python, wired to the variables of a mission."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours import snapshot
from bt_mission.behaviours.evaluator import Evaluator
from bt_mission.behaviours.hooks import Hooked
from bt_mission.behaviours.runtime import MissionFailure, placed
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.plugins import find_class

RUNNING, INVALID = Status.RUNNING, Status.INVALID


class PythonLeaf(Hooked):
    """Stands in the tree for a user's behaviour: its name, status, message and attributes are.

    Inputs are set at each entry, outputs read at each end. A behaviour with children has them in
    the tree as well.

    Raises:
        MissionFailure: When the class is not there, or its constructor raises.
    """

    def __init__(self, node: PythonNode, values: Evaluator) -> None:
        self.behaviour = _made(node, values)
        message = self.behaviour.feedback_message
        super().__init__(self.behaviour.name)
        self.feedback_message = message
        self.children = self.behaviour.children
        for child in self.children:
            child.parent = self
        self._values = values

    @property
    def _node(self) -> Any:
        """As it is written now: it may be revised while the mission runs."""
        return self._values.node

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["behaviour"], name)

    @property
    def status(self) -> Status:
        """Of the user's behaviour."""
        return self.behaviour.status

    @status.setter
    def status(self, status: Status) -> None:
        self.behaviour.status = status

    @property
    def feedback_message(self) -> str:
        """Of the user's behaviour."""
        return self.behaviour.feedback_message

    @feedback_message.setter
    def feedback_message(self, message: str) -> None:
        self.behaviour.feedback_message = message

    def setup(self, **kwargs: Any) -> None:
        """Hand the runtime on."""
        self.behaviour.parent = self.parent
        self.behaviour.setup(**kwargs)

    def walk(self) -> Iterator[Behaviour]:
        """Set the inputs at entry; tick; read the outputs at the end."""
        ours = self.behaviour
        if ours.status is not RUNNING:
            self.tell_call_hooks("initialise")
            for attribute, value in self._values.resolve(self._node.inputs).items():
                setattr(ours, attribute, value)
        self.tell_call_hooks("update")
        for node in ours.tick():
            if node is not ours:
                yield node
        if ours.status is not RUNNING:
            try:
                self.tell_call_hooks("terminate")
                self._read_outputs()
            except Exception:
                ours.stop(INVALID)
                raise
        yield self

    def update(self) -> Status:
        """Return what the user's behaviour has come to; :meth:`walk` ticks it."""
        return self.status

    def stop(self, new_status: Status) -> None:
        """Halt the user's behaviour."""
        self.tell_call_hooks("terminate")
        self.behaviour.stop(new_status)

    def tip(self) -> Behaviour | None:
        """Return the deepest node that was ticked."""
        tip = self.behaviour.tip()
        return self if tip is self.behaviour else tip

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """What the user's behaviour remembers."""
        return snapshot.save(self.behaviour, now_ns)

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Put it where it stood; if it says nothing of that, it starts anew."""
        self.status = INVALID
        snapshot.load(self.behaviour, RUNNING, state, now_ns)

    def _read_outputs(self) -> None:
        if self.status is INVALID:
            return
        for attribute, variable in self._node.outputs.items():
            if not hasattr(self.behaviour, attribute):
                place, name = self._values.place, self._node.label
                message = f"{place}: '{name}' has no attribute '{attribute}' to give"
                raise MissionFailure(message)
            self._values.context.scope.values[variable] = getattr(self.behaviour, attribute)


def _made(node: PythonNode, values: Evaluator) -> Behaviour:
    with placed(values.place):
        kind = find_class(node.target, values.context.file)
    try:
        return kind(node.label)
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise MissionFailure(
            f"{values.place}: {kind.__name__}({node.label!r}) raised {why}"
        ) from error
