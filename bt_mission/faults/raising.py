"""Faults in code: exceptions in leaves and in callbacks of nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from bt_mission.behaviours.hooks import Hooked
from bt_mission.faults.errors import ScenarioError, no_such
from bt_mission.faults.fault import Begin, Fates, FaultInstance
from bt_mission.faults.maker import Maker, makes_fault, passed
from bt_mission.faults.parameters import LeafName, NodeName, Seconds
from bt_mission.virtual_time import Passing, Side

if TYPE_CHECKING:
    from rclpy.node import Node

METHODS = ("initialise", "update", "terminate")


class CodeFaults(Maker):
    """Exceptions where code should have none; `raise_in_maneuver` is among those of servers."""

    @makes_fault
    def raise_in_leaf(
        self,
        leaf: LeafName,
        error: Exception | None = None,
        *,
        method: Literal["initialise", "update", "terminate"] = "update",
        on: int = 1,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Raise an exception in a leaf of the tree.

        Args:
            leaf: Its name or path.
            error: RuntimeError where it is None.
            method: ``initialise``, ``update`` or ``terminate``.
            on: At which call from now on.
        """
        if method not in METHODS:
            raise ScenarioError(
                f"raise_in_leaf: expected a method of {', '.join(METHODS)}, got '{method}'"
            )
        raised = error or RuntimeError("made by a fault")

        def begin(fault: FaultInstance) -> None:
            node = fault.run.find(leaf)
            if node.children:
                leaves = [
                    one.name for one in fault.run.robot_run.executive.nodes if not one.children
                ]
                raise no_such("leaf", leaf, leaves)
            if not isinstance(node, Hooked):
                raise ScenarioError(
                    f"raise_in_leaf: '{leaf}' is inside a behaviour written in Python; name that"
                )

            def hook(called: str) -> None:
                if called == method and fault.ends_at_call(on):
                    raise raised

            node.call_hooks = (hook, *node.call_hooks)
            fault.undo(lambda: node.remove_call_hook(hook))

        return begin

    @makes_fault
    def raise_in_callback(
        self,
        node: NodeName,
        name: str,
        error: Exception | None = None,
        *,
        on: int = 1,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Raise an exception in a callback of a node, which ends the mission on the stage.

        Args:
            node: Its name.
            name: Of a topic that it hears, or of a service that it offers.
            error: RuntimeError where it is None.
            on: At which call from now on.
        """
        raised = error or RuntimeError("made by a fault")

        def tap(fault: FaultInstance, passing: Passing) -> Fates:
            if fault.ends_at_call(on):
                raise raised
            return passed(fault, passing)

        def begin(fault: FaultInstance) -> None:
            woken = fault.node(node)
            full, side = _callback(woken, name)
            fault.tap(full, side, tap, woken.get_fully_qualified_name())

        return begin


def _callback(node: Node, name: str) -> tuple[str, Side]:
    """Find what wakes a node under a name."""
    full = node.resolve_topic_name(name)
    heard = {one.topic_name for one in node.subscriptions}
    offered = {one.service_name for one in node.services}
    if full not in heard | offered:
        what = f"topic or service of {node.get_fully_qualified_name()}"
        raise no_such(what, full, sorted(heard | offered))
    return full, Side.MESSAGE if full in heard else Side.REQUEST
