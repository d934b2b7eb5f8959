"""Warnings about a mission that need no ROS."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

from bt_mission.base.diagnostics import Diagnostic, diagnostic_at, listed, quoted
from bt_mission.base.yaml.document import Document
from bt_mission.base.yaml.models import word_for_boolean
from bt_mission.language.checks.scope import names_read
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import EITHER, ConditionalNode, Ends, NodeModel, Path
from bt_mission.language.nodes.composites import (
    FallbackNode,
    FinallyNode,
    InTurnNode,
    ParallelNode,
)
from bt_mission.language.nodes.decorators import ForceNode, InvertNode, RepeatNode, TimeoutNode
from bt_mission.language.nodes.leaves import CheckNode, LogNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.language.trees import used

Finding: TypeAlias = tuple[str, Path, str, str | None]
"""Code, place in the document, message and hint of something suspicious."""


def warnings(mission: Mission) -> Iterator[Diagnostic]:
    """Yield the warnings about the mission's own tree, and about the named trees that it uses."""
    names, live = used(mission), _live_inputs(mission)
    for tree in mission.all_trees:
        if tree.is_main or tree.name in names:
            changing = set() if tree.is_main else live.get(tree.name, set())
            read = frozenset(tree.outputs).union(*map(names_read, tree.body.walk()))
            yield from _head_warnings(tree, read)
            for code, path, message, hint in _findings(tree, read, changing):
                yield tree.document.diagnostic(code, path, message, hint, severity="warning")
            yield from _cut_texts(tree)
    for name, tree in mission.trees.items():
        if name not in names and tree.document is mission.document:
            message = f"the tree '{name}' is never used"
            yield tree.document.diagnostic(
                "BT-231", tree.path, message, key=True, severity="warning"
            )


def word_inputs(mission: Mission) -> Iterator[Diagnostic]:
    """Yield a warning for each input that is `yes`, `off` or the like, without quotes."""
    for tree in mission.all_trees:
        head = () if tree.is_main else tree.path
        for name, value in tree.inputs.items():
            hint = word_for_boolean(value)
            path = (*head, "inputs", name)
            if hint is None or not _has(tree.document, path[:-1], name):
                continue
            line, column = tree.document.position(path)
            written = tree.document.lines[line - 1][column - 1 :]
            if written.startswith(str(value)):
                message = f"the input '{name}' is the string '{value}'"
                yield tree.document.diagnostic("BT-306", path, message, hint, severity="warning")


def _head_warnings(tree: Tree, read: frozenset[str]) -> Iterator[Diagnostic]:
    """Yield a warning for each input and followed variable that is never read."""
    document, head = tree.document, () if tree.is_main else tree.path
    for name in tree.types:
        if name not in read:
            place = next(
                section for section in ("inputs", "needs") if _has(document, (*head, section), name)
            )
            message = f"the input '{name}' is never read"
            yield document.diagnostic(
                "BT-231", (*head, place, name), message, key=True, severity="warning"
            )
    for follow in tree.follow:
        if follow.variable not in read:
            message = f"the variable '{follow.variable}' is never read"
            yield document.diagnostic(
                "BT-231", (*follow.place.path, "as"), message, severity="warning"
            )


def _has(document: Document, path: Path, name: str) -> bool:
    return name in (document.find(path).keys or {})


def _live_inputs(mission: Mission) -> dict[str, set[str]]:
    """Return the inputs of named trees that may change while the tree runs."""
    live: dict[str, set[str]] = {}
    for caller in mission.all_trees:
        for use in caller.body.walk():
            if isinstance(use, TreeNode):
                inputs = use.live_inputs.items()
                changing = {name for name, variable in inputs if variable not in caller.constants}
                live.setdefault(use.tree, set()).update(changing)
    return live


