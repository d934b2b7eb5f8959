"""Breakpoints: a tick that stops just before a node starts, and can continue from there.

A tick of py_trees is a generator, and every composite and decorator passes on what the generators
below it yield. A node with a breakpoint first yields a mark, by its start hook. The caller of the
tick gets the mark, and does not advance the generator until the tick may continue.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success

from bt_mission.base.diagnostics import did_you_mean
from bt_mission.base.errors import BtMissionError
from bt_mission.executive.behaviours.hooks import Hooked


class Breakpoints:
    """The nodes of a tree before which a tick stops.

    Args:
        paths: Every node of the tree with its place, such as ``0.1.0``.
    """

    def __init__(self, paths: Mapping[Behaviour, str]) -> None:
        self.mark: Behaviour = Success("breakpoint")
        """Yielded by a tick that has stopped; it is not a node of the tree."""
        self.reached: Behaviour | None = None
        """The node before which the last tick stopped."""
        self._paths = paths
        self._set: dict[str, list[Hooked]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The breakpoints, as they were named, in the order in which they were set."""
        return tuple(self._set)

    def node_name(self, name: str) -> str:
        """The name of the node where a breakpoint was named by a path."""
        return next((node.name for node, path in self._paths.items() if path == name), name)

    def add(self, name: str) -> int:
        """Stop before each node of this name or path. Return the number of nodes.

        Raises:
            BtMissionError: There is no such node, or only nodes inside a user's behaviour.
        """
        nodes = [node for node, path in self._paths.items() if name in (node.name, path)]
        if not nodes:
            hint = did_you_mean(name, sorted({node.name for node in self._paths}))
            raise BtMissionError(
                f"unknown node '{name}'" + (f"; {hint}" if hint else ""), code="BT-916"
            )
        ours = [node for node in nodes if isinstance(node, Hooked)]
        if not ours:
            raise BtMissionError(
                f"'{name}' is inside a behaviour written in Python, which is ticked as a whole; "
                f"set the breakpoint on that behaviour",
                code="BT-916",
            )
        self._set[name] = ours
        for node in ours:
            node.start_hook = self._stop
        return len(ours)

    def remove(self, name: str) -> None:
        """No longer stop before these.

        Raises:
            BtMissionError: When no breakpoint was set by this name.
        """
        if name not in self._set:
            raise BtMissionError(f"no breakpoint on '{name}'", code="BT-916")
        removed = self._set.pop(name)
        still = {node for nodes in self._set.values() for node in nodes}
        for node in removed:
            if node not in still:
                node.start_hook = None

    def move(self, paths: Mapping[Behaviour, str]) -> None:
        """Set the breakpoints in the tree of a revision; those without a node there are removed."""
        names = self.names
        for name in names:
            self.remove(name)
        self._paths = paths
        for name in names:
            with suppress(BtMissionError):
                self.add(name)

    def _stop(self, node: Behaviour) -> Iterator[Behaviour]:
        self.reached = node
        yield self.mark
