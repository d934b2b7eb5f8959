"""Compares a running mission with a new version of it, node by node. No ROS is needed.

Two nodes are the same node if they have the same kind, and the same ``name`` wherever they are in
the tree. A node without a name of its own is found by its place: below the same node, with the
same label, in the same order. A decorator of :data:`TRANSPARENT` may be put around a node, or taken
away, without a change of the node below.

:func:`compare` finds the pairs, :func:`refusals` what no run can take over, and :class:`Revision`
is the result of a revision, or of a dry run, for people and programs.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property
from typing import Any

from bt_mission.base.diagnostics import quoted
from bt_mission.base.text import escape_control
from bt_mission.language.checks.scope import written_by
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.follow import FollowSettings
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import NodeModel, Written
from bt_mission.language.nodes.composites import FinallyNode
from bt_mission.language.nodes.decorators import (
    ForceNode,
    ForEachNode,
    GuardNode,
    InvertNode,
    RetryNode,
    TimeoutNode,
)
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.nodes.subtree import TreeNode

TRANSPARENT = (TimeoutNode, GuardNode, InvertNode, ForceNode, RetryNode)
"""Kinds of decorator that may be put around a running node, or taken away."""

FIXED = ("world", "robot", "seed", "map", "nodes", "nature", "observe")
"""Keys at the head of a mission whose values are fixed when its run begins."""

_OTHER_FIELDS = ("place", "children", "child", "cleanup", "otherwise")
"""Fields that are not values of a node: its place, and the nodes below it."""


@dataclass(eq=False)
class BuiltNode:
    """A node of a tree as it is built, used trees included.

    Attributes:
        index: Its number, depth first.
        path: Its path, such as ``0.1``.
        part: Its number among the nodes below its parent.
        twin: The same node in the other version; None without one.
        is_changed: Whether its values differ from those of its twin.
    """

    index: int
    path: str
    node: NodeModel
    parent: BuiltNode | None
    part: int
    below: list[BuiltNode] = field(default_factory=list)
    twin: BuiltNode | None = None
    is_changed: bool = False

    def __post_init__(self) -> None:
        self.kind: Hashable = _kind_of(type(self.node))(self.node)
        """Nodes of different kinds are never the same node."""
        self.label = self.node.label
        """Its name in the tree."""
        self._is_linked: bool | None = None

    @property
    def is_transparent(self) -> bool:
        """Whether it is a decorator that only one of the two versions has."""
        return self.twin is None and isinstance(self.node, TRANSPARENT)

    @property
    def anchor(self) -> BuiltNode | None:
        """The nearest node above it that is not transparent; None at the top."""
        node = self.parent
        while node is not None and node.is_transparent:
            node = node.parent
        return node

    @property
    def core(self) -> BuiltNode:
        """Itself, or the first node below it that is not transparent."""
        node = self
        while node.is_transparent:
            node = node.below[0]
        return node

    def part_below(self, above: BuiltNode) -> int:
        """Return the part of a node above it in which it is."""
        node = self
        while node.parent is not None and node.parent is not above:
            node = node.parent
        return node.part

    @property
    def is_linked(self) -> bool:
        """Whether it continues with the state of its twin: the nodes above are the same, too.

        It is asked once all pairs are known.
        """
        if self._is_linked is None:
            self._is_linked = self._links()
        return self._is_linked

    def _links(self) -> bool:
        if self.twin is None:
            return False
        above, before = self.anchor, self.twin.anchor
        if above is None or before is None:
            return above is before
        if above.twin is not before or not above.is_linked:
            return False
        is_in_part = self.part_below(above) == self.twin.part_below(before)
        return is_in_part or not isinstance(above.node, FinallyNode)


@cache
def _kind_of(kind: type[NodeModel]) -> Callable[[Any], Hashable]:
    """Return what gives the kind of a node of a class."""
    if issubclass(kind, TreeNode):
        return lambda node: (kind, node.tree)
    if issubclass(kind, ForEachNode):
        return lambda node: (kind, node.variable)
    if issubclass(kind, PythonNode):
        return lambda node: (kind, node.target)
    if issubclass(kind, InterfaceNode):
        return lambda node: (kind, node.ros_name, node.type)
    return lambda _: kind


@dataclass(frozen=True)
class RevisedNode:
    """A node of a revision.

    Attributes:
        path: Its path in the new tree; of a node that is gone, in the old one.
        was: Its path in the old tree, if that is another one.
        change: The values that differ.
    """

    name: str
    path: str
    was: str = ""
    change: str = ""

    def __str__(self) -> str:
        moved = f", was {self.was}" if self.was else ""
        change = f": {self.change}" if self.change else ""
        return escape_control(f"{self.name} ({self.path}{moved}){change}")


@dataclass(frozen=True)
class Revision:
    """The result of a revision of a running mission, or of a dry run.

    Attributes:
        mission: The name of the mission.
        is_applied: Whether the running mission is the new version from now on.
        reasons: Why it was refused, or would be; empty otherwise.
        stays: The nodes that stay as they are.
        changes: The nodes with other values.
        new: The nodes that only the new version has.
        gone: The nodes that only the running version has.
        continues: The names of leaves whose goals continue.
        cancels: The names of leaves whose goals are cancelled.
        restarts: The names of leaves that run, and start again.
        number: The number of revisions applied to this run so far.
    """

    mission: str
    is_applied: bool = False
    reasons: tuple[str, ...] = ()
    stays: tuple[RevisedNode, ...] = ()
    changes: tuple[RevisedNode, ...] = ()
    new: tuple[RevisedNode, ...] = ()
    gone: tuple[RevisedNode, ...] = ()
    continues: tuple[str, ...] = ()
    cancels: tuple[str, ...] = ()
    restarts: tuple[str, ...] = ()
    number: int = 0

    @property
    def is_refused(self) -> bool:
        """Whether the running mission cannot become the new version now."""
        return bool(self.reasons)

    @property
    def counts(self) -> str:
        """The numbers of nodes, as text."""
        numbers = {
            "changed": len(self.changes),
            "new": len(self.new),
            "gone": len(self.gone),
            "unchanged": len(self.stays),
        }
        return ", ".join(f"{number} {name}" for name, number in numbers.items())

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, ready for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Revision:
        """Return the revision of :meth:`as_dict`.

        Raises:
            KeyError: A field is missing.
            TypeError: A field has another form.
        """
        nodes = ("stays", "changes", "new", "gone")
        texts = ("reasons", "continues", "cancels", "restarts")
        fields: dict[str, Any] = {
            **{name: tuple(RevisedNode(**node) for node in data[name]) for name in nodes},
            **{name: tuple(map(str, data[name])) for name in texts},
        }
        is_applied, number = data["is_applied"] is True, int(data["number"])
        return cls(str(data["mission"]), is_applied, number=number, **fields)

    def as_text(self) -> str:
        """Return the revision as lines for people."""
        signs = (("~", self.changes), ("+", self.new), ("-", self.gone))
        lines = [f"  {sign} {node}" for sign, nodes in signs for node in nodes]
        for words, names in (
            ("continues", self.continues),
            ("is cancelled", self.cancels),
            ("starts again", self.restarts),
        ):
            lines += [f"  {escape_control(quoted(name))} runs and {words}" for name in names]
        state = "applied" if self.is_applied else "refused" if self.reasons else "can be applied"
        head = f"{escape_control(self.mission)}: {self.counts}"
        reasons = [f"  {escape_control(reason)}" for reason in self.reasons]
        return "\n".join([head, *lines, state + (":" if reasons else ""), *reasons])


@dataclass(frozen=True)
class MissionComparison:
    """Two versions of a mission with the pairs of the same nodes.

    Attributes:
        before: The running mission.
        after: The new version, with the inputs, seed and world of the running one.
        old: The nodes of the running tree, depth first.
        new: Those of the new tree.
    """

    before: Mission
    after: Mission
    old: tuple[BuiltNode, ...]
    new: tuple[BuiltNode, ...]

    def revision(self) -> Revision:
        """Return the nodes that stay, change, are new and are gone."""
        groups: dict[str, list[RevisedNode]] = {"stays": [], "changes": [], "new": []}
        for built in self.new:
            twin = built.twin
            if twin is None:
                groups["new"].append(RevisedNode(built.label, built.path))
                continue
            was = twin.path if twin.path != built.path else ""
            change = _difference(twin.node, built.node) if built.is_changed else ""
            name = "changes" if built.is_changed else "stays"
            groups[name].append(RevisedNode(built.label, built.path, was, change))
        gone = [RevisedNode(node.label, node.path) for node in self.old if node.twin is None]
        return Revision(
            self.after.name,
            stays=tuple(groups["stays"]),
            changes=tuple(groups["changes"]),
            new=tuple(groups["new"]),
            gone=tuple(gone),
        )

    @cached_property
    def lost_variables(self) -> frozenset[str]:
        """The mission's variables that the new version does not have."""
        if self.before.trees or self.after.trees:
            return frozenset(_variables(self.before) - _variables(self.after))
        heads = _head_variables(self.before)
        ends = (node.node for node in self.old if node.twin is None or node.is_changed)
        perhaps = heads.union(*map(_node_variables, ends))
        if perhaps <= _head_variables(self.after):
            return frozenset()
        return frozenset(perhaps - _variables(self.after))


