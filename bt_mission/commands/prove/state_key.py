"""What the future of a mission depends on, as plain values that `marshal` writes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.prove.goal_servers import GoalServer
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.control import Parallel, Pick, Selector, Sequence
from bt_mission.executive.behaviours.decorators import Repeat, Retry, Subtree
from bt_mission.executive.behaviours.snapshot import save
from bt_mission.executive.goals.goal import Goal, Phase
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.expressions.values import NoValue

LOST = -2
"""In place of the number of a goal that is given up: which one it is changes nothing."""


_TAKEN = re.compile(r", -?[0-9.e+]+ s after its acceptance")


def noter(node: Behaviour, indices: Mapping[Behaviour, int]) -> Callable[[list[Any]], None]:
    """Return what notes the status of a node, and its memory and the nodes below while it runs.

    A node that joins others may end by a failure that came before its last tick, so the
    failure is noted, too. Of a sequence or fallback with memory only the present child matters. A
    fallback has not reset the children that it has not reached; they are left out.

    Args:
        indices: The number of each node.
    """
    running, failure, memory = Status.RUNNING, Status.FAILURE, _memory_of(node)
    below = [(child, noter(child, indices)) for child in node.children]
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
    if goal is None:
        return "waits"
    return (
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


def leaves_behind(numbers: Mapping[int, int], servers: Iterable[GoalServer]) -> bool:
    """Is a goal lost for ever: one that no server works on?

    Args:
        numbers: Of the open goals, by their `id`.
        servers: Those of all actions.
    """
    lost = {goal for goal, number in numbers.items() if number == LOST}
    if lost:
        for server in servers:
            lost -= {id(entry.goal) for entry in server.goals if entry.stage != "mute"}
    return bool(lost)


def inner_key(node: Subtree, finals: Iterable[Finally]) -> Any:
    """Return the variables of a named tree while something may read them.

    They are replaced where it begins, apart from those that follow topics.

    Args:
        finals: The nodes with a clean-up in the tree.
    """
    inner = node.inner
    is_read = node.status is Status.RUNNING or inner.followed
    if is_read or any(final.is_detached for final in finals):
        return values_key(inner.values)
    return None


def failed_tip(node: Behaviour) -> Behaviour:
    """Return the deepest node whose failure made this one fail: the last one of several."""
    while failed := [child for child in node.children if child.status is Status.FAILURE]:
        node = failed[-1]
    return node


def _memory_of(node: Behaviour) -> Callable[[], Any] | None:
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

    def memory() -> Any:
        saved = {name: value for name, value in save(node, 0).items() if name != "left_ns"}
        if isinstance(node, Finally):
            saved["values"] = values_key(dict(saved["values"]))
        return plain(saved)

    return memory


def _child_of(node: Any) -> int:
    """Return the index of the child that a composite has reached; -1 for none."""
    current = node.current_child
    return -1 if current is None else node.children.index(current)


def values_key(values: Mapping[str, Any]) -> Any:
    """Return variables with their values, by name."""
    return tuple(sorted([(name, plain(value)) for name, value in values.items()]))


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