def _findings(tree: Tree, read: frozenset[str], live: set[str]) -> Iterator[Finding]:
    """Yield what is suspicious in the nodes of a tree."""
    ends = ends_of(tree.body)
    followed = {followed_topic.variable for followed_topic in tree.follow}
    variables = {*tree.types, *followed, *_written(tree.body.walk())}
    bounded, concurrent = _ids_below(tree, TimeoutNode), _ids_below(tree, ParallelNode)
    limit = 'timeout="SECONDS"' if tree.document.is_xml else "timeout: SECONDS"
    for node in tree.body.walk():
        match node:
            case InTurnNode():
                yield from _unreached(node, ends)
                yield from _restarted(node)
            case FinallyNode():
                yield from _unsure_cleanup(node, tree.body)
            case RepeatNode() if id(node) not in concurrent:
                # Beside a loop in a `parallel` there may be a node that changes its condition.
                yield from _unmoved_loop(node, followed | live)
            case ConditionalNode():
                yield from _constant_condition(node)
            case LogNode():
                yield from _bare_braces(node, variables)
        endless = node.endless()
        if endless is not None and id(node) not in bounded:
            message = f"{endless} has no timeout: it can run forever"
            yield "BT-234", node.path, message, f"add '{limit}'"
        for write in node.writes():
            if write.variable not in read:
                message = f"the {write.what} '{write.variable}' is never read"
                yield "BT-231", (*node.path, *write.path), message, None


def _ids_below(tree: Tree, kind: type[NodeModel]) -> set[int]:
    """Return the `id` of each node of a kind, and of the nodes below it."""
    of_kind = (node for node in tree.body.walk() if isinstance(node, kind))
    return {id(inner) for node in of_kind for inner in node.walk()}


# ---- how nodes can end -----------------------------------------------------------------------


