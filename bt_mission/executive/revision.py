"""Revises a running mission: compares the versions, refuses, or exchanges the trees.

The work is done in steps, so that the mission can be ticked between any two of them: the
comparison (:class:`RevisionPlan`), the new tree (:meth:`RevisionPlan.build`), and the exchange
(:meth:`RevisionPlan.apply`), which is a small part of the work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from py_trees.behaviour import Behaviour

from bt_mission.base.errors import cause_of
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.revision import Graft
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.executive.executive import Executive
from bt_mission.executive.numbered_tree import NumberedTree
from bt_mission.language.mission import Mission
from bt_mission.language.revision import Revision, compare, refusals


class RevisionPlan:
    """A revision of a running mission that is not applied yet. It changes nothing.

    Args:
        executive: Of the running mission.
        runtime: Of its leaves.
        running: The running mission, or the newest version of it.
        mission: The new version as its file has it.
        keep_goals: Let leaves that run and change continue with the values with which they started.
    """

    def __init__(
        self,
        executive: Executive,
        runtime: Runtime,
        running: Mission,
        mission: Mission,
        *,
        keep_goals: bool = False,
    ) -> None:
        self._executive, self._runtime = executive, runtime
        self._keep_goals = keep_goals
        self.comparison = compare(running, mission)
        self._number = executive.revisions
        self._revision = replace(self.comparison.revision(), number=self._number)
        self._reasons = tuple(refusals(running, mission))
        self._graft: Graft | None = None
        self._tree: NumberedTree | None = None

    @property
    def is_current(self) -> bool:
        """Whether it is about the running tree, and about the leaves that run."""
        is_current = self._graft is None or self._graft.is_current
        return is_current and self._number == self._executive.revisions

    def build(self, prepare: Callable[[Mission], object] | None = None) -> None:
        """Build the new tree beside the running one.

        Args:
            prepare: Called with the new version before its nodes are set up; None sets up nothing.
        """
        executive = self._executive
        try:
            if self._graft is None:
                self._graft = Graft(
                    self.comparison,
                    executive.paths,
                    self._runtime,
                    executive.followed,
                    is_kept=self._keep_goals,
                )
            if prepare is not None and not self._refused(self._graft):
                prepare(self.comparison.after)
                self._graft.set_up()
                self._tree = self._numbered(self._graft)
        except Exception as error:  # noqa: BLE001 - a user's behaviour may raise anything
            self._reasons += (cause_of(error),)

    def preview(self) -> Revision:
        """Return what would happen, after :meth:`build`."""
        graft = self._graft
        if graft is None:
            return replace(self._revision, reasons=self._reasons)
        return replace(
            self._revision,
            reasons=self._refused(graft),
            continues=_with_goals(graft.continuing),
            cancels=_with_goals(graft.stopped),
            restarts=tuple(graft.restarting),
        )

    def apply(
        self, prepare: Callable[[Mission], object], accept: Callable[[Mission], object]
    ) -> Revision:
        """Exchange the trees, or say why that is not possible; after :meth:`build`.

        Args:
            prepare: As for :meth:`build`, which is called again if the new nodes are not set up.
            accept: Called with the new version before the trees are exchanged.
        """
        if self._tree is None and not self._reasons:
            self.build(prepare)
        revision, graft = self.preview(), self._graft
        if revision.reasons or graft is None or self._tree is None:
            return revision
        try:
            graft.take_state()
        except Exception as error:  # noqa: BLE001 - a user's behaviour may raise anything
            return replace(revision, reasons=(cause_of(error),))
        accept(self.comparison.after)
        self._executive.revise(graft, self._tree, revision.counts)
        return replace(revision, is_applied=True, number=self._executive.revisions)

    def _refused(self, graft: Graft) -> tuple[str, ...]:
        why_not = self._executive.why_not_revisable
        return (*filter(None, [why_not]), *self._reasons, *graft.refusals)

    def _numbered(self, graft: Graft) -> NumberedTree:
        """Return the new tree; leaves that stay keep their details."""
        before = {info.path: info.details for info in self._executive.node_infos}
        details = {
            node.path: tuple(node.node.details())
            if node.twin is None or node.is_changed or node.below
            else before[node.twin.path]
            for node in self.comparison.new
        }
        names = {node.path: node.label for node in self.comparison.new}
        return NumberedTree.of(graft.root, details, names)


def _with_goals(leaves: list[Behaviour]) -> tuple[str, ...]:
    """Return the names of the leaves whose goals have not ended."""
    return tuple(
        leaf.name for leaf in leaves if isinstance(leaf, ActionLeaf) and not leaf.has_outcome
    )
