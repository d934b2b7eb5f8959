"""Which loops and deadlines are abstract: those whose counts and instants do not tell states apart.

A loop is long when its number of rounds is unknown or large. It may end after any round. A
deadline that runs while a long loop turns may be met at any tick, because the time that the loop
takes is not bounded. All runs are among those that are explored. Some that are explored may not
exist, such as one in which a deadline is met earlier than it can be.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any, TypeAlias

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.prove.choices import NOTHING, Possibility
from bt_mission.commands.prove.clients import AnyBehaviour
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import WaitFor
from bt_mission.executive.behaviours.control import Parallel, Timeout
from bt_mission.executive.behaviours.decorators import Repeat, Retry
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.leaves import Set, Wait
from bt_mission.executive.behaviours.runtime import MissionFailure
from bt_mission.language.expressions.expression import draws
from bt_mission.language.nodes.fields import TIMES

NEVER_NS = 2**62
MANY_ROUNDS = 10
"""A loop with more rounds is long."""
ROUNDS_OF_CUT = 2

Loose: TypeAlias = Wait | Timeout | ActionLeaf
"""A node with an abstract deadline: of an action, that of its goal."""


def loose_deadlines(
    nodes: Iterable[Behaviour], evaluators: Mapping[Behaviour, Evaluator]
) -> list[Loose]:
    """Return the nodes whose deadlines run while a long loop turns."""
    nodes = list(nodes)
    long = {node for node in nodes if rounds_of(node, evaluators) > MANY_ROUNDS}
    return [
        node
        for node in nodes
        if isinstance(node, Loose)
        and not (isinstance(node, ActionLeaf) and evaluators[node].node.timeout is None)
        and any(other in long for other in _meanwhile(node))
    ]


def lone_leaves(nodes: Iterable[Behaviour]) -> set[Behaviour]:
    """Return the leaves beside which nothing else runs.

    While the limit of such a leaf is the only one that runs, no other deadline can begin before it
    is over. The remaining time makes no difference then, up to the last tick.
    """
    return {
        node
        for node in nodes
        if not node.children and not any(isinstance(above, Parallel) for above in _above(node))
    }


def unlimited_leaves(
    nodes: Iterable[Behaviour], evaluators: Mapping[Behaviour, Evaluator]
) -> list[Behaviour]:
    """Return the leaves that wait for an answer without a limit, their own or one above them."""
    return [
        node
        for node in nodes
        if isinstance(node, ActionLeaf | WaitFor | AnyBehaviour)
        and getattr(evaluators[node].node, "timeout", None) is None
        and not any(_limits(above, node) for above in _above(node))
    ]


def _limits(above: Behaviour, leaf: Behaviour) -> bool:
    if isinstance(above, Finally):
        return leaf in above.cleanup.iterate()
    return isinstance(above, Timeout)


def is_between_rounds(node: Behaviour) -> bool:
    """Does a loop begin its next round with the next tick?"""
    is_running = node.status is Status.RUNNING and isinstance(node, Repeat)
    return is_running and node.children[0].status is not Status.RUNNING


def keep_open(node: Loose) -> None:
    """Put the abstract deadline of a running node off; called behind each tick."""
    if is_limited(node):
        meet(node, NEVER_NS)


def meet(node: Loose, at_ns: int) -> None:
    """Have the abstract deadline of a running node met at an instant."""
    if isinstance(node, ActionLeaf):
        assert node.attempt is not None
        node.attempt.move_goal_limit(at_ns)
    else:
        node.due_ns = at_ns


def is_limited(node: Loose) -> bool:
    """Is the abstract deadline of a node running?"""
    if node.status is not Status.RUNNING or not isinstance(node, ActionLeaf):
        return node.status is Status.RUNNING
    attempt = node.attempt
    return attempt is not None and "goal" in attempt.limits_due


def rounds_of(node: Behaviour, evaluators: Mapping[Behaviour, Evaluator]) -> float:
    """Return the most rounds of a loop, infinite if that is not known; 0 for another node."""
    if not isinstance(node, Repeat | Retry):
        return 0
    values = evaluators[node]
    settings = values.node.settings
    count = settings.count if isinstance(node, Repeat) else settings.attempts
    if count is None or draws(count):
        return math.inf
    try:
        return values.number(count, TIMES)
    except MissionFailure:  # it depends on variables that have no value yet
        return math.inf


def is_folded(node: Repeat) -> bool:
    """May the rounds of a loop be taken as alike? Not where they compute values."""
    return not any(isinstance(inner, Set) for inner in node.iterate())


def _above(node: Behaviour) -> Iterator[Behaviour]:
    parent = node.parent
    while parent is not None:
        yield parent
        parent = parent.parent


def _meanwhile(node: Loose) -> Iterator[Behaviour]:
    """Yield the nodes that may run while a deadline runs."""
    if isinstance(node, Timeout):
        yield from node.iterate()
    child: Behaviour = node
    while child.parent is not None:
        if isinstance(child.parent, Parallel):
            for sibling in child.parent.children:
                if sibling is not child:
                    yield from sibling.iterate()
        child = child.parent


class BoundedRepeat(Repeat):
    """A repeat whose count is bounded; one with a condition keeps its rounds.

    A large count is open, so that it may end after any round. It is cut instead where a bound
    is given, and where rounds compute values.
    """

    _environment: Any
    _is_open = False

    def setup(self, **kwargs: Any) -> None:
        """Take the environment."""
        super().setup(**kwargs)
        self._environment = kwargs["runtime"]

    def enter(self) -> Status | None:
        """Cut the count at entry."""
        status = super().enter()
        environment, count = self._environment, self._count
        most = MANY_ROUNDS if environment.rounds is None else environment.rounds
        if most and count and count > most and not self._node.settings.has_condition:
            if environment.rounds is None and is_folded(self):
                environment.opened[self.name] = count
                self._count, self._is_open = None, True
            else:
                environment.cut[self.name] = count
                self._count = environment.rounds or ROUNDS_OF_CUT
        return status

    def _after_round(self) -> Status:
        """Choose whether it was the last round."""
        if self._is_open and self._environment.choices.choose(self._last_or_not):
            self._count, self._is_open = self._done, False
        return super()._after_round()

    @cached_property
    def _last_or_not(self) -> tuple[Possibility, ...]:
        return NOTHING, Possibility(f"'{self.name}' has done its rounds")