def built_nodes(mission: Mission) -> tuple[BuiltNode, ...]:
    """Return the nodes of a mission's tree as it is built, depth first."""
    nodes: list[BuiltNode] = []
    waiting: list[tuple[NodeModel, str, BuiltNode | None, int]] = [(mission.root, "0", None, 0)]
    while waiting:
        node, path, parent, part = waiting.pop()
        built = BuiltNode(len(nodes), path, node, parent, part)
        nodes.append(built)
        if parent is not None:
            parent.below.append(built)
        if children := mission.below(node):
            below = [
                (child, f"{path}.{number}", built, number) for number, child in enumerate(children)
            ]
            waiting += reversed(below)
    return tuple(nodes)


def compare(before: Mission, after: Mission) -> MissionComparison:
    """Find the nodes that both versions of a mission have.

    Args:
        before: The running mission.
        after: The new version as its file has it; its inputs take the values of the run.
    """
    old, new = built_nodes(before), built_nodes(after)
    _pair_names(old, new)
    if old[0].twin is None and new[0].twin is None and old[0].kind == new[0].kind:
        _pair(old[0], new[0], is_changed=not _is_same(old[0].node, new[0].node))
    _pair_below([old[0]], [new[0]])
    for node in new:
        if node.twin is not None:
            _pair_below(node.twin.below, node.below)
    given = {name: before.inputs[name] for name in after.inputs if name in before.inputs}
    kept = replace(
        after,
        inputs={**after.inputs, **given},
        seed=before.seed,
        world=before.world,
        robot=before.robot,
        nodes=before.nodes,
        nature=before.nature,
        requirements=before.requirements,
        observe=before.observe,
    )
    return MissionComparison(before, kept, old, new)


