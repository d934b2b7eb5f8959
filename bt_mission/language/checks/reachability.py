"""Which nodes of a mission can succeed and fail, and what follows: nodes that nobody reaches.

Only what is certain is used: a goal may always end either way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bt_mission.core.diagnostics import Diagnostic, listed
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.scope import names_read
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import EITHER, Ends, NodeModel
from bt_mission.language.nodes.composites import (
    FallbackNode,
    FinallyNode,
    InTurnNode,
    ParallelNode,
)
from bt_mission.language.nodes.decorators import ForceNode, InvertNode, RepeatNode
from bt_mission.language.nodes.subtree import TreeNode


def ends_of(tree: NodeModel, uses: Mapping[str, Ends] | None = None) -> dict[int, Ends]:
    """Return how each node of a tree can end, by the node's `id`.

    `uses` says how named trees end; of others it is not known.
    """
    ends: dict[int, Ends] = {}
    for node in reversed(list(tree.walk())):
        if uses and isinstance(node, TreeNode):
            ends[id(node)] = uses.get(node.tree, EITHER)
        else:
            ends[id(node)] = node.ends([ends[id(below)] for below in node.below])
    return ends


def expected_failures(mission: Mission) -> frozenset[int]:
    """Return the `id` of each node whose failure the mission provides for, so that it goes on.

    Those are the nodes below a `fallback` but for its last child, below `invert` and
    `force: success`, and below a `parallel` that can spare them; also in a tree that is used there.
    """
    found: set[int] = set()
    waiting = [tree.body for tree in mission.all_trees]
    while waiting:
        for node in waiting.pop().walk():
            spared = node.below if id(node) in found else _spared(node)
            if id(node) in found and isinstance(node, TreeNode) and node.tree in mission.trees:
                spared = (mission.trees[node.tree].body,)
            new = [child for child in spared if id(child) not in found]
            found.update(map(id, new))
            waiting += new
    return frozenset(found)


def _spared(node: NodeModel) -> tuple[NodeModel, ...]:
    """Return the children of a node that may fail without an end to the mission."""
    match node:
        case FallbackNode():
            return node.children[:-1]
        case InvertNode() | ForceNode(status="success"):
            return node.below
        case ParallelNode(fail_when="impossible", succeed_when="any"):
            return node.children
    return ()


def unreached(document: Document, tree: NodeModel) -> Iterator[Diagnostic]:
    """Yield a warning for every child that stands behind one at which its parent always ends."""
    ends = ends_of(tree)
    for node in tree.walk():
        if not isinstance(node, InTurnNode):
            continue
        never = "succeeds" if node.goes_on == "success" else "fails"
        for before, after in zip(node.children, node.children[1:], strict=False):
            if node.goes_on not in ends[id(before)]:
                message = f"never reached: the node before it, in line {before.line}, never {never}"
                yield document.fault(after.path, message, severity="warning")
                break


def restarted(document: Document, tree: NodeModel) -> Iterator[Diagnostic]:
    """Yield a warning for every child that takes time and is begun anew in each tick.

    That is what `memory: false` does to all but the last child: whoever has ended is asked again
    in the next tick, with new goals, while a later sibling runs.
    """
    for node in tree.walk():
        if not isinstance(node, InTurnNode) or node.memory:
            continue
        ended = "succeeded" if node.goes_on == "success" else "failed"
        for child in node.children[:-1]:
            if any(part.takes_time for part in child.walk()):
                message = (
                    f"once it has {ended}, this {child.kind} begins anew in every tick while a "
                    f"later one runs: the {node.kind} in line {node.line} has 'memory: false'"
                )
                hint = "put what takes time last, or leave 'memory' out"
                yield document.fault(child.path, message, hint, severity="warning")


def unsure_cleanups(document: Document, tree: NodeModel) -> Iterator[Diagnostic]:
    """Yield a warning for every clean-up that reads what its node may not have written yet."""
    for node in tree.walk():
        if not isinstance(node, FinallyNode):
            continue
        inside = {id(one) for one in node.child.walk()}
        elsewhere = {
            write.variable for one in tree.walk() if id(one) not in inside for write in one.writes()
        }
        written = {write.variable for one in node.child.walk() for write in one.writes()}
        for reader in node.cleanup.walk():
            for name in sorted(names_read(reader) & (written - elsewhere)):
                message = f"'{name}' has no value where 'do' is halted before it is written"
                hint = f"'set' '{name}' before the finally in line {node.line}"
                yield document.fault(reader.path, message, hint, severity="warning")


def unmoved_loops(document: Document, tree: Tree) -> Iterator[Diagnostic]:
    """Yield a warning for every condition of a loop that no round of it can change.

    Beside a loop in a `parallel` there may be a node that does; nothing is said of those. A topic
    may change a variable that follows it at any time.
    """
    followed = {one.variable for one in tree.follow}
    waiting = [tree.body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ParallelNode):
            continue
        waiting += node.below
        if not isinstance(node, RepeatNode):
            continue
        written = {write.variable for inner in node.walk() for write in inner.writes()}
        for key, condition in (("while", node.settings.before), ("until", node.settings.after)):
            if not isinstance(condition, Expression) or condition.draws:
                continue
            if not condition.names & (written | followed):
                names = listed(f"'{name}'" for name in sorted(condition.names))
                why = f"nothing below 'do' assigns {names}" if names else "it reads no variable"
                message = f"no round changes this condition: {why}"
                path = (*node.path, "repeat", key)
                yield document.fault(path, message, severity="warning")
