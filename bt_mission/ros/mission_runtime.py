"""One mission on a node: its time, its clients, and its executive."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

from rclpy.exceptions import InvalidHandle
from rclpy.node import Node

from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import clock_ns
from bt_mission.base.text import seconds
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.events.events import ClockJumped, LogLine
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.listeners import Stream
from bt_mission.executive.mission_time import MissionTime
from bt_mission.executive.status import MissionStatus
from bt_mission.language.mission import Mission
from bt_mission.ros.clients import RosServiceClient, TopicPublisher
from bt_mission.ros.goal_client import Exchange, RosGoalClient
from bt_mission.ros.subscriber import LatestMessageSubscriber, SubscriberKind

CANCEL_GRACE_NS = 3_000_000_000
"""The limit of the wait for goals that are not wanted any more (the default cancel limit)."""

_Client = TypeVar("_Client")


class MissionRuntime:
    """The runtime of the leaves, the signals and the topics of a mission.

    A subclass makes the executive, and calls :meth:`tick`.

    Args:
        node: Owns the clients; its namespace is that of the robot, and its clock the mission's.
        mission: The mission to run.
        goal_seed: The UUIDs of goals are made from it.
        say: Takes each line that ``log`` nodes say; None is the ROS log.
    """

    executive: Executive

    def __init__(
        self, node: Node, mission: Mission, goal_seed: str, say: Callable[[str], None] | None
    ) -> None:
        self.node = node
        self.domain_id: int = node.context.get_domain_id()
        """The domain of the node's context, which does not log once it is shut down."""
        self.mission = mission
        self.exchanges: Stream[Exchange] = Stream()
        """Emits every request to an action, and every response."""
        self.scope = Scope(dict(mission.inputs), mission.seed)
        self.ledger = Ledger(goal_seed, CANCEL_GRACE_NS)
        self._say = say or self._log_line
        self._clock = node.get_clock()
        self._time = MissionTime(self._on_clock_jump)
        self._tick_ns: int | None = None
        self._clients: dict[tuple[Callable[..., Any], str, str], Any] = {}
        self._allow_duplicates = False
        self.warnings: list[str] = []
        """The warnings so far, each once."""

    @property
    def is_done(self) -> bool:
        """Whether the mission has ended, with every goal accounted for.

        So has a mission whose node was destroyed: nothing ticks it any more.
        """
        return self.executive.status.is_final or self._is_node_gone

    @property
    def now_ns(self) -> int:
        """Mission time, ns: it never goes back, and does not move within a tick."""
        if self._tick_ns is not None:
            return self._tick_ns
        return self._time.at(self._ros_ns)

    def tick(self) -> None:
        """Tick the executive, all of it at one instant."""
        self._tick_ns = self._time.advance(clock_ns(self._clock))
        was_observing = self.executive.status is MissionStatus.OBSERVING
        try:
            self.executive.tick()
            if self.executive.status is MissionStatus.OBSERVING and not was_observing:
                self.explain(self.executive.mission_state.explanation)
        finally:
            self._tick_ns = None

    def end_without_node(self) -> None:
        """End a mission whose node was destroyed: it can only fail."""
        if not self.executive.status.is_final and self._is_node_gone:
            self.executive.abandon("its node was destroyed")

    def variables(self) -> dict[str, Any]:
        """Return the variables, and those of each subtree with its name before them."""
        values = dict(self.scope.values)
        for subtree in self._subtrees:
            values |= {
                f"{subtree.name}.{name}": value for name, value in subtree.inner.values.items()
            }
        return values

    @cached_property
    def _subtrees(self) -> list[Subtree]:
        return [node for node in self.executive.nodes if isinstance(node, Subtree)]

    # ---- clients ---------------------------------------------------------------------------

    def goal_client(self, action: str, type_name: str) -> RosGoalClient:
        """Return the client of an action; there is one for each name and type."""
        full = self.node.resolve_topic_name(action)
        more = (self._listen, self.exchanges, self.warn if self._allow_duplicates else None)
        return self._client(RosGoalClient, full, action, type_name, *more)

    def service_client(self, service: str, type_name: str) -> RosServiceClient:
        """Return the client of a service; there is one for each name and type."""
        full = self.node.resolve_service_name(service)
        return self._client(RosServiceClient, full, service, type_name)

    def subscriber(
        self, topic: str, type_name: str, kind: SubscriberKind = LatestMessageSubscriber
    ) -> LatestMessageSubscriber:
        """Return the messages of a topic; there is one object for each kind, name and type."""
        full = self.node.resolve_topic_name(topic)
        return self._client(kind, full, topic, type_name)

    def publisher(self, topic: str, type_name: str) -> TopicPublisher:
        """Return the publisher of a topic; there is one for each name and type."""
        full = self.node.resolve_topic_name(topic)
        return self._client(TopicPublisher, full, topic, type_name)

    def _client(
        self, kind: Callable[..., _Client], full: str, name: str, type_name: str, *more: Any
    ) -> _Client:
        """Return the client of a resolved name and type; it is made at its first use."""
        key = (kind, full, type_name)
        if key not in self._clients:
            self._clients[key] = kind(self.node, name, type_name, *more)
        client: _Client = self._clients[key]
        return client

    @abstractmethod
    def _listen(self, action: str) -> Callable[[], str]:
        """Return a reader of why the server of an action rejects the goal that is sent now."""

    def _close_clients(self) -> None:
        while self._clients:
            self._clients.popitem()[1].close()

    # ---- log -------------------------------------------------------------------------------

    def log(self, text: str) -> None:
        """Log a line of a leaf."""
        self._emit_line(text, is_own=True)

    def explain(self, text: str) -> None:
        """Log a line that explains another event."""
        self._emit_line(text, is_own=False)

    def warn(self, text: str) -> None:
        """Log a warning of the node, once; the report has it, and no trace."""
        if text not in self.warnings:
            self.warnings.append(text)
            log_of(self.node).warning(text)

    def _log_line(self, text: str) -> None:
        log_of(self.node).info(text)

    def _emit_line(self, text: str, *, is_own: bool) -> None:
        self._say(text)
        self.executive.events.emit(LogLine(self.now_ns, text, is_own))

    # ---- inside ----------------------------------------------------------------------------

    @property
    def _ros_ns(self) -> int:
        return clock_ns(self._clock)

    @property
    def _is_node_gone(self) -> bool:
        try:
            with self.node.handle:
                return False
        except InvalidHandle:
            return True

    def _on_clock_jump(self, jump_s: float) -> None:
        self.executive.events.emit(ClockJumped(self._time.at(self._ros_ns), jump_s))
        if jump_s < 0:
            change = f"was set back by {seconds(-jump_s)}: limits keep their remaining time"
        else:
            change = f"skipped {seconds(jump_s)}, which count as elapsed"
        log_of(self.node).warning(f"the ROS clock {change}")
