"""The tree of a mission in the messages of py_trees_ros, whose tools know it by them."""

from __future__ import annotations

import statistics
from collections import deque
from collections.abc import Iterator
from typing import Any

from builtin_interfaces.msg import Time
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite, Parallel, Selector, Sequence
from py_trees.decorators import Decorator
from unique_identifier_msgs.msg import UUID

from bt_mission.behaviours import control
from bt_mission.behaviours.cleanup import Finally
from bt_mission.behaviours.decorators import Subtree
from bt_mission.behaviours.python_leaf import PythonLeaf
from bt_mission.core.stamps import NS, set_ns
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import Event, NodeChanged, NodesReset
from bt_mission.ros.interface_types import message_type
from bt_mission.ros.mission_details import MissionRun, as_json, variables_of

PACKAGE = "py_trees_ros_interfaces"
TREE_TYPE = f"{PACKAGE}/msg/BehaviourTree"

SERIES = 10
"""Ticks over which averages and variances are taken."""

NO_ID = UUID()

_TYPES: tuple[tuple[tuple[type[Behaviour], ...], str], ...] = (
    ((Sequence, Finally), "SEQUENCE"),
    ((Selector, control.Pick), "SELECTOR"),
    ((Parallel,), "PARALLEL"),
    ((Decorator,), "DECORATOR"),
)
"""Types by the classes of nodes; all others are plain behaviours. Watchers refuse `CHOOSER`."""


class TreeSnapshots:
    """Describes the tree of one mission, which it follows from now on until it is closed."""

    def __init__(self, run: MissionRun) -> None:
        self._run = run
        self.has_changed = False
        """Has a status changed since :meth:`forget_changes`?"""
        types = {
            name: message_type(f"{PACKAGE}/msg/{name}")
            for name in ("Behaviour", "BehaviourTree", "KeyValue", "Statistics")
        }
        self._types = types
        self._codes = {status: getattr(types["Behaviour"], status.name) for status in Status}
        # As py_trees_ros: children before their parents.
        self._messages = {node: _described(node, types) for node in run.executive.root.iterate()}
        self._ids: dict[Behaviour | None, UUID] = {
            node: message.own_id for node, message in self._messages.items()
        }
        self._subtrees = [node for node in self._messages if isinstance(node, Subtree)]
        self._visited: set[Behaviour] | None = None
        self._began_ns: int | None = None
        self._since_began: Stopwatch | None = None
        self._intervals_s: deque[float] = deque(maxlen=SERIES)
        self._durations_s: deque[float] = deque(maxlen=SERIES)
        executive = run.executive
        executive.events.subscribe(self._take)
        executive.tick_wrappers.append(self._begin_tick)

    def close(self) -> None:
        """Follow the mission no longer."""
        self._run.executive.events.unsubscribe(self._take)
        self._run.executive.tick_wrappers.remove(self._begin_tick)

    def end_tick(self) -> None:
        """Take the time of a tick; call it after each."""
        if self._since_began is not None:
            self._durations_s.append(self._since_began.elapsed_s)
            self._since_began = None

    def forget_changes(self) -> None:
        """Count changes from now on."""
        self.has_changed = False

    def describe(self) -> Any:
        """Return a ``BehaviourTree`` of the tree as it stands, without variables."""
        visited = self._visited
        for node, message in self._messages.items():
            tip = node.tip()
            message.status = self._codes[node.status]
            message.message = str(node.feedback_message)
            message.tip_id = self._ids.get(None if tip is node else tip, NO_ID)
            message.current_child_id = self._ids.get(_current_child(node), NO_ID)
            # What was visited before anybody looked is not known: take what has a status.
            message.is_active = (
                node in visited if visited is not None else node.status is not Status.INVALID
            )
        return self._types["BehaviourTree"](
            behaviours=[*self._messages.values()], statistics=self._statistics()
        )

    def variables(self) -> dict[str, str]:
        """Return the variables of the mission, each with its value as JSON."""
        values = variables_of(self._run, self._subtrees)
        return {name: as_json(value) for name, value in values.items()}

    def _take(self, event: Event) -> None:
        self.has_changed |= isinstance(event, NodeChanged | NodesReset)

    def _begin_tick(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        now_ns = self._run.now_ns
        self._intervals_s.append(0.0 if self._began_ns is None else (now_ns - self._began_ns) / NS)
        self._began_ns, self._since_began = now_ns, Stopwatch()
        self._visited = visited = set()
        for node in walk:
            visited.add(node)
            yield node

    def _statistics(self) -> Any:
        message = self._types["Statistics"](count=self._run.executive.ticks)
        began_ns = self._run.now_ns if self._began_ns is None else self._began_ns
        message.stamp = set_ns(Time(), began_ns)
        for name, series in (("duration", self._durations_s), ("interval", self._intervals_s)):
            if series:
                setattr(message, f"tick_{name}", series[-1])
                setattr(message, f"tick_{name}_average", statistics.fmean(series))
            if len(series) > 1:
                setattr(message, f"tick_{name}_variance", statistics.variance(series))
        return message


def _described(node: Behaviour, types: dict[str, Any]) -> Any:
    """Return a ``Behaviour`` with all of a node that stays as it is."""
    inner, kind = _inner(node), types["Behaviour"]
    return kind(
        name=node.name,
        class_name=f"{type(inner).__module__}.{type(inner).__name__}",
        own_id=_id_of(node),
        parent_id=_id_of(node.parent),
        child_ids=[_id_of(child) for child in node.children],
        type=_type_of(inner, kind),
        additional_detail=_detail_of(inner),
        blackbox_level=getattr(kind, f"BLACKBOX_LEVEL_{inner.blackbox_level.name}"),
        blackboard_access=[
            types["KeyValue"](key=key, value=value)
            for client in inner.blackboards
            for keys, value in (
                (client.read, kind.BLACKBOARD_ACCESS_READ),
                (client.write, kind.BLACKBOARD_ACCESS_WRITE),
                (client.exclusive, kind.BLACKBOARD_ACCESS_EXCLUSIVE_WRITE),
            )
            for key in sorted(keys)
        ],
    )


def _inner(node: Behaviour) -> Behaviour:
    """Return a user's behaviour in place of the node that stands for it in the tree."""
    return node.behaviour if isinstance(node, PythonLeaf) else node


def _type_of(node: Behaviour, kind: Any) -> int:
    name = next((name for classes, name in _TYPES if isinstance(node, classes)), "BEHAVIOUR")
    found: int = getattr(kind, name)
    return found


def _detail_of(node: Behaviour) -> str:
    if isinstance(node, control.Parallel):
        return node.policy_name
    return "WithMemory" if isinstance(node, Sequence | Selector) and node.memory else ""


def _current_child(node: Behaviour) -> Behaviour | None:
    inner = _inner(node)
    return inner.current_child if isinstance(inner, Composite) else None


def _id_of(node: Behaviour | None) -> UUID:
    """Return the id of a node; zeros for none."""
    return NO_ID if node is None else UUID(uuid=list(node.id.bytes))
