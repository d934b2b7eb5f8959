"""The tree of a revised mission, built beside the running one, and put in its place.

:class:`Graft` first builds the new tree without a change of the running one, which may be ticked
meanwhile. :meth:`Graft.take_state` then reads the state of the running tree, and
:meth:`Graft.commit` exchanges them, both between the same two ticks. A leaf that stays is the same
object in both, with its goal, and so is a composite or decorator if all below it stays. The others
are new objects, and continue with the state of those that they replace.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

from bt_mission.base.errors import described
from bt_mission.executive.behaviours import control
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.builder import BEHAVIOURS, build_tree
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.follow import FollowedVariables, scopes_of
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.python_leaf import PythonLeaf
from bt_mission.executive.behaviours.runtime import Generator, Runtime, Scope
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.revision import BuiltNode, MissionComparison

RUNNING, INVALID = Status.RUNNING, Status.INVALID


class Graft:
    """A new tree that takes over from a running one.

    Args:
        comparison: The two versions of the mission.
        paths: The nodes of the running tree with their paths.
        runtime: Its variables, clock and clients.
        followed: Its variables that follow topics.
        is_kept: Let changed leaves that run continue with the values with which they started.

    Raises:
        BtMissionError: The tree cannot be built; nothing has changed.
    """

    def __init__(
        self,
        comparison: MissionComparison,
        paths: Mapping[Behaviour, str],
        runtime: Runtime,
        followed: FollowedVariables,
        *,
        is_kept: bool = False,
    ) -> None:
        self.comparison = comparison
        self.departed: list[Finally] = []
        """Nodes that are gone, and whose clean-ups run after :meth:`commit`."""
        self.followed = followed
        self._runtime = runtime
        self._old = {path: node for node, path in paths.items()}
        self.is_kept = is_kept
        self._kept = self._leaves_that_stay()
        """The leaves that stay, by their new paths."""
        self._whole = self._unchanged_above()
        self._new: dict[str, Hooked] = {}
        before = runtime.scope
        self.scope = Scope(before.values, before.seed)
        self._parents: dict[Behaviour, Behaviour | None] = {}
        """The nodes that stay, with the nodes above them in the new tree."""
        self.root = self._build()
        self.pairs = self._pairs()
        """The new node of each old one that continues, users' nodes included."""
        self._replaced = self._nodes_to_stop()
        """The nodes of the running tree that do not stay, and whether they are linked."""
        stays = self._kept.keys() | self._whole.keys()
        self._fresh = [node for node in comparison.new if node.path not in stays]
        """The nodes of the new tree with new behaviours."""
        evaluators = self.scope.evaluators
        self._cleanups = [
            (node, behaviour)
            for node in comparison.old
            if isinstance(behaviour := self._old[node.path], Finally)
        ]
        self._leaves = [self._old[node.path] for node in comparison.old if not node.below]
        """The leaves of the running tree."""
        self._moves = [
            (self._new[path], evaluators[path], evaluators[path].node.label)
            for path in (*self._kept, *self._whole)
        ]
        """The nodes that stay, with the values and the labels of their new places."""
        self._scopes = scopes_of(self.root, self.scope)

    @property
    def is_current(self) -> bool:
        """Whether the leaves that stay are the same as when it was built."""
        return not self.is_kept or self._leaves_that_stay() == self._kept

    @property
    def refusals(self) -> list[str]:
        """Why the running tree cannot be replaced now: clean-ups that run must not change."""
        reasons = []
        for node, behaviour in self._cleanups:
            if behaviour.due_ns is not None:
                _, cleanup = node.below
                inside = [node, *_walk(cleanup)]
                if any(part.is_changed or not _links(part) for part in inside):
                    reasons.append(
                        f"the clean-up of '{behaviour.name}' is under way, and would change; "
                        "wait until it has ended"
                    )
        return reasons

    @property
    def stopped(self) -> list[Behaviour]:
        """The leaves that run, and are gone, or start again."""
        kept = set(self._kept.values())
        return [node for node in self._leaves if node.status is RUNNING and node not in kept]

    @property
    def continuing(self) -> list[Behaviour]:
        """The leaves that run and stay."""
        return [node for node in self._kept.values() if node.status is RUNNING]

    @property
    def restarting(self) -> list[str]:
        """The names of leaves that run and start again."""
        stopped = set(self.stopped)
        if not stopped:
            return []
        return [
            node.label
            for node in self.comparison.new
            if node.twin is not None and self._old[node.twin.path] in stopped
        ]

    def set_up(self) -> None:
        """Set the new nodes up.

        Raises:
            BtMissionError: That is not possible; nothing has changed.
        """
        kept = {inner for leaf in self._kept.values() for inner in leaf.iterate()}
        kept.update(self._whole.values())
        for behaviour in self.root.iterate():
            if behaviour not in kept:
                behaviour.setup(runtime=self._runtime)

    def take_state(self) -> None:
        """Give the new nodes the state of those that they replace.

        Raises:
            BtMissionError: That is not possible; nothing has changed.
        """
        self.scope.generators.update(self._generators(self._runtime.scope))
        for node in self._fresh:
            self._share_variables(node)
        inputs = self.comparison.after.inputs
        added = {name: inputs[name] for name in inputs if name not in self.scope.values}
        self.scope.values.update(added)
        try:
            self._take_states()
            self.followed = FollowedVariables(self._scopes, self._runtime, self.followed)
        except BaseException:
            for name in added:
                del self.scope.values[name]
            raise

    def _take_states(self) -> None:
        now_ns = self._runtime.now_ns
        for node in self._fresh:
            behaviour = self._new[node.path]
            if node.is_linked and node.twin is not None:
                self._take_over(node, behaviour, self._old[node.twin.path], now_ns)
            elif node.is_transparent and self._is_around_running(node):
                behaviour.initialise()
                behaviour.status = RUNNING

    def commit(self) -> list[str]:
        """Exchange the trees. Return the errors of nodes that were stopped.

        The ledger sends nothing before the goals that are not wanted any more have ended.
        """
        _put_below(self._parents)
        errors = self._stop()
        for node, values, label in self._moves:
            node.take_values(values)
            node.name = label
            if type(node) is PythonLeaf:
                node.behaviour.parent = node.parent
        for name in self.comparison.lost_variables:
            self.scope.values.pop(name, None)
        return errors

    @property
    def fresh(self) -> list[Hooked]:
        """The new behaviours."""
        return [self._new[node.path] for node in self._fresh]

    # ---- building ------------------------------------------------------------------------

    def _build(self) -> Behaviour:
        """Return the new tree. The nodes that stay are still below those of the running tree."""
        stays = (*self._kept.values(), *self._whole.values())
        before = {node: node.parent for node in stays}
        kinds = {kind: self._maker(make) for kind, make in BEHAVIOURS.items()}
        try:
            root = build_tree(self.comparison.after, self.scope, kinds)
            self._parents = {node: node.parent for node in stays}
        finally:
            _put_below(before)
        return root

    def _leaves_that_stay(self) -> dict[str, Behaviour]:
        return {
            node.path: self._old[node.twin.path]
            for node in self.comparison.new
            if node.twin is not None and self._is_same_leaf(node, node.twin)
        }

    def _is_same_leaf(self, node: BuiltNode, twin: BuiltNode) -> bool:
        if node.below or not node.is_linked:
            return False
        is_running = self._old[twin.path].status is RUNNING
        return not node.is_changed or (self.is_kept and is_running)

    def _maker(
        self, make: Callable[[Any, Evaluator], Behaviour]
    ) -> Callable[[Any, Evaluator], Behaviour]:
        def made(node: NodeModel, values: Evaluator) -> Behaviour:
            stays = self._kept.get(values.path) or self._whole.get(values.path)
            if stays is None:
                stays = make(node, values)
            else:
                stays.parent = None  # it gets the new one, until the whole tree is built
                for child in stays.children:
                    child.parent = stays
            assert isinstance(stays, Hooked), "every node of a mission has values"
            self._new[values.path] = stays
            return stays

        return made

    def _unchanged_above(self) -> dict[str, Behaviour]:
        """Return the composites and decorators with all below them as before, by new paths.

        A `finally` and a named tree are built again: they hold more than their own values.
        """
        whole: dict[str, Behaviour] = {}
        for node in reversed(self.comparison.new):  # those below come first
            twin = node.twin
            if twin is None or node.is_changed or not node.below or not node.is_linked:
                continue
            behaviour = self._old[twin.path]
            if (
                [child.twin for child in node.below] == twin.below
                and all(child.path in self._kept or child.path in whole for child in node.below)
                and not isinstance(behaviour, Finally | Subtree)
            ):
                whole[node.path] = behaviour
        return whole

    def _generators(self, before: Scope) -> dict[str, Generator]:
        """Return the random generators of the nodes that stay, by their new paths."""
        if not before.generators:
            return {}
        moved = {node.twin.path: node.path for node in self.comparison.new if node.twin is not None}
        generators = {}
        for name, generator in before.generators.items():
            path, slash, key = name.partition("/")
            if path in moved:
                generators[moved[path] + slash + key] = generator
        return generators

    def _share_variables(self, node: BuiltNode) -> None:
        """Let a named tree that stays continue with its variables."""
        behaviour = self._new[node.path]
        if isinstance(behaviour, Subtree) and node.is_linked and node.twin is not None:
            old = self._old[node.twin.path]
            assert isinstance(old, Subtree), "the kinds are the same"
            behaviour.inner.values = old.inner.values

    def _pairs(self) -> dict[Behaviour, Behaviour]:
        pairs: dict[Behaviour, Behaviour] = {}
        for node in self.comparison.new:
            if not node.is_linked or node.twin is None:
                continue
            old = self._old[node.twin.path]
            if node.path in self._kept:
                pairs |= {inner: inner for inner in old.iterate()}
            else:
                pairs[old] = self._new[node.path]
        return pairs

    def _nodes_to_stop(self) -> list[tuple[BuiltNode, Behaviour, bool]]:
        kept = {*self._kept.values(), *self._whole.values()}
        nodes = ((node, self._old[node.path]) for node in self.comparison.old)
        return [
            (node, behaviour, _links(node)) for node, behaviour in nodes if behaviour not in kept
        ]

    # ---- state ---------------------------------------------------------------------------

    def _take_over(
        self, node: BuiltNode, behaviour: Behaviour, old: Behaviour, now_ns: int
    ) -> None:
        if not node.below:  # a changed leaf that runs starts again
            if old.status is not RUNNING:
                behaviour.status, behaviour.feedback_message = old.status, old.feedback_message
            return
        behaviour.status, behaviour.feedback_message = old.status, old.feedback_message
        save, restore = (
            getattr(old, "save_state", None),
            getattr(behaviour, "restore_state", None),
        )
        if save is not None and restore is not None:
            restore(save(now_ns), now_ns)
        if isinstance(behaviour, Composite) and isinstance(old, Composite):
            self._take_child(node, behaviour, old)
        if node.is_changed and old.status is RUNNING and hasattr(behaviour, "read_again"):
            behaviour.read_again()

    def _take_child(self, node: BuiltNode, behaviour: Composite, old: Composite) -> None:
        """Continue with the child at which the old composite is."""
        twin = node.twin
        if twin is None or old.current_child is None:
            return
        at = old.children.index(old.current_child)
        places = {
            child.core.twin: place for place, child in enumerate(node.below) if child.core.is_linked
        }
        place = places.get(twin.below[at].core)
        if place is not None:
            behaviour.current_child = behaviour.children[place]
        elif isinstance(behaviour, control.Pick):
            behaviour.status = INVALID  # what it had picked is gone: it picks again
        elif isinstance(behaviour, control.Sequence | control.Selector):
            done = [places[child.core] for child in twin.below[:at] if child.core in places]
            place = 1 + max(done, default=-1)
            is_over = place == len(behaviour.children)
            behaviour.current_child = None if is_over else behaviour.children[place]
        elif isinstance(behaviour, control.Parallel):
            behaviour.current_child = behaviour.children[-1]

    def _is_around_running(self, node: BuiltNode) -> bool:
        core = node.core
        if core.twin is None or not core.is_linked:
            return False
        is_leaf = not core.below
        is_kept = core.path in self._kept
        return self._old[core.twin.path].status is RUNNING and (is_kept or not is_leaf)

    # ---- exchanging ----------------------------------------------------------------------

    def _stop(self) -> list[str]:
        """Stop what is gone, or starts again; clean-ups of what is gone begin."""
        errors: list[str] = []
        inside: set[Behaviour] = set()
        for node, behaviour, is_linked in self._replaced:
            if behaviour in inside:
                continue
            try:
                if isinstance(behaviour, Finally):
                    if not is_linked and behaviour.limit_s > 0:
                        inside.update(behaviour.iterate())
                        behaviour.stop(INVALID)
                        self.departed.append(behaviour)
                elif not node.below:
                    if behaviour.status is RUNNING:
                        behaviour.stop(INVALID)
                    elif isinstance(behaviour, ActionLeaf):
                        behaviour.call_terminate(INVALID)
                elif not is_linked and behaviour.status is RUNNING:
                    behaviour.terminate(INVALID)
            except Exception as error:  # noqa: BLE001 - the others must still be stopped
                errors.append(f"stopping '{behaviour.name}' raised {described(error)}")
        return errors


def _put_below(parents: Mapping[Behaviour, Behaviour | None]) -> None:
    for node, parent in parents.items():
        node.parent = parent


def _links(node: BuiltNode) -> bool:
    """Whether a node of the running tree continues in the new one."""
    return node.twin is not None and node.twin.is_linked


def _walk(node: BuiltNode) -> Sequence[BuiltNode]:
    nodes, waiting = [], [node]
    while waiting:
        nodes.append(waiting.pop())
        waiting += nodes[-1].below
    return nodes
