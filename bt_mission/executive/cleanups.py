"""The clean-ups that run after a halt, beside the tree or after its end."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.errors import described
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.goals.ledger import Ledger


class Cleanups:
    """Ticks the clean-ups that the `finally` nodes of a tree still have to run.

    Meanwhile the tree does not send new goals.

    Args:
        nodes: All nodes of the tree.
        ledger: Set when the goals of the tree have to wait.
        mark: Yielded by a tick at a breakpoint; clean-ups do not stop there.
        departed: Nodes that a revision has removed from the tree, and whose clean-ups still run.
    """

    def __init__(
        self,
        nodes: Collection[Behaviour],
        ledger: Ledger,
        mark: Behaviour,
        departed: Iterable[Finally] = (),
    ) -> None:
        inside = tuple(node for node in nodes if isinstance(node, Finally))
        outside = (inner for node in departed for inner in node.iterate())
        self._departed = dict.fromkeys(node for node in outside if isinstance(node, Finally))
        self._nodes = (*inside, *self._departed)
        self._goals = frozenset(node for node in nodes if isinstance(node, ActionLeaf))
        self._ledger = ledger
        self._mark = mark
        self.inside = frozenset(inner for node in self._nodes for inner in node.cleanup.iterate())
        """The nodes of all clean-ups, which end without a halt."""
        self.failures: dict[str, None] = {}
        """A line for each that did not succeed."""

    @property
    def is_pending(self) -> bool:
        """Whether a clean-up is under way."""
        return any(node.is_detached for node in self._nodes)

    @property
    def limit_s(self) -> float:
        """The limit of all clean-ups together that are due, s."""
        return sum(node.limit_s for node in self._nodes)

    @property
    def departed(self) -> tuple[Finally, ...]:
        """The nodes outside the tree whose clean-ups still run."""
        return tuple(node for node in self._departed if node.is_detached)

    def before(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        """Put the clean-ups that are under way before a walk of the tree."""
        return self._first(walk) if self._nodes else walk

    def _first(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        yield from self.walk()
        self._ledger.is_held = self.is_pending
        yield from walk

    def walk(self) -> Iterator[Behaviour]:
        """Tick those that are under way."""
        self._ledger.is_held = False
        for node in self._nodes:
            if node.is_detached:
                visited = [child for child in node.tick_detached() if child is not self._mark]
                if node not in self._departed:
                    yield from visited
                self._note(node)

    def halt_tree(self, root: Behaviour) -> list[str]:
        """Stop each running node once; a leaf releases its goal. Return the errors.

        Clean-ups begin, or continue.
        """
        errors = []
        inside, goals = self.inside, self._goals
        due: frozenset[Behaviour] = frozenset(node for node in self._nodes if node.limit_s > 0)
        for node in root.iterate():
            try:
                if node in inside:
                    continue
                if node.status is Status.RUNNING or node in due:
                    node.stop(Status.INVALID)
                elif node in goals:
                    node.call_terminate(Status.INVALID)  # its update may have raised
            except Exception as error:  # noqa: BLE001 - the others must still be stopped
                errors.append(f"stopping '{node.name}' raised {described(error)}")
        return errors

    def skip(self, reason: str) -> None:
        """End all of them now, those in each other included."""
        while self.is_pending:
            for node in self._nodes:
                if node.is_detached:
                    node.skip(reason)
                    self._note(node)

    def _note(self, node: Finally) -> None:
        if not node.is_detached and node.failure:
            self.failures[f"'{node.name}': {node.failure}"] = None
