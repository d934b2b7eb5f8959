"""Revises a running mission: compares the versions, refuses, or exchanges the trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from py_trees.behaviour import Behaviour

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.revision import Graft
from bt_mission.behaviours.runtime import Runtime
from bt_mission.core.errors import cause_of
from bt_mission.executive.executive import Executive
from bt_mission.language.mission import Mission
from bt_mission.language.revision import Comparison, Revision, compare, refusals


def revise(
    executive: Executive,
    runtime: Runtime,
    running: Mission,
    mission: Mission,
    *,
    prepare: Callable[[Mission], object] = lambda _: None,
    accept: Callable[[Mission], object],
    dry_run: bool = False,
    keep_goals: bool = False,
) -> Revision:
    """Continue with another version of a running mission, or say why that is not possible.

    Args:
        executive: Of the running mission.
        runtime: Of its leaves.
        running: The running mission, or the newest version of it.
        mission: The new version as its file has it.
        prepare: Called with the new version before its nodes are set up.
        accept: Called with the new version before the trees are exchanged.
        dry_run: Only say what would happen.
        keep_goals: Let leaves that run and change continue with the values with which they started.
    """
    comparison = compare(running, mission)
    revision = replace(comparison.revision(), number=executive.revisions)
    reasons = [*filter(None, [executive.why_not_revisable]), *refusals(running, mission)]
    graft: Graft | None = None
    details: dict[str, tuple[str, ...]] = {}
    try:
        paths = {node: executive.path_of(node) for node in executive.nodes}
        graft = Graft(comparison, paths, runtime, executive.followed, is_kept=keep_goals)
        reasons += graft.refusals
        revision = replace(
            revision,
            continues=_with_goals(graft.continuing),
            cancels=_with_goals(graft.stopped),
            restarts=tuple(graft.restarting),
        )
        if not reasons and not dry_run:
            details = _details(comparison, executive)
            prepare(comparison.after)
            graft.prepare()
    except Exception as error:  # noqa: BLE001 - a user's behaviour may raise anything
        reasons.append(cause_of(error))
    if reasons or dry_run or graft is None:
        if graft is not None:
            graft.abandon()
        return replace(revision, reasons=tuple(reasons))
    accept(comparison.after)
    executive.revise(graft, details, revision.counts)
    return replace(revision, is_applied=True, number=executive.revisions)


def _details(comparison: Comparison, executive: Executive) -> dict[str, tuple[str, ...]]:
    """Return the details of each node of the new version; leaves that stay keep theirs."""
    before = {info.path: info.details for info in executive.node_infos}
    return {
        node.path: tuple(node.node.details())
        if node.twin is None or node.is_changed or node.below
        else before[node.twin.path]
        for node in comparison.new
    }


def _with_goals(leaves: list[Behaviour]) -> tuple[str, ...]:
    """Return the names of the leaves whose goals have not ended."""
    return tuple(
        leaf.name for leaf in leaves if isinstance(leaf, ActionLeaf) and not leaf.has_outcome
    )
