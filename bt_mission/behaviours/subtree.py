"""A named tree in its place: variables of its own, filled at entry and handed out at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.hooks import HookedDecorator
from bt_mission.behaviours.runtime import Scope


class Subtree(HookedDecorator):
    """Runs the tree below it with variables of its own, and ends as that does.

    Outputs go to the caller when the tree has ended, with success or failure, if it has written
    them; not when it is halted.

    Args:
        inputs: Gives the values that its variables begin with, at each entry.
        inner: The variables of the tree.
        outer: Those of its caller.
        outputs: Variable of the tree to variable of the caller.
    """

    def __init__(
        self,
        name: str,
        child: Behaviour,
        inputs: Callable[[], Mapping[str, Any]],
        inner: Scope,
        outer: Scope,
        outputs: Mapping[str, str],
    ) -> None:
        super().__init__(name, child)
        self._inputs = inputs
        self._inner = inner
        self._outer = outer
        self._outputs = outputs

    @property
    def inner(self) -> Scope:
        """The variables of the tree below."""
        return self._inner

    @property
    def variables(self) -> Mapping[str, Any]:
        """Those of the tree, as they are now."""
        return self._inner.values

    def initialise(self) -> None:
        """Forget the last time, and take the inputs."""
        values = dict(self._inputs())
        self._inner.values.clear()
        self._inner.values.update(values)

    def update(self) -> Status:
        """End as the tree does."""
        self.feedback_message = ""
        return self.decorated.status

    def terminate(self, new_status: Status) -> None:
        """Hand the outputs out."""
        if new_status is not Status.INVALID:
            values = self._inner.values
            found = {ours: values[name] for name, ours in self._outputs.items() if name in values}
            self._outer.values.update(found)
