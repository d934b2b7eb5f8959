"""The signals of requirements in a running mission: those of its executive, and topics."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.actions import GOALS_AT, goals_at
from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.geometry import yaw_of
from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.events.events import Event, NodeChanged, TreeRevised
from bt_mission.language.expressions.values import NoValue, Plain
from bt_mission.language.outcome import is_outcome
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.mission_runtime import MissionRuntime
from bt_mission.ros.subscriber import (
    LatestMessageSubscriber,
    SerializedSubscriber,
)

SCAN, ODOMETRY, BATTERY = "scan", "odom", "battery_state"
OF_ODOMETRY: Mapping[str, Callable[[Any], float]] = {
    "odometry.x": lambda odom: float(odom.pose.pose.position.x),
    "odometry.y": lambda odom: float(odom.pose.pose.position.y),
    "odometry.yaw": lambda odom: yaw_of(odom.pose.pose.orientation),
    "speed": lambda odom: float(odom.twist.twist.linear.x),
    "turn_rate": lambda odom: float(odom.twist.twist.angular.z),
}
STATUSES: Mapping[str, Status] = {
    "running": Status.RUNNING,
    "succeeded": Status.SUCCESS,
    "failed": Status.FAILURE,
}
LOOK_EVERY = 20
"""Control steps between two looks for a topic that nobody publishes yet."""


@dataclass(frozen=True)
class SimulationModel:
    """A compiled simulation, by which its states can be read.

    Attributes:
        data: Of MuJoCo, binary.
        facts: How states are read with it.
    """

    data: bytes
    facts: Mapping[str, str | int]


class TopicSignal:
    """The newest message of a topic, whose type is that of its publishers once there are any.

    Attributes:
        is_read: Whether more than its arrival is needed. Set before the first look.
        is_settled: Whether it is subscribed to, or has an unsupported type.
    """

    is_read = False

    def __init__(self, runner: MissionRuntime, topic: str) -> None:
        self.message: Any = None
        self.came_ns: int | None = None
        self.problem = ""
        self._runner = runner
        self._topic = topic
        self.is_settled = False
        self._waits = 0
        self.listeners: list[Callable[[Any], object]] = []
        """Called with each message."""

    def look(self, again_after: int = LOOK_EVERY) -> None:
        """Subscribe as soon as the topic has a publisher; else look again after some calls."""
        if self.is_settled:
            return
        self._waits -= 1
        if self._waits > 0:
            return
        self._waits = again_after
        node = self._runner.node
        name = node.resolve_topic_name(self._topic)
        types = {publisher.topic_type for publisher in node.get_publishers_info_by_topic(name)}
        if not types:
            return
        self.is_settled = True
        try:
            kind = LatestMessageSubscriber if self.is_read else SerializedSubscriber
            self._runner.subscriber(self._topic, min(types), kind).listen(self._take)
        except BtMissionError as error:
            self.problem = str(error)

    def _take(self, message: Any) -> None:
        self.message, self.came_ns = message, self._runner.now_ns
        for listener in self.listeners:
            listener(message)


class NodeOutcomes:
    """The outcome of the newest goals of nodes; empty while they are under way.

    A goal that ended within a control step counts at its instant, even if the node has started
    again.
    """

    def __init__(self) -> None:
        self._ended: dict[Any, str] = {}
        self._restarted: set[Any] = set()

    def note(self, node: Any, status: Status, outcome: str) -> None:
        """Note that a node has this status, and how its goal ended, if it has."""
        if status is Status.RUNNING:
            self._restarted.add(node)
        else:
            self._restarted.discard(node)
            if outcome or status is not Status.INVALID:
                self._ended[node] = outcome

    def move(self, now: Mapping[Any, Any]) -> None:
        """Continue with other keys, after a revision; the rest is forgotten."""
        self._ended = {now[node]: text for node, text in self._ended.items() if node in now}
        self._restarted = {now[node] for node in self._restarted if node in now}

    def forget(self) -> None:
        """Forget the ends of restarted nodes; called after each control step."""
        for node in self._restarted:
            self._ended.pop(node, None)
        self._restarted.clear()

    def is_any(self, nodes: Iterable[Any], outcome: str) -> bool:
        """Return whether the goal of one of these nodes had this outcome."""
        return any(is_outcome(self._ended.get(node, ""), outcome) for node in nodes)


class LiveSignals:
    """Signals of a mission on any robot, without those that only a simulation has.

    Args:
        runner: The runner of the mission.
    """

    def __init__(self, runner: MissionRuntime) -> None:
        self._runner = runner
        self._executive = runner.executive
        self._topics: dict[str, TopicSignal] = {}
        self._silent_topics: list[TopicSignal] = []
        self._readers: dict[str, Reader | str] = {}
        self._status: dict[Behaviour, Status] = {
            behaviour: behaviour.status for behaviour in self._executive.nodes
        }
        self._seen: defaultdict[Behaviour, set[Status]] = defaultdict(set)
        self._outcomes = NodeOutcomes()
        self._changes = 0
        self._named: defaultdict[str, list[Behaviour]] = defaultdict(list)
        self._name_nodes()
        self._executive.events.subscribe(self._take)

    def _name_nodes(self) -> None:
        self._nodes = self._executive.nodes
        for nodes in self._named.values():
            nodes.clear()
        for node in self._executive.nodes:
            self._named[node.name].append(node)
            self._named[self._executive.path_of(node)].append(node)

    def reader(self, signal: SignalValue, /) -> Reader | str:
        """Return the reader of a signal's present value, or why it is not known here.

        All callers get the same one.
        """
        if signal.key not in self._readers:
            self._readers[signal.key] = self._make_reader(signal)
        return self._readers[signal.key]

    def _make_reader(self, signal: SignalValue) -> Reader | str:
        name, arguments = signal.name, signal.arguments
        if name in SIGNALS and "node" in SIGNALS[name].arguments and not self._named[arguments[0]]:
            return f"the mission has no node {quoted(arguments[0])}"
        if name in OF_ODOMETRY:
            return self._of_topic(ODOMETRY, OF_ODOMETRY[name])
        if name in STATUSES:
            return self._node_status(STATUSES[name], arguments[0])
        makers: Mapping[str, Callable[..., Reader]] = {
            "$": self._variable,
            "time": lambda: self._time,
            "open_goals": lambda: lambda: len(self._runner.ledger.open_goals),
            **{each: partial(partial, self._goals_at, part) for each, part in GOALS_AT.items()},
            "feedback": self._feedback,
            "accepted": self._accepted,
            "outcome": self._outcome,
            "age": self._age,
            "topic": self._field,
            "scan_clearance": lambda: self._of_topic(SCAN, smallest_range),
            "battery": lambda: self._of_topic(BATTERY, lambda message: float(message.percentage)),
            "distance": self._path_length,
        }
        if name not in makers:
            return "only a simulation provides it"
        return makers[name](*arguments)

    def lower_bound(self, _signal: SignalValue, /) -> Callable[[], float | None] | None:
        """Return the reader of a cheap lower bound of a signal; none of these has one."""
        return None

    def measured_by(self, signal: SignalValue, /) -> str:
        """Return the measure of a signal that only a simulation knows exactly."""
        known = SIGNALS.get(signal.name)
        return "odometry" if known is not None and known.known_by == "odometry" else ""

    def listen(self) -> None:
        """Subscribe to the topics that exist, so that the first control step has their messages."""
        for topic in self._silent_topics:
            topic.look(again_after=0)

    def step(self) -> None:
        """Look for topics that do not exist yet; called before each control step."""
        if self._silent_topics:
            for topic in self._silent_topics:
                topic.look()
            self._silent_topics = [topic for topic in self._silent_topics if not topic.is_settled]

    def forget(self) -> None:
        """Forget the statuses of a control step; called after each one."""
        if self._seen:
            self._seen.clear()
            self._outcomes.forget()
            self._changes += 1

    # ---- the mission ---------------------------------------------------------------------

    def simulation(self) -> SimulationModel | None:
        """Return the model of the simulation for its states; None without one."""
        return None

    def truth(self) -> tuple[bytes, Mapping[str, Plain | None]]:
        """Return the simulation's state, and the true values that do not follow from it."""
        return b"", {}

    def _take(self, event: Event) -> None:
        if isinstance(event, TreeRevised):
            self._revise(event)
        if not isinstance(event, NodeChanged):
            return
        node = self._executive.nodes[event.node]
        self._status[node] = event.status
        self._seen[node].add(event.status)
        if isinstance(node, ActionLeaf):
            attempt = node.attempt
            ending = None if attempt is None else attempt.ending
            outcome = "" if ending is None else str(ending.outcome)
            self._outcomes.note(node, event.status, outcome)
        self._changes += 1

    def _revise(self, event: TreeRevised) -> None:
        """Continue with the nodes of another tree; those that the earlier one had keep theirs."""
        before, known, seen = self._nodes, self._status, dict(self._seen)
        self._name_nodes()
        self._status = {node: node.status for node in self._nodes}
        self._seen.clear()
        now = {
            before[index]: node
            for node, index in zip(self._nodes, event.kept, strict=True)
            if index >= 0
        }
        for old, node in now.items():
            self._status[node] = known[old]
            if old in seen:
                self._seen[node] = seen[old]
        self._outcomes.move(now)
        self._changes += 1

    def _time(self) -> float:
        return (self._runner.now_ns - self._executive.started_ns) / NS

    def _node_status(self, status: Status, node: str) -> Reader:
        seen = self._seen
        of, value = -1, False

        def has_status() -> bool:
            nonlocal of, value
            if of != self._changes:
                of = self._changes
                # A node that starts and ends in one tick has run, too. What a loop has reset for a
                # new round, and not entered again, counts as it ended, as in the trace.
                known = self._status
                value = any(
                    known[behaviour] is status or status in seen.get(behaviour, ())
                    for behaviour in self._named[node]
                )
            return value

        return has_status

    def _variable(self, name: str) -> Reader:
        def value() -> Any:
            current = self._runner.scope.values.get(name)
            return None if isinstance(current, NoValue) else current

        return value

    def _goals_at(self, part: str) -> int:
        return goals_at(part, (goal.goal_client.name for goal in self._runner.ledger.open_goals))

    def _leaves(self, node: str) -> Iterator[ActionLeaf]:
        return (leaf for leaf in self._named[node] if isinstance(leaf, ActionLeaf))

    def _feedback(self, node: str, field: str) -> Reader:
        def value() -> Any:
            for leaf in self._leaves(node):
                if leaf.status is Status.RUNNING and leaf.attempt is not None:
                    return field_of(leaf.attempt.feedback, field)
            return None

        return value

    def _accepted(self, node: str) -> Reader:
        def is_accepted() -> bool:
            goals = [leaf.attempt.goal for leaf in self._leaves(node) if leaf.attempt is not None]
            return any(goal is not None and goal.accepted for goal in goals)

        return is_accepted

    def _outcome(self, node: str, outcome: str) -> Reader:
        return lambda: self._outcomes.is_any(self._leaves(node), outcome)

    # ---- topics --------------------------------------------------------------------------

    def topic(self, name: str) -> TopicSignal:
        """Return the newest message of a topic; it is subscribed to once."""
        if name not in self._topics:
            self._topics[name] = TopicSignal(self._runner, name)
            self._silent_topics.append(self._topics[name])
        return self._topics[name]

    def _age(self, topic: str) -> Reader:
        signal, runner, executive = self.topic(topic), self._runner, self._executive

        def age() -> float:
            came_ns = executive.started_ns if signal.came_ns is None else signal.came_ns
            return (runner.now_ns - came_ns) / NS

        return age

    def _field(self, topic: str, field: str) -> Reader:
        return self._of_topic(topic, lambda message: field_of(message, field))

    def _path_length(self) -> Reader:
        signal, path = self.topic(ODOMETRY), PathLength()
        signal.is_read = True
        signal.listeners.append(path.add)
        return lambda: None if signal.message is None else path.length

    def _of_topic(self, topic: str, read: Callable[[Any], Any]) -> Reader:
        """Return what reads the newest message, each only once."""
        signal = self.topic(topic)
        signal.is_read = True
        value: Any = None
        of: Any = None

        def newest() -> Any:
            nonlocal value, of
            if signal.message is not of:
                of = signal.message
                newest_value = read(of)
                is_number = not (isinstance(newest_value, float) and math.isnan(newest_value))
                value = newest_value if is_number else None
            return value

        return newest


class PathLength:
    """The length of a path by odometry, m."""

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self.length = 0.0

    def add(self, odom: Any) -> float:
        """Add a message; return the length so far."""
        place = odom.pose.pose.position.x, odom.pose.pose.position.y
        if self._last is not None:
            self.length += math.dist(place, self._last)
        self._last = place
        return self.length


def smallest_range(scan: Any) -> float | None:
    """Return the smallest valid range of a scan, m; None without one."""
    valid = [measured for measured in scan.ranges if scan.range_min <= measured <= scan.range_max]
    return float(min(valid)) if valid else None


def field_of(message: Any, path: str) -> Any:
    """Return a field by its dotted name; None without one, or if it is not a plain value.

    Args:
        message: A message of rclpy, or one decoded from a recording.
    """
    for part in path.split("."):
        is_decoded = isinstance(message, Mapping)
        message = message.get(part) if is_decoded else getattr(message, part, None)
    if isinstance(message, bool | int | float | str):
        return message
    return None