def ends_of(tree: NodeModel, uses: Mapping[str, Ends] | None = None) -> dict[int, Ends]:
    """Return how each node of a tree can end, by the node's `id`; a goal may end either way.

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
    """Return the `id` of each node whose failure the mission provides for, so that it continues.

    Those are the nodes below a `fallback` but for its last child, below `invert` and
    `force: success`, and below a `parallel` that can spare them; also in a tree that is used there.
    """
    reached: set[int] = set()
    waiting = [tree.body for tree in mission.all_trees]
    while waiting:
        for node in waiting.pop().walk():
            spared = mission.below(node) if id(node) in reached else _spared(node)
            new = [child for child in spared if id(child) not in reached]
            reached.update(map(id, new))
            waiting += new
    return frozenset(reached)


def _spared(node: NodeModel) -> Sequence[NodeModel]:
    """Return the children of a node that may fail without an end to the mission."""
    match node:
        case FallbackNode():
            return node.children[:-1]
        case InvertNode() | ForceNode(status="success"):
            return node.below
        case ParallelNode(fail_when="impossible", succeed_when="any"):
            return node.children
    return ()


def _unreached(node: InTurnNode, ends: Mapping[int, Ends]) -> Iterator[Finding]:
    """Yield the first child that stands behind one at which its parent always ends."""
    never = "succeeds" if node.goes_on == "success" else "fails"
    for before, after in pairwise(node.children):
        if node.goes_on not in ends[id(before)]:
            where = f"the node before it, in line {before.line}"
            yield "BT-232", after.path, f"never reached: {where}, never {never}", None
            return


def _restarted(node: InTurnNode) -> Iterator[Finding]:
    """Yield every child that takes time and begins again in each tick.

    That is what `memory: false` does to all but the last child: a child that has ended is ticked
    again in the next tick, with new goals, while a later sibling runs.
    """
    ended = "succeeded" if node.goes_on == "success" else "failed"
    for child in () if node.memory else node.children[:-1]:
        if any(part.takes_time for part in child.walk()):
            message = (
                f"once it has {ended}, this {child.kind} restarts in every tick while a later "
                f"one runs: the {node.kind} in line {node.line} has 'memory: false'"
            )
            yield "BT-233", child.path, message, "put slow nodes last, or remove 'memory: false'"


# ---- variables and conditions ----------------------------------------------------------------


def _written(nodes: Iterator[NodeModel]) -> set[str]:
    return {write.variable for node in nodes for write in node.writes()}


def _unsure_cleanup(node: FinallyNode, tree: NodeModel) -> Iterator[Finding]:
    """Yield what a clean-up reads and its node may not have written yet."""
    inside = {id(inner) for inner in node.child.walk()}
    elsewhere = _written(step for step in tree.walk() if id(step) not in inside)
    unsure = _written(node.child.walk()) - elsewhere
    for reader in node.cleanup.walk():
        for name in sorted(names_read(reader) & unsure):
            message = f"'{name}' has no value if 'do' is halted before it is written"
            yield (
                "BT-237",
                reader.path,
                message,
                f"'set' '{name}' before the finally in line {node.line}",
            )


def _unmoved_loop(node: RepeatNode, followed: set[str]) -> Iterator[Finding]:
    """Yield the conditions of a loop that no round of it can change, nor a topic at any time."""
    written = _written(node.walk()) | followed
    for key, condition in (("while", node.settings.before), ("until", node.settings.after)):
        if not isinstance(condition, Expression) or condition.draws:
            continue
        if not condition.names & written:
            names = listed(f"'{name}'" for name in sorted(condition.names))
            why = "it reads no variable"
            if condition.names:
                why = f"nothing below 'do' assigns {names}"
            path = (*node.path, "repeat", key)
            yield "BT-235", path, f"no round changes this condition: {why}", None


_BRACES = re.compile(r"(?<!\$)\{(\w+)\}")


def _bare_braces(node: LogNode, variables: set[str]) -> Iterator[Finding]:
    """Yield each variable in braces that has no `$` before it."""
    for name in dict.fromkeys(_BRACES.findall(node.message.text)):
        if name in variables:
            message = f"'{{{name}}}' is shown as it is, not as the value of '{name}'"
            yield "BT-236", (*node.path, "log"), message, f"write '${{{name}}}'"


_CONSEQUENCES = {
    ("when", True): "'do' is always run",
    ("when", False): "'do' is never run",
    ("guard", True): "it has no effect",
    ("guard", False): "'do' is never run",
    ("check", True): "it always succeeds",
    ("check", False): "it always fails",
}


def _constant_condition(node: ConditionalNode) -> Iterator[Finding]:
    """Yield a condition that reads nothing, so that it asks nothing."""
    value = _constant(node)
    if value is not None:
        what = "always holds" if value else "never holds"
        message = f"this condition {what}: {_CONSEQUENCES[node.kind, value]}"
        hint = "let it read a variable, such as '$count > 2'"
        yield "BT-235", (*node.path, node.kind), message, hint


def _constant(node: ConditionalNode) -> bool | None:
    """Return the value of a condition in every run, where it reads nothing.

    `check: false` is how a mission fails on purpose, so a plain truth value of `check` has None.
    """
    condition = node.condition
    if not isinstance(condition, Expression):
        return None if isinstance(node, CheckNode) else condition
    if condition.references or condition.draws:
        return None
    try:
        value = condition.evaluate({}, random.Random(0))
    except ExpressionError:
        return None
    return value if isinstance(value, bool) else None


# ---- texts that a comment cuts ---------------------------------------------------------------

_LOOKS_LIKE_TEXT = re.compile(r" #[^\s#!]")
"""A comment whose first word has no blank before it: `#1`, rather than `# the first`."""


def _cut_texts(tree: Tree) -> Iterator[Diagnostic]:
    """Yield a warning for every name and log message that a comment ends which looks like text."""
    for node in tree.body.walk():
        if node.name:
            yield from _cut(tree.document, (*node.path, "name"), node.name)
        if isinstance(node, LogNode):
            yield from _cut(tree.document, (*node.path, "log"), node.message.text)


def _cut(document: Document, path: Path, text: str) -> Iterator[Diagnostic]:
    line, column = document.position(path)
    source = document.lines[line - 1] if 0 < line <= len(document.lines) else ""
    start = column - 1
    if not source.startswith(text, start):  # in quotes, on several lines, or of another file
        return
    if _LOOKS_LIKE_TEXT.match(source[start + len(text) :]):
        message = f"'#' begins a comment, so the value is {quoted(text)}"
        hint = "put the text in quotes"
        at = line, column + len(text) + 1
        yield diagnostic_at("BT-113", at, document.file, document.lines, message, hint, "warning")
