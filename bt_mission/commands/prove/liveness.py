"""Which variables a mission may still read in a state: the values of all others are no part of it.

A variable is live where a way from there reads it before the way writes it. Two states that differ
only in variables that are not live offer the same options and lead to states of which the same is
true, step by step: every node reads live variables only, and what it writes it computes from
those. So they break the same properties, and one of them stands for both. Here a variable is live
too often rather than too seldom:

- A node reads all that its class declares, the fields that it sends and its condition included.
  That counts for as long as the node runs, because a limit may have been computed at entry.
- Only a success writes for certain. A failure, a halt and a condition that ends a goal do not.
- What stands around a node counts while the node runs: the condition of a guard, what follows a
  timeout, a clean-up.
- The order of nodes is known in sequences and fallbacks with memory, in choices and in the
  decorators below. Elsewhere (``parallel``, no memory, nodes of other kinds) every variable that a
  node inside reads is live from the beginning to the end.
- Whether an action, service or reader is there counts like a variable that each leaf reads that
  may ask for it, and that none writes.
- A variable of the caller and the output of a named tree that writes it are live together.

Variables that follow topics are always kept, because messages write them at any time. A requirement
adds its own signals to the state, so their variables need not be live here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from py_trees.behaviour import Behaviour

from bt_mission.commands.prove.clients import AnyBehaviour
from bt_mission.commands.prove.offered import full_name
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import ClientLeaf, ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.control import Guard, Pick, Selector, Sequence, Timeout
from bt_mission.executive.behaviours.decorators import Force, Inverter, Repeat, Retry, Subtree
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.leaves import Set
from bt_mission.language.checks.scope import names_read

Variable: TypeAlias = tuple[int, str]
"""The `id` of a scope, and a name in it."""
Live: TypeAlias = frozenset[Variable]
Names: TypeAlias = Mapping[int, frozenset[str]]
"""Names of variables, by the `id` of their scope."""
SERVERS = 0
"""In place of the `id` of a scope, for the actions, services and topics that leaves may ask for."""

_NONE: Live = frozenset()
_WRITERS = (Set, ServiceLeaf, WaitFor, AnyBehaviour, ActionLeaf)
"""The leaves that write all of their variables if they succeed."""


class LiveVariables:
    """The live variables of every state of a mission.

    Args:
        root: The tree.
        evaluators: Of its nodes.
    """

    def __init__(self, root: Behaviour, evaluators: Mapping[Behaviour, Evaluator]) -> None:
        self._evaluators = evaluators
        self._reads = {node: self._read_by(node) for node in root.iterate()}
        self._resting: dict[Behaviour, Live] = {}
        """By node, what is live between two ticks while it runs and no node below it does."""
        self._known: dict[tuple[frozenset[Behaviour], frozenset[Finally]], Names] = {}
        scopes = [values.scope for values in evaluators.values()]
        scopes += [values.inner for values in evaluators.values()]
        self._followed: Names = {SERVERS: frozenset()} | {
            id(scope): frozenset(follow.variable for follow in scope.followed) for scope in scopes
        }
        self._before(root, _NONE, _NONE, _NONE)

    def names(self, running: Iterable[Behaviour], detached: Iterable[Finally]) -> Names:
        """Return the names that are live, and those that follow topics, by the `id` of their scope.

        Args:
            running: All nodes that run.
            detached: The nodes whose clean-up is under way behind a halt, or about to begin.
        """
        key = frozenset(running), frozenset(detached)
        names = self._known.get(key)
        if names is None:
            live = self._live(key[0]).union(*(self._read_below(node.cleanup) for node in key[1]))
            names = self._known[key] = {
                number: followed.union(name for owner, name in live if owner == number)
                for number, followed in self._followed.items()
            }
        return names

    def read_in_cleanup(self, node: Finally) -> frozenset[str]:
        """Return the names that a clean-up reads of the variables that its node has kept for it."""
        number = id(self._evaluators[node].scope)
        return frozenset(name for owner, name in self._read_below(node.cleanup) if owner == number)

    def _live(self, running: frozenset[Behaviour]) -> Live:
        live: set[Variable] = set()
        for node in running:
            if running.isdisjoint(node.children):
                live |= self._resting[node]
        trees = [node for node in running if isinstance(node, Subtree)]
        for node in sorted(trees, key=self._depth, reverse=True):
            live |= {outer for outer, inner in self._pairs(node) if inner in live}
        return frozenset(live)

    def _depth(self, node: Behaviour) -> int:
        return self._evaluators[node].path.count(".")

    # ---- what nodes read and write ----------------------------------------------------------

    def _of(self, node: Behaviour, names: Iterable[str]) -> Live:
        number = id(self._evaluators[node].scope)
        return frozenset((number, name) for name in names)

    def _read_by(self, node: Behaviour) -> Live:
        model = self._evaluators[node].node
        servers = [(SERVERS, full_name(model.ros_name))] if isinstance(node, ClientLeaf) else []
        return self._of(node, names_read(model)).union(servers)

    def _read_below(self, node: Behaviour) -> Live:
        """Return what a node and those below it read, each of them at any time."""
        read: set[Variable] = set()
        for inner in node.iterate():
            read |= self._reads[inner]
            if isinstance(inner, Subtree):
                read.update(outer for outer, _ in self._pairs(inner))
        return frozenset(read)

    def _written_by(self, leaf: Behaviour) -> Live:
        """Return what a leaf has written when it has succeeded."""
        node = self._evaluators[leaf].node
        if not isinstance(leaf, _WRITERS) or getattr(node, "cancel_when", None) is not None:
            return _NONE
        return self._of(leaf, (write.variable for write in node.writes()))

    def _pairs(self, node: Subtree) -> list[tuple[Variable, Variable]]:
        """Return the variables of the caller that a named tree writes, with its own ones."""
        values = self._evaluators[node]
        outer, inner = id(values.scope), id(values.inner)
        return [
            ((outer, variable), (inner, name)) for name, variable in values.node.outputs.items()
        ]

    # ---- what is live -----------------------------------------------------------------------

    def _before(self, node: Behaviour, success: Live, failure: Live, around: Live) -> Live:
        """Return what is live before a node begins; note what is live while it runs.

        Args:
            success: What is live behind its success.
            failure: What is live behind its failure.
            around: What is live as long as it runs.
        """
        reads, behind = self._reads[node], success | failure | around
        match node:
            case _ if not node.children:
                live = (success - self._written_by(node)) | failure
                behind = around
            case Sequence() | Selector() if node.memory:
                live = failure if isinstance(node, Selector) else success
                for child in reversed(node.children):
                    ends = (live, failure) if isinstance(node, Sequence) else (success, live)
                    live = self._before(child, *ends, around)
            case Pick():
                live = success.union(
                    *(self._before(child, success, failure, around) for child in node.children)
                )
            case Finally():
                live = self._before_cleaned(node, behind, failure, around)
            case _:
                live = self._before_decorated(node, success, failure, around)
        self._note(node, live | reads | behind)
        return live | reads | around

    def _before_cleaned(self, node: Finally, behind: Live, failure: Live, around: Live) -> Live:
        cleanup = self._before(node.cleanup, behind, behind, around | failure)
        live = self._before(node.body, cleanup, cleanup, around | cleanup)
        # Behind a halt the clean-up runs beside the tree, which may wait to begin again.
        beside = behind | live | self._read_below(node.cleanup)
        self._before(node.cleanup, beside, beside, beside)
        return live

    def _before_decorated(
        self, node: Behaviour, success: Live, failure: Live, around: Live
    ) -> Live:
        match node:
            case Inverter():
                return self._before(node.decorated, failure, success, around)
            case Force():
                end = success if self._evaluators[node].node.status == "success" else failure
                return self._before(node.decorated, end, end, around)
            case Timeout():
                return self._before(node.decorated, success, failure, around | failure)
            case Guard():
                more = failure | self._reads[node]
                return self._before(node.decorated, success, failure, around | more)
            case Repeat() | Retry():
                behind = success | failure | around
                return self._before_loop(node, behind, around | self._reads[node])
            case Subtree():
                return self._before_tree(node, success, failure, around)
        live = success | failure | around | self._read_below(node)
        for child in node.children:
            self._before(child, live, live, live)
        return live

    def _before_loop(self, node: Repeat | Retry, behind: Live, around: Live) -> Live:
        """Return what is live before a loop: what is behind it, too, as it may have no round."""
        live = behind
        while True:
            before = live | self._before(node.decorated, live, live, around)
            if before == live:
                return live
            live = before

    def _before_tree(self, node: Subtree, success: Live, failure: Live, around: Live) -> Live:
        pairs, values = self._pairs(node), self._evaluators[node]
        outer, number = frozenset(pair[0] for pair in pairs), id(values.inner)

        def inside(live: Live) -> Live:
            return frozenset(inner for written, inner in pairs if written in live)

        around = around | inside(around) | self._of(node, values.node.live_inputs.values())
        live = self._before(
            node.decorated,
            (success - outer) | inside(success),
            (failure - outer) | inside(failure),
            around,
        )
        read = frozenset(written for written, inner in pairs if inner in live)
        return frozenset(entry for entry in live if entry[0] != number) | read

    def _note(self, node: Behaviour, live: Live) -> None:
        self._resting[node] = self._resting.get(node, _NONE) | live
