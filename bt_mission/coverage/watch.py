"""Sees what one run of a mission reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.coverage.places import (
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
from bt_mission.events.events import Event, NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import MissionStatus
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.composites import WhenNode
from bt_mission.language.nodes.decorators import ForEachNode, GuardNode, TimeoutNode
from bt_mission.language.nodes.leaves import CheckNode


class CoverageWatch:
    """Counts what one run of a mission reaches.

    Args:
        places: Get a run for each mark that is reached, by the identity of the node's step.
    """

    def __init__(
        self, mission: Mission, executive: Executive, places: Mapping[int, CoveragePlace]
    ) -> None:
        self._executive = executive
        self._places = places
        self._built = {one.node: one for one in built(mission, executive.root)}
        self._visited: set[Behaviour] = set()
        self._seen: set[tuple[Behaviour, str]] = set()
        executive.tick_wrappers.append(self._follow)
        executive.events.subscribe(self._take)

    def _follow(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        for node in walk:
            one = self._built.get(node)
            if one is not None:
                self._visit(one)
            yield node

    def _visit(self, one: Built) -> None:
        """A tick has been at a node."""
        if one.node not in self._visited:
            self._visited.add(one.node)
            self._reach(one, REACHED)
            if one.above is not None:
                way = _way_to(one)
                if way:
                    self._reach(one.above, f"{BRANCH}{way}")
        if one.node.status in (Status.SUCCESS, Status.FAILURE):
            if _went_nowhere(one):
                self._reach(one, f"{BRANCH}{FALSE}")
            outcome = _outcome(one)
            if outcome:
                self._reach(one, f"{OUTCOME}{outcome}")

    def _take(self, event: Event) -> None:
        """Goals that the tree halts are seen here; the end of a test is no such halt."""
        if not isinstance(event, NodeChanged) or event.status is not Status.INVALID:
            return
        node = self._executive.nodes[event.node]
        if not isinstance(node, ActionLeaf):
            return
        if node.was_halted and self._executive.status is MissionStatus.RUNNING:
            one = self._built[node]
            outcome = _outcome(one)
            if outcome:
                self._reach(one, f"{OUTCOME}{outcome}")

    def _reach(self, one: Built, mark: str) -> None:
        marks = self._places[id(one.step)].marks
        if (one.node, mark) not in self._seen and mark in marks:
            self._seen.add((one.node, mark))
            marks[mark] += 1


def _way_to(one: Built) -> str:
    """The branch of the node above that leads to this one, if that chooses."""
    above = one.above
    assert above is not None
    if isinstance(above.step, CHOOSING):
        return branches(above.step)[one.number]
    if isinstance(above.step, WhenNode | GuardNode):
        return FALSE if one.number else TRUE
    return ""


def _went_nowhere(one: Built) -> bool:
    """Has a condition that does not hold kept a node from going on?"""
    children = one.node.children
    if isinstance(one.step, WhenNode):
        return len(children) == 1 and children[0].status is Status.INVALID
    if isinstance(one.step, GuardNode):
        return children[0].status is Status.INVALID
    return False


def _outcome(one: Built) -> str:
    """What came of a node that has just ended."""
    node, step = one.node, one.step
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
