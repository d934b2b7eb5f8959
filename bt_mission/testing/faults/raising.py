"""Faults in code: exceptions in leaves and in callbacks of nodes."""

from __future__ import annotations

from typing import Any, NoReturn

from bt_mission.testing.errors import ScenarioError, no_such
from bt_mission.testing.faults.fault import Fates, Fault, FaultInstance, Maker, passed
from bt_mission.virtual_time import Passing, Side

METHODS = ("initialise", "update", "terminate")


class CodeFaults(Maker):
    """Exceptions where code should have none; `raise_in_maneuver` is among those of servers."""

    def raise_in_leaf(
        self,
        leaf: str,
        error: Exception | None = None,
        *,
        method: str = "update",
        on: int = 1,
        lasting: float | None = None,
    ) -> Fault:
        """Raise an exception in a leaf of the tree.

        :param leaf: its name or path.
        :param error: RuntimeError where it is None.
        :param method: ``initialise``, ``update`` or ``terminate``.
        :param on: at which call from now on.
        """
        if method not in METHODS:
            raise ScenarioError(
                f"raise_in_leaf: expected a method of {', '.join(METHODS)}, got '{method}'"
            )
        raised = error or RuntimeError("made by a fault")

        def begin(fault: FaultInstance) -> None:
            node = fault.run.find(leaf)
            if node.children:
                leaves = [one.name for one in fault.run.history.nodes if not one.children]
                raise no_such("leaf", leaf, leaves)
            sound = getattr(node, method)
            left = [on]

            def call(*arguments: Any) -> Any:
                left[0] -= 1
                if left[0] == 0:
                    fault.end()
                    raise raised
                return sound(*arguments)

            setattr(node, method, call)
            fault.undo(lambda: delattr(node, method))

        return self._fault(
            "raise_in_leaf", begin, lasting, leaf=leaf, error=error, method=method, on=on
        )

    def raise_in_callback(
        self,
        node: str,
        name: str,
        error: Exception | None = None,
        *,
        on: int = 1,
        lasting: float | None = None,
    ) -> Fault:
        """Raise an exception in a callback of a node, which ends the mission on the stage.

        :param node: its name.
        :param name: of a topic that it hears, or of a service that it offers.
        :param error: RuntimeError where it is None.
        :param on: at which call from now on.
        """
        raised = error or RuntimeError("made by a fault")

        def begin(fault: FaultInstance) -> None:
            receiver = fault.receiver(node)
            full, side = _callback(fault, str(receiver), name)
            left = [on]

            def fail() -> NoReturn:
                fault.end()
                raise raised

            def tap(passing: Passing) -> Fates:
                left[0] -= 1
                return passed(passing) if left[0] else fail()

            fault.tap(full, side, tap, receiver)

        return self._fault(
            "raise_in_callback", begin, lasting, node=node, name=name, error=error, on=on
        )


def _callback(fault: FaultInstance, node_name: str, name: str) -> tuple[str, Side]:
    """What wakes a node under a name."""
    clock = fault.run.stage.clock
    node = next(one for one in clock.get_nodes() if one.get_fully_qualified_name() == node_name)
    full = node.resolve_topic_name(name)
    heard = {one.topic_name for one in node.subscriptions}
    offered = {one.service_name for one in node.services}
    if full not in heard | offered:
        raise no_such(f"topic or service of {node_name}", full, sorted(heard | offered))
    return full, Side.MESSAGE if full in heard else Side.REQUEST