def refusals(before: Mission, after: Mission) -> Iterator[str]:
    """Yield why a running mission cannot become another version, whatever its state.

    Args:
        before: The running mission, or the newest version of it.
        after: The new version as its file has it.
    """
    if before.name != after.name:
        yield f"it is another mission: {quoted(after.name)} instead of {quoted(before.name)}"
    old, new = _head(before), _head(after)
    for name in FIXED:
        if old.get(name) != new.get(name):
            yield f"'{name}' is fixed when a run begins: {_change(old.get(name), new.get(name))}"
    inputs, others = old.get("inputs") or {}, new.get("inputs") or {}
    for name in inputs:
        if name in others and inputs[name] != others[name]:
            change = _change(inputs[name], others[name])
            yield f"the value of the input '{name}' is fixed when a run begins: {change}"
    for tree, followed in _followed(after) - _followed(before):
        yield (
            f"'{followed.variable}'{tree} would follow a topic from now on, and could be read "
            "before its first message: give it an 'initial' value"
        )
    if old.get("requirements") != new.get("requirements"):
        yield "requirements are fixed when a run begins: their verdicts are about the whole run"


# ---- pairs ---------------------------------------------------------------------------------


def _pair(old: BuiltNode, new: BuiltNode, *, is_changed: bool) -> None:
    old.twin, new.twin = new, old
    new.is_changed = old.is_changed = is_changed


def _pair_names(old: Sequence[BuiltNode], new: Sequence[BuiltNode]) -> None:
    """Pair the nodes whose names occur once in each version."""

    def named(nodes: Iterable[BuiltNode]) -> dict[str, BuiltNode]:
        with_names = [node for node in nodes if node.node.name]
        counts = Counter(node.node.name for node in with_names)
        return {node.node.name: node for node in with_names if counts[node.node.name] == 1}

    known = named(old)
    for name, node in named(new).items():
        if name in known and known[name].kind == node.kind:
            _pair(known[name], node, is_changed=not _is_same(known[name].node, node.node))


def _pair_below(old: Sequence[BuiltNode], new: Sequence[BuiltNode]) -> None:
    """Pair the nodes below two nodes that are the same, also those within decorators."""
    if len(old) == len(new) and all(map(_are_alike, old, new)):
        for first, second in zip(old, new, strict=True):
            if second.twin is None:
                _pair(first, second, is_changed=False)
        return
    before, after = _reachable(old), _reachable(new)
    _pair_by(before, after, lambda node: (node.kind, node.label), is_same=True)
    _pair_by(before, after, lambda node: (node.kind, node.label), is_same=False)
    _pair_by(before, after, lambda node: None if node.node.name else node.kind, is_same=False)
    _pair_by(before, after, lambda node: (node.kind, node.path), is_same=False)


