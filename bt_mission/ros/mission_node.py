"""The executive as a ROS node: time, clients and the tick timer of one mission."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Empty

from bt_mission.behaviours.builder import build_tree
from bt_mission.behaviours.runtime import Scope
from bt_mission.core.dds.liveliness import LEASE_S, TOPIC
from bt_mission.executive.executive import Executive
from bt_mission.executive.mission_time import MissionTime
from bt_mission.executive.trace import Trace
from bt_mission.goals.exchange import ExchangeListener
from bt_mission.goals.goal import Goal
from bt_mission.goals.ledger import Ledger
from bt_mission.ros.control_services import ControlServices
from bt_mission.ros.goal_client import RosGoalClient
from bt_mission.ros.leaving import destroy_actions
from bt_mission.ros.mission_run import MissionRun
from bt_mission.ros.publisher import TopicPublisher
from bt_mission.ros.service_client import RosServiceClient
from bt_mission.ros.status_publisher import StatusFeed
from bt_mission.ros.status_topics import StatusTopics
from bt_mission.ros.subscriber import LatestMessageSubscriber
from bt_mission.ros.waypoint_markers import WaypointMarkers

if TYPE_CHECKING:
    from rclpy.context import Context

    from bt_mission.language.mission import Mission

TICK_RATE_HZ = 20.0
PRESENCE = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.AUTOMATIC,
    liveliness_lease_duration=Duration(nanoseconds=round(LEASE_S * 1e9)),
)
CANCEL_GRACE_NS = 3_000_000_000
"""How long a mission waits for goals that it no longer wants (the default cancel limit)."""

on_mission_started: list[Callable[[Mission, Executive], None]] = []
"""Told of each mission of this process that is set up, such as to see what tests reach of it."""


class MissionNode(Node):
    """Runs one mission; it is the runtime of the mission's leaves.

    :param mission: what to carry out.
    :param context: the rclpy context; None is the default one.
    :param namespace: of the robot; names in the mission that are relative lie in it.
    :param lean: no parameter services, log topic or type description, as on the stage.
    :param use_sim_time: follow ``/clock``.
    :param say: where ``log`` nodes speak to; None is the ROS log.
    :param trace: where to record what happens; None makes a new one.
    :param goal_seed: goal ids are made from it; None is the mission's seed.
    :param name: of the node.
    :param has_controls: offer the topics and services for tools; None does, unless it is lean.
    :param why_rejected: tells why an action, by its resolved name, rejected its last goal.
    :raises BtMissionError: when the mission cannot be set up, such as an unknown action type.
    """

    def __init__(  # noqa: PLR0913 - everything that a node is told once
        self,
        mission: Mission,
        *,
        context: Context | None = None,
        namespace: str | None = None,
        lean: bool = False,
        use_sim_time: bool = False,
        say: Callable[[str], None] | None = None,
        trace: Trace | None = None,
        goal_seed: str | None = None,
        name: str = "bt_mission",
        has_controls: bool | None = None,
        why_rejected: Callable[[str], str] | None = None,
    ) -> None:
        overrides = [Parameter("use_sim_time", value=use_sim_time)]
        if lean:
            overrides.append(Parameter("start_type_description_service", value=False))
        super().__init__(
            name,
            context=context,
            namespace=namespace,
            enable_rosout=not lean,
            start_parameter_services=not lean,
            parameter_overrides=overrides,
        )
        if not lean:
            # Held, never used: servers in other processes see by it that this one is alive.
            self._presence = self.create_publisher(Empty, TOPIC, PRESENCE)
        self.log_listeners: list[Callable[[int, str], None]] = []
        """Told of each line that the mission says, with the ROS time, ns."""
        self._why_rejected = why_rejected or (lambda _: "")
        self._say = say or self._log_line
        self._time = MissionTime(self._on_clock_jump)
        self._tick_ns: int | None = None
        self.overhear: list[ExchangeListener] = []
        """Told of every request to an action, and of every answer."""
        self._couriers: dict[tuple[str, str], RosGoalClient] = {}
        self._callers: dict[tuple[str, str], RosServiceClient] = {}
        self._readers: dict[tuple[str, str], LatestMessageSubscriber] = {}
        self._writers: dict[tuple[str, str], TopicPublisher] = {}
        self.scope = Scope(dict(mission.inputs), mission.seed)
        self.trace = trace or Trace()
        self.ledger = Ledger(goal_seed or mission.seed, CANCEL_GRACE_NS, self._on_goal)
        self.executive = Executive(build_tree(mission, self.scope), self, self.trace)
        for tell in on_mission_started:
            tell(mission, self.executive)
        self.status = StatusFeed(self.get_clock())
        self.status.begin(mission.name, self.executive)
        self._waypoints: WaypointMarkers | None = None
        if has_controls if has_controls is not None else not lean:
            self.show_waypoints()
            ControlServices(self, lambda: self.executive)
            topics = StatusTopics(self, self.status)
            topics.begin(self.run)
            self.executive.after_tick.append(topics.flush)
        else:
            self.executive.after_tick.append(self.status.flush)
        self.create_timer(1 / TICK_RATE_HZ, self.tick)

    @property
    def run(self) -> MissionRun:
        """What publishers and recorders are given."""
        return MissionRun(
            self.executive, self.ledger, self.scope, self.log_listeners, lambda: self.now_ns
        )

    def show_waypoints(self) -> None:
        """From now on publish the poses that goals name; once is enough."""
        if self._waypoints is None:
            self._waypoints = WaypointMarkers(self)
            self.executive.goal_listeners.append(self._waypoints.on_goal)

    @property
    def now_ns(self) -> int:
        """ROS time, ns, as the mission lives it: it never goes back, and stands still in a tick."""
        if self._tick_ns is not None:
            return self._tick_ns
        return self._time.at(self._ros_ns)

    @property
    def _ros_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def tick(self) -> None:
        """Tick the executive, all of it at one instant."""
        self._tick_ns = self._time.advance(self._ros_ns)
        try:
            self.executive.tick()
        finally:
            self._tick_ns = None

    def goal_client(self, action: str, type_name: str) -> RosGoalClient:
        """The client of an action; one for each name and type."""
        key = (self.resolve_topic_name(action), type_name)
        if key not in self._couriers:
            self._couriers[key] = RosGoalClient(
                self, action, type_name, self._why_rejected, self.overhear
            )
        return self._couriers[key]

    def service_client(self, service: str, type_name: str) -> RosServiceClient:
        """The client of a service; one for each name and type."""
        key = (self.resolve_service_name(service), type_name)
        if key not in self._callers:
            self._callers[key] = RosServiceClient(self, service, type_name)
        return self._callers[key]

    def subscriber(self, topic: str, type_name: str) -> LatestMessageSubscriber:
        """The messages of a topic; one for each name and type."""
        key = (self.resolve_topic_name(topic), type_name)
        if key not in self._readers:
            self._readers[key] = LatestMessageSubscriber(self, topic, type_name)
        return self._readers[key]

    def publisher(self, topic: str, type_name: str) -> TopicPublisher:
        """The publisher of a topic; one for each name and type."""
        key = (self.resolve_topic_name(topic), type_name)
        if key not in self._writers:
            self._writers[key] = TopicPublisher(self, topic, type_name)
        return self._writers[key]

    def destroy_node(self) -> None:
        """Leave the graph, with every client."""
        destroy_actions(self)
        Node.destroy_node(self)

    def log(self, text: str) -> None:
        """Say a line of the mission's to the people who watch, and to the trace."""
        self.trace.record(self.now_ns, "log", text=text)
        self._say(text)
        for listener in self.log_listeners:
            listener(self.now_ns, text)

    def _on_clock_jump(self, jump_s: float) -> None:
        self.trace.record(self._time.at(self._ros_ns), "clock", jump=jump_s)
        if jump_s < 0:
            said = f"was set back by {-jump_s:.2f} s: limits go on with what is left of them"
        else:
            said = f"skipped {jump_s:.2f} s: they count as passed"
        self.get_logger().warning(f"the ROS clock {said}")  # type: ignore[no-untyped-call]

    def _on_goal(self, what: str, goal: Goal) -> None:
        self.executive.record_goal(what, goal)

    def _log_line(self, text: str) -> None:
        self.get_logger().info(text)  # type: ignore[no-untyped-call]
