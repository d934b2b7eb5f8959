"""The coverage that one run of a mission reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.events.events import Event, NodeChanged, TreeRevised
from bt_mission.executive.executive import Executive
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.composites import WhenNode
from bt_mission.language.nodes.decorators import ForEachNode, GuardNode, TimeoutNode
from bt_mission.language.nodes.leaves import CheckNode
from bt_mission.scenarios.coverage.places import (
    BRANCH,
    CHOOSING,
    EMPTY,
    EXPIRED,
    FALSE,
    OUTCOME,
    REACHED,
    TRUE,
    Built,
    CoveragePlace,
    branches,
    built,
)


class CoverageWatch:
    """Counts the places that one run of a mission reaches.

    Args:
        places: The places by the identity of the node's step. Each mark that is reached gets a run.
    """

    def __init__(
        self, mission: Mission, executive: Executive, places: Mapping[int, CoveragePlace]
    ) -> None:
        self._executive = executive
        self._places = places
        self._built = {place.node: place for place in built(mission, executive.root)}
        self._visited: set[Behaviour] = set()
        self._seen: set[tuple[Behaviour, str]] = set()
        executive.tick_wrappers.append(self._follow)
        executive.events.subscribe(self._take)

    def _follow(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        for node in walk:
            visited = self._built.get(node)
            if visited is not None:
                self._visit(visited)
            yield node

    def _visit(self, visited: Built) -> None:
        """A tick has been at a node."""
        if visited.node not in self._visited:
            self._visited.add(visited.node)
            self._reach(visited, REACHED)
            if visited.above is not None:
                way = _way_to(visited)
                if way:
                    self._reach(visited.above, f"{BRANCH}{way}")
        if visited.node.status in (Status.SUCCESS, Status.FAILURE):
            if _went_nowhere(visited):
                self._reach(visited, f"{BRANCH}{FALSE}")
            outcome = _outcome(visited)
            if outcome:
                self._reach(visited, f"{OUTCOME}{outcome}")

    def _take(self, event: Event) -> None:
        """Note goals that the tree halts. The end of a test is not such a halt.

        After a revision, nodes are others than those of the places: nothing more is counted.
        """
        if isinstance(event, TreeRevised):
            self._built.clear()
        if not isinstance(event, NodeChanged) or event.status is not Status.INVALID:
            return
        node = self._executive.nodes[event.node]
        if not isinstance(node, ActionLeaf):
            return
        if node.was_halted and self._executive.status.is_active:
            halted = self._built.get(node)
            outcome = "" if halted is None else _outcome(halted)
            if halted is not None and outcome:
                self._reach(halted, f"{OUTCOME}{outcome}")

    def _reach(self, reached: Built, mark: str) -> None:
        marks = self._places[id(reached.step)].marks
        if (reached.node, mark) not in self._seen and mark in marks:
            self._seen.add((reached.node, mark))
            marks[mark] += 1


def _way_to(visited: Built) -> str:
    """Return the branch of the parent that leads to a node; empty if the parent does not choose."""
    above = visited.above
    assert above is not None
    if isinstance(above.step, CHOOSING):
        return branches(above.step)[visited.number]
    if isinstance(above.step, WhenNode | GuardNode):
        return FALSE if visited.number else TRUE
    return ""


def _went_nowhere(ended: Built) -> bool:
    """Return whether a condition that is false has kept a node from running its child."""
    children = ended.node.children
    if isinstance(ended.step, WhenNode):
        return len(children) == 1 and children[0].status is Status.INVALID
    if isinstance(ended.step, GuardNode):
        return children[0].status is Status.INVALID
    return False


def _outcome(ended: Built) -> str:
    """Return the outcome of a node that has just ended."""
    node, step = ended.node, ended.step
    if isinstance(node, ActionLeaf):
        ending = node.attempt.ending if node.attempt else None
        return str(ending.outcome) if ending else ""
    has_failed = node.status is Status.FAILURE
    if isinstance(step, CheckNode):
        return FALSE if has_failed else TRUE
    if isinstance(step, TimeoutNode) and has_failed:
        return "failure" if node.children[0].status is Status.FAILURE else EXPIRED
    if isinstance(step, ForEachNode) and not has_failed:
        return "success" if node.children[0].status is Status.SUCCESS else EMPTY
    return "failure" if has_failed else "success"