def _reachable(nodes: Iterable[BuiltNode]) -> list[BuiltNode]:
    """Return nodes without a twin, and those within decorators that may be new or gone."""
    reached = []
    for first in nodes:
        node = first
        while node.twin is None:
            reached.append(node)
            if not isinstance(node.node, TRANSPARENT):
                break
            node = node.below[0]
    return reached


def _pair_by(
    old: Iterable[BuiltNode],
    new: Iterable[BuiltNode],
    key: Callable[[BuiltNode], Hashable | None],
    *,
    is_same: bool,
) -> None:
    """Pair nodes with equal keys in their order; with `is_same`, only those of equal values."""
    waiting: defaultdict[Hashable, deque[BuiltNode]] = defaultdict(deque)
    for node in old:
        if node.twin is None and (group := key(node)) is not None:
            waiting[group].append(node)
    for node in new:
        group = key(node)
        if node.twin is not None or group is None:
            continue
        for candidate in waiting[group]:
            is_changed = not _is_same(candidate.node, node.node)
            if not (is_same and is_changed):
                waiting[group].remove(candidate)
                _pair(candidate, node, is_changed=is_changed)
                break


def _are_alike(old: BuiltNode, new: BuiltNode) -> bool:
    """Whether two nodes are a pair, or without twins and equal."""
    if old.twin is not None or new.twin is not None:
        return new.twin is old
    return old.kind == new.kind and old.label == new.label and _is_same(old.node, new.node)


@cache
def _value_fields(kind: type[NodeModel]) -> tuple[str, ...]:
    return tuple(name for name in kind.model_fields if name not in _OTHER_FIELDS)


def _is_same(old: NodeModel, new: NodeModel) -> bool:
    for name in _value_fields(type(new)):
        before, after = getattr(old, name), getattr(new, name)
        if before is not after and not _equal(before, after):
            return False
    return True


_PLAIN = (bool, int, float, str)


def _equal(old: Any, new: Any) -> bool:
    """Compare values. An expression with the same text may mean another place of the map."""
    kind = type(old)
    if kind in _PLAIN:
        return bool(old == new)
    if kind is dict and type(new) is dict:
        return old.keys() == new.keys() and all(_equal(old[key], new[key]) for key in old)
    if isinstance(old, Expression) and isinstance(new, Expression):
        return old == new and old.root == new.root
    if isinstance(old, list | tuple) and isinstance(new, list | tuple):
        return len(old) == len(new) and all(map(_equal, old, new))
    if isinstance(old, Written) and type(old) is type(new):
        return all(
            _equal(getattr(old, name), getattr(new, name)) for name in type(old).model_fields
        )
    return bool(old == new)


def _difference(old: NodeModel, new: NodeModel) -> str:
    """Return what differs in the values of two nodes, in the words of their author."""
    if old.label != new.label:
        return f"was {quoted(old.label)}"
    before, after = old.details(), new.details()
    lost = [line for line in before if line not in after]
    added = [line for line in after if line not in before]
    if isinstance(old, GoalNode) and not lost and not added:
        return "other limits"
    return _change(", ".join(lost), ", ".join(added))


def _change(before: Any, after: Any) -> str:
    old, new = ("none" if value in (None, "") else value for value in (before, after))
    return f"{old} -> {new}"


def _head(mission: Mission) -> Mapping[str, Any]:
    data = mission.document.data
    return data if isinstance(data, dict) else {}


def _followed(mission: Mission) -> set[tuple[str, FollowSettings]]:
    """Return what follows a topic and has no value at first, with the tree that it is in."""
    trees = [("", mission.follow)]
    trees += [(f" in '{name}'", tree.follow) for name, tree in mission.trees.items()]
    return {
        (name, follow.settings)
        for name, follows in trees
        for follow in follows
        if follow.settings.initial is None
    }


def _variables(mission: Mission) -> set[str]:
    return _head_variables(mission).union(*map(_node_variables, mission.tree.walk()))


def _head_variables(mission: Mission) -> set[str]:
    return {*mission.inputs, *(followed.variable for followed in mission.follow)}


def _node_variables(node: NodeModel) -> tuple[str, ...]:
    return (node.variable,) if isinstance(node, ForEachNode) else written_by(node)
