"""The places of a mission: its nodes, the ways each can end, and the branches each can choose.

Only what can happen is a place: a leaf without a limit is never cancelled by one, and a sequence of
nodes that never fail does not fail.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from py_trees.behaviour import Behaviour

from bt_mission.base.yaml.document import Document
from bt_mission.language.checks.warnings import ends_of
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.base import Ends, NodeModel
from bt_mission.language.nodes.composites import (
    ChooseNode,
    FallbackNode,
    InTurnNode,
    ParallelNode,
    WhenNode,
)
from bt_mission.language.nodes.decorators import ForEachNode, GuardNode, TimeoutNode
from bt_mission.language.nodes.leaves import CheckNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.language.outcome import Outcome

REACHED, OUTCOME, BRANCH = "reached", "outcome ", "branch "
"""Marks of a place; those of an outcome and of a branch continue with its name."""

TRUE, FALSE = "true", "false"
EXPIRED = "expired"
EMPTY = "empty list"

ALWAYS_POSSIBLE = (
    Outcome.SUCCEEDED,
    Outcome.ABORTED,
    Outcome.REJECTED,
    Outcome.CANCELED_FROM_OUTSIDE,
    Outcome.NO_SERVER,
    Outcome.NO_ANSWER,
    Outcome.SERVER_LOST,
)
"""Ways in which the server of any goal can end it, or leave it."""

CHOOSING = (FallbackNode, ParallelNode, ChooseNode)
"""Kinds of which each child is a branch."""


@dataclass
class CoveragePlace:
    """A node of a mission, its marks, and the number of runs that reached each mark.

    Attributes:
        tree: The named tree of the node; empty for the mission's main tree.
        path: The place in its tree, such as ``0.1.0``.
        line: Line in its file, from 1.
        marks: Runs by mark: ``reached``, ``outcome NAME`` for each way in which the node can end,
            ``branch NAME`` for each branch that it can choose.
    """

    tree: str
    path: str
    name: str
    kind: str
    line: int
    column: int
    marks: dict[str, int]

    @property
    def key(self) -> tuple[int, int, str]:
        """A key that is unique in its file.

        In XML, an element can stand for two nodes of different kinds.
        """
        return self.line, self.column, self.kind

    @property
    def label(self) -> str:
        """The place in the tree and the name: ``0.1 drive``, of a named tree ``half:0.1 drive``."""
        return f"{self.tree}:{self.path} {self.name}" if self.tree else f"{self.path} {self.name}"

    @property
    def depth(self) -> int:
        """The number of nodes above it in its tree."""
        return self.path.count(".")

    @property
    def runs(self) -> int:
        """In how many runs the node was reached."""
        return self.marks[REACHED]

    @property
    def outcomes(self) -> dict[str, int]:
        """Runs by outcome."""
        return self._marked(OUTCOME)

    @property
    def branches(self) -> dict[str, int]:
        """Runs by branch."""
        return self._marked(BRANCH)

    def _marked(self, kind: str) -> dict[str, int]:
        return {
            mark.removeprefix(kind): runs
            for mark, runs in self.marks.items()
            if mark.startswith(kind)
        }

    @property
    def missing(self) -> list[str]:
        """Outcomes and branches that no run has had."""
        return [name for part in (self.outcomes, self.branches) for name in part if not part[name]]


def places(mission: Mission) -> Iterator[tuple[Document, NodeModel, CoveragePlace]]:
    """Yield every node of a mission and of its named trees, used or unused.

    The order depends only on the trees of the mission, not on its inputs, its seed or the machine.
    """
    uses = _ends_of_trees(mission)
    halted = _trees_halted(mission)
    for tree in mission.all_trees:
        name = "" if tree.is_main else tree.name
        ends = ends_of(tree.body, uses)
        for step, path, can_halt in _descend(tree, ends, halted=name in halted):
            marks = [
                REACHED,
                *(f"{OUTCOME}{outcome}" for outcome in _outcomes(step, ends, can_halt=can_halt)),
                *(f"{BRANCH}{branch}" for branch in branches(step)),
            ]
            counts = dict.fromkeys(marks, 0)
            yield (
                tree.document,
                step,
                CoveragePlace(name, path, step.label, step.kind, step.line, step.column, counts),
            )


def branches(step: NodeModel) -> list[str]:
    """Return the branches of a node, children in their order."""
    match step:
        case FallbackNode() | ParallelNode() | ChooseNode():
            return [f"{number} {child.label}" for number, child in enumerate(step.children, 1)]
        case WhenNode() | GuardNode():
            if isinstance(step.condition, bool):
                return [TRUE if step.condition else FALSE]
            return [TRUE, FALSE]
    return []


def _outcomes(step: NodeModel, ends: Mapping[int, Ends], *, can_halt: bool) -> list[str]:
    match step:
        case GoalNode():
            return [str(outcome) for outcome in _of_goal(step, can_halt=can_halt)]
        case CheckNode():
            return [{"success": TRUE, "failure": FALSE}[end] for end in _both(ends[id(step)])]
        case TimeoutNode():
            return [*_both(ends[id(step.child)]), EXPIRED]
        case ForEachNode(elements=list() | tuple() as elements):
            return _both(ends[id(step)]) if elements else [EMPTY]
        case ForEachNode():
            return [*_both(ends[id(step)]), EMPTY]
    return _both(ends[id(step)])


def _both(ends: Ends) -> list[str]:
    return [end for end in ("success", "failure") if end in ends]


def _of_goal(step: GoalNode, *, can_halt: bool) -> Iterator[Outcome]:
    """The outcomes that this leaf's goals can have, in the order of the closed list."""
    limits = {
        Outcome.CANCELED_BY_CONDITION: step.cancel_when is not None,
        Outcome.CANCELED_BY_TIMEOUT: step.timeout is not None,
        Outcome.SILENT: step.feedback_timeout is not None,
        Outcome.CANCELED_BY_HALT: can_halt,
    }
    asks = limits[Outcome.CANCELED_BY_CONDITION] or step.timeout or step.feedback_timeout
    after_cancel = (Outcome.SUCCEEDED_LATE, Outcome.CANCEL_REFUSED, Outcome.UNCONFIRMED)
    limits |= dict.fromkeys(after_cancel, bool(asks))
    return (outcome for outcome in Outcome if outcome in ALWAYS_POSSIBLE or limits.get(outcome))


