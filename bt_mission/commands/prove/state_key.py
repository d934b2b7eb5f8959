"""What the future of a mission depends on, as plain values that `marshal` writes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.prove.clients import AnyBehaviour
from bt_mission.commands.prove.liveness import SERVERS, LiveVariables, Names
from bt_mission.commands.prove.offered import OfferedClients
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import ServiceLeaf
from bt_mission.executive.behaviours.control import Parallel, Pick, Selector, Sequence
from bt_mission.executive.behaviours.decorators import Repeat, Retry, Subtree
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.snapshot import save
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.goal import Goal, Phase
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.status import MissionStatus
from bt_mission.language.expressions.values import NoValue

LOST = -2
"""In place of the number of a goal that is given up: which one it is changes nothing."""


ORPHANED = "orphaned goals"
"""Begins the list of goals in the reason of a mission that leaves some behind."""
_TAKEN = re.compile(r", -?[0-9.e+]+ s after its acceptance")


class StateKeys:
    """Writes the parts of the present state that its future depends on, without its times.

    Args:
        executive: Runs the mission.
        ledger: Keeps its goals.
        evaluators: Of its nodes.
        clients: What answers it.

    Attributes:
        keeps_all: Do the variables count, too, that nobody reads any more, and lost goals?
        finals: The nodes with a clean-up.
        subtrees: The nodes of named trees, each with the nodes in it that have a clean-up.
    """

    def __init__(
        self,
        executive: Executive,
        ledger: Ledger,
        evaluators: Mapping[Behaviour, Evaluator],
        clients: OfferedClients,
    ) -> None:
        self._executive, self._ledger, self._clients = executive, ledger, clients
        nodes, root = executive.nodes, executive.root
        self.keeps_all = False
        self.subtrees = [
            (node, [below for below in node.iterate() if isinstance(below, Finally)])
            for node in nodes
            if isinstance(node, Subtree)
        ]
        self._scope = evaluators[root].scope
        self.finals = [node for node in nodes if isinstance(node, Finally)]
        self._leaves = [node for node in nodes if isinstance(node, ActionLeaf)]
        self._callers = [node for node in nodes if isinstance(node, ServiceLeaf)]
        self._classes = [node for node in nodes if isinstance(node, AnyBehaviour)]
        self._live = LiveVariables(root, evaluators)
        self._note_tree = noter(root, executive.indices, self._live.read_in_cleanup)

    def untimed(self) -> tuple[Any, ...]:
        """Return the state of a mission that has not ended."""
        executive, ledger, clients = self._executive, self._ledger, self._clients
        tree: list[Any] = []
        self._note_tree(tree)
        held = ledger.open_goals
        numbers = numbers_of(held)
        names = self._live_names
        asked = None if names is None else names[SERVERS]
        read = None if names is None else names[id(self._scope)]
        return (
            str(executive.status),
            (str(executive.verdict), without_times(executive.reason)) if executive.reason else "",
            tuple(map(without_times, executive.cleanups.failures)),
            ledger.is_held,
            tuple(tree),
            values_key(self._scope.values, read),
            tuple([inner_key(node, finals, names) for node, finals in self.subtrees]),
            tuple([attempt_key(leaf, numbers) for leaf in self._leaves]),
            tuple([goal_key(goal, ledger) for goal in held if numbers[id(goal)] != LOST]),
            self.keeps_all and bool(self.lost_goals),
            tuple([server.key(numbers, asked) for server in clients.goal_servers]),
            tuple([service.key(asked) for service in clients.services]),
            tuple([leaf.answer_s for leaf in self._callers if leaf.status is Status.RUNNING]),
            tuple([topic.key for topic in clients.topics]),
            tuple([publisher.key(asked) for publisher in clients.publishers]),
            tuple([leaf.answer for leaf in self._classes if leaf.status is Status.RUNNING]),
        )

    @property
    def _live_names(self) -> Names | None:
        """The names of the variables and servers that count; None for all."""
        executive = self._executive
        is_running = executive.status is MissionStatus.RUNNING
        # The tree may wait for the first messages of what it follows.
        if self.keeps_all or (is_running and executive.root.status is not Status.RUNNING):
            return None
        detached = [node for node in self.finals if node.is_detached]
        return self._live.names(executive.running_nodes, detached)

    @property
    def lost_goals(self) -> set[int]:
        """The goals that are given up and that no server answers any more, by their `id`."""
        lost = {id(goal) for goal in self._ledger.open_goals if goal.phase is Phase.LOST}
        if lost:
            for server in self._clients.goal_servers:
                lost -= {id(entry.goal) for entry in server.answerable}
        return lost


def end_key(executive: Executive) -> tuple[str, str]:
    """Return how a mission has ended, but for goals that it leaves behind."""
    return "whole" if is_whole_end(executive) else str(executive.verdict), own_reason(executive)


def own_reason(executive: Executive) -> str:
    """Return why a mission has ended, apart from goals that it leaves behind."""
    return without_times(executive.reason).partition(ORPHANED)[0].removesuffix("; ")


def is_whole_end(executive: Executive) -> bool:
    """Has a mission ended with a success, but for goals that it leaves behind?"""
    is_cut = executive.verdict is MissionStatus.INTERRUPTED
    return executive.is_done and not is_cut and not own_reason(executive)


def noter(
    node: Behaviour,
    indices: Mapping[Behaviour, int],
    read_in_cleanup: Callable[[Finally], frozenset[str]],
) -> Callable[[list[Any]], None]:
    """Return what notes the status of a node, and its memory and the nodes below while it runs.

    A node that joins others may end by a failure that came before its last tick, so the
    failure is noted, too. Of a sequence or fallback with memory only the present child matters. A
    fallback has not reset the children that it has not reached; they are left out.

    Args:
        indices: The number of each node.
        read_in_cleanup: Returns the variables that a clean-up may read.
    """
    running, failure = Status.RUNNING, Status.FAILURE
    memory = _memory_of(node, read_in_cleanup)
    below = [(child, noter(child, indices, read_in_cleanup)) for child in node.children]
    final = node if isinstance(node, Finally) else None
    fallback = node if isinstance(node, Selector) else None
    is_joining = isinstance(node, Finally | Parallel)
    has_memory = isinstance(node, Sequence | Selector) and node.memory

    def note(tree: list[Any]) -> None:
        status = node.status
        tree.append(status._value_)
        if status is not running and (final is None or not final.is_detached):
            return
        if memory is not None:
            tree.append(memory())
        noted = below
        if has_memory or fallback is not None:
            present = _child_of(node)
            noted = below[present if has_memory else 0 : present + 1] if present >= 0 else []
        for child, note_child in noted:
            note_child(tree)
            if is_joining and child.status is failure:
                tip = failed_tip(child)
                tree += [indices[tip], without_times(tip.feedback_message)]

    return note


def without_times(text: str) -> str:
    """Return a reason without the time that something took, which later steps do not depend on."""
    return _TAKEN.sub("", text)


def numbers_of(goals: Iterable[Goal]) -> dict[int, int]:
    """Return the numbers of open goals by their `id`; `LOST` for those that are given up."""
    numbers: dict[int, int] = {}
    count = 0
    for goal in goals:
        is_lost = goal.phase is Phase.LOST
        numbers[id(goal)] = LOST if is_lost else count
        count += not is_lost
    return numbers


def attempt_key(leaf: ActionLeaf, numbers: Mapping[int, int]) -> Any:
    """Return the state of the attempt of a leaf.

    Args:
        numbers: Of the open goals, by their `id`.
    """
    attempt = leaf.attempt
    if attempt is None or leaf.status is not Status.RUNNING:
        return None
    goal = attempt.goal
    # A limit that begins later has the value that its variables had at entry.
    limits = attempt.limits.goal, attempt.limits.silence
    if goal is None:
        return limits
    return (
        limits,
        numbers.get(id(goal), -1),
        attempt.cause and attempt.cause._value_,
        goal.phase._value_,
        goal.accepted,
        attempt.ending.outcome._value_ if attempt.ending else "",
        goal.feedback is None,
    )


def goal_key(goal: Goal, ledger: Ledger) -> Any:
    """Return the state of an open goal."""
    return (
        goal.goal_client.name,
        goal.owner,
        goal.phase._value_,
        goal.cancel_refused,
        goal.orphaned_ns is not None,
        ledger.has_given_up(goal),
    )


def inner_key(node: Subtree, finals: Iterable[Finally], names: Names | None) -> Any:
    """Return the variables of a named tree while something may read them.

    They are replaced where it begins, apart from those that follow topics.

    Args:
        finals: The nodes with a clean-up in the tree.
        names: Of the variables that may be read; None for all.
    """
    inner = node.inner
    if any(final.is_detached for final in finals):
        return values_key(inner.values)
    if node.status is Status.RUNNING or inner.followed:
        return values_key(inner.values, None if names is None else names[id(inner)])
    return None


def failed_tip(node: Behaviour) -> Behaviour:
    """Return the deepest node whose failure made this one fail: the last one of several."""
    while failed := [child for child in node.children if child.status is Status.FAILURE]:
        node = failed[-1]
    return node


def _memory_of(
    node: Behaviour, read_in_cleanup: Callable[[Finally], frozenset[str]]
) -> Callable[[], Any] | None:
    """Return what gives the memory of a running node, its times left apart; None without one."""
    match node:
        case Repeat():
            # Rounds without a bound are alike.
            return lambda: (node.count and node.done, node.count, node.save_state(0)["within"])
        case Retry():
            return lambda: (node.failures, node.num_failures, node.due_ns is not None)
        case Sequence() | Selector() | Pick():
            return partial(_child_of, node)
        case _ if not node.children:
            return None
    kept = read_in_cleanup(node) if isinstance(node, Finally) else None

    def memory() -> Any:
        saved = {name: value for name, value in save(node, 0).items() if name != "left_ns"}
        if kept is not None:
            saved["values"] = values_key(dict(saved["values"]), kept)
        return plain(saved)

    return memory


def _child_of(node: Any) -> int:
    """Return the index of the child that a composite has reached; -1 for none."""
    current = node.current_child
    return -1 if current is None else node.children.index(current)


def values_key(values: Mapping[str, Any], names: frozenset[str] | None = None) -> Any:
    """Return variables with their values, by name.

    Args:
        names: Those that count; None for all.
    """
    counting = values if names is None else [name for name in names if name in values]
    return tuple(sorted([(name, plain(values[name])) for name in counting]))


def plain(value: Any) -> Any:
    """Return a value that `marshal` writes; equal ones are written alike."""
    if value is None or type(value) in (int, str, bytes):
        return value
    if type(value) is float:
        return "NaN" if math.isnan(value) else value
    match value:
        case bool():
            return ("bool", value)
        case NoValue():
            return ("none", value.reason)
        case list() | tuple():
            return tuple(map(plain, value))
        case dict():
            return tuple((name, plain(entry)) for name, entry in value.items())
    return repr(value)