# ---- which nodes can be halted ---------------------------------------------------------------


def _descend(
    tree: Tree, ends: Mapping[int, Ends], *, halted: bool
) -> Iterator[tuple[NodeModel, str, bool]]:
    """Every step with its path, and whether something above can halt it while it runs."""
    waiting = [(tree.body, "0", halted)]
    while waiting:
        step, path, can_halt = waiting.pop()
        yield step, path, can_halt
        below = [
            (child, f"{path}.{index}", can_halt or _halts(step, index, ends))
            for index, child in enumerate(step.below)
        ]
        waiting += reversed(below)


def _halts(step: NodeModel, index: int, ends: Mapping[int, Ends]) -> bool:
    match step:
        case TimeoutNode():
            return True
        case GuardNode():
            return step.condition is not True
        case InTurnNode():
            return not step.memory and index > 0
        case ParallelNode():
            others = [ends[id(child)] for n, child in enumerate(step.children) if n != index]
            decides = step.succeed_when != "all" or any("failure" in ending for ending in others)
            return step.rest == "halt" and bool(others) and decides
    return False


def _trees_halted(mission: Mission) -> set[str]:
    """The named trees of which some use can be halted."""
    uses = _ends_of_trees(mission)
    halted_trees: set[str] = set()
    grown = True
    while grown:
        before = len(halted_trees)
        for tree in mission.all_trees:
            name = "" if tree.is_main else tree.name
            ends = ends_of(tree.body, uses)
            for step, _, can_halt in _descend(tree, ends, halted=name in halted_trees):
                if can_halt and isinstance(step, TreeNode):
                    halted_trees.add(step.tree)
        grown = len(halted_trees) > before
    return halted_trees


def _ends_of_trees(mission: Mission) -> dict[str, Ends]:
    """Return how the named trees end; a tree is computed after the trees that it uses."""
    ends: dict[str, Ends] = {}
    waiting = list(mission.trees.values())
    while waiting:
        tree = waiting.pop(0)
        used = {step.tree for step in tree.body.walk() if isinstance(step, TreeNode)}
        if used <= ends.keys():
            ends[tree.name] = ends_of(tree.body, ends)[id(tree.body)]
        else:
            waiting.append(tree)
    return ends


# ---- nodes of a tree that was built --------------------------------------------------------


@dataclass(frozen=True)
class Built:
    """A node of a tree, with the step that it was made of.

    Args:
        above: The node whose child it is.
        number: Its place among the children of that node, from 0.
    """

    node: Behaviour
    step: NodeModel
    document: Document
    above: Built | None
    number: int


def built(mission: Mission, root: Behaviour) -> Iterator[Built]:
    """Every node of a mission's tree, beside its step."""
    waiting = [Built(root, mission.root, mission.main.document, None, 0)]
    while waiting:
        current = waiting.pop()
        yield current
        if isinstance(current.step, TreeNode):
            tree = mission.trees[current.step.tree]
            waiting.append(Built(current.node.children[0], tree.body, tree.document, current, 0))
        else:
            waiting += [
                Built(node, step, current.document, current, number)
                for number, (step, node) in enumerate(
                    zip(current.step.below, current.node.children, strict=False)
                )
            ]
