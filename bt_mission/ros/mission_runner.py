"""Runs one mission on a node: the tick timer, requirements, and topics for tools.

The node and its executor are the caller's. The caller spins them to run the mission::
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, ClassVar, Self
from weakref import WeakValueDictionary

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import Empty
from typing_extensions import override

from bt_mission.base.dds.liveliness import ASSURED_S, TOPIC
from bt_mission.base.errors import BtMissionError
from bt_mission.base.stamps import NS
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.behaviours.builder import build_tree, node_details
from bt_mission.executive.controls import MissionControls
from bt_mission.executive.events.events import GoalChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.listeners import Stream
from bt_mission.executive.report import Report, report_on
from bt_mission.executive.revision import RevisionPlan
from bt_mission.executive.status import MissionStatus
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.language.revision import Revision
from bt_mission.ros.control_services import ControlServices
from bt_mission.ros.mission_runtime import MissionRuntime
from bt_mission.ros.requirement_watch import RequirementWatch
from bt_mission.ros.run_ending import see_to_the_end
from bt_mission.ros.server_logs import ServerLogs
from bt_mission.ros.signals import LiveSignals
from bt_mission.ros.status_publisher import StatusPublisher
from bt_mission.ros.waypoint_markers import WaypointMarkers

TICK_RATE_HZ = 20.0
PRESENCE = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.AUTOMATIC,
    liveliness_lease_duration=Duration(nanoseconds=round(ASSURED_S * 1e9)),
)

_with_controls: WeakValueDictionary[int, MissionRunner] = WeakValueDictionary()
"""The runner that has the topics and services for tools of a node, by the node's `id`."""


@dataclass(frozen=True)
class RunnerOptions:
    """The options of a run.

    Attributes:
        say: Takes each line that ``log`` nodes say; None is the ROS log.
        trace: Takes what happens; None makes a new one.
        goal_seed: The UUIDs of goals are made from it; None draws one, since a server remembers
            the UUIDs of earlier runs for a while.
        has_controls: Offer the topics and services for tools, below the name of the node.
        has_presence: Let servers notice when this process dies. They end its goals then.
        why_rejected: Returns why an action, by its resolved name, rejected its last goal. None,
            also as its result, takes what the server logs on ``/rosout`` meanwhile.
        signals: Gives the signals of requirements; None takes them from topics.
        read_revision: Reads the new version that another process sends (``~/revise``), for the
            running mission; None refuses it. :meth:`MissionRunner.revise` is always possible.
        allow_duplicates: Send goals also to an action that has several servers.
    """

    say: Callable[[str], None] | None = None
    trace: Trace | None = None
    goal_seed: str | None = None
    has_controls: bool = True
    has_presence: bool = True
    why_rejected: Callable[[str], str | None] | None = None
    signals: Callable[[Any], LiveSignals] | None = None
    read_revision: Callable[[Mission, Any], Mission] | None = None
    allow_duplicates: bool = False


class MissionRunner(MissionRuntime):
    """Runs a mission on a node that the caller spins.

    Call it in the thread that spins the node. As a context manager it halts a mission that still
    runs at the end of the block, waits for its goals to end, and closes; also after Ctrl-C or
    SIGTERM has shut ROS down.

    Args:
        node: Owns the clients, the timer and the topics; its namespace is that of the robot, and
            its clock the mission's.
        mission: The mission to run.
        options: See :class:`RunnerOptions`.

    Raises:
        BtMissionError: When the mission cannot be set up, such as an action of an unknown type,
            or when a mission with topics for tools runs on this node already.
    """

    created: ClassVar[Stream[MissionRunner]] = Stream()
    """Emits every runner of this process before its first tick."""

    def __init__(self, node: Node, mission: Mission, options: RunnerOptions | None = None) -> None:
        options = options or RunnerOptions()
        super().__init__(node, mission, options.goal_seed or secrets.token_hex(8), options.say)
        self.trace = options.trace or Trace()
        self._read_revision = options.read_revision
        self._allow_duplicates = options.allow_duplicates
        self.revising: Stream[Mission] = Stream()
        """Emits each new version of the mission before its nodes are set up."""
        self._wall = Stopwatch()
        self._wall_s: float | None = None
        self._after_tick: Future | None = None
        self._waypoints: WaypointMarkers | None = None
        self.controls = MissionControls(lambda: self.executive)
        """Does what users of this process and of others request."""
        with ExitStack() as made:
            made.callback(self._close_clients)
            self._why_rejected = options.why_rejected
            self._logs = ServerLogs(node)
            made.callback(self._logs.close)
            if self._why_rejected is None:
                self._logs.begin()  # before the clients of actions, so that servers know it first
            if options.has_controls:
                self._claim_controls(made)
            if options.has_presence:
                # Held, never used: servers in other processes see by it that this one is alive.
                presence = node.create_publisher(Empty, TOPIC, PRESENCE)
                made.callback(node.destroy_publisher, presence)
            self.executive = Executive(
                build_tree(mission, self.scope),
                self,
                self.trace,
                mission.observe,
                mission.name,
                node_details(mission),
            )
            self.created.emit(self)
            while self.created.raised:
                self.executive.events.raised.append(self.created.raised.pop())
            if options.has_controls:
                self.show_waypoints()
                services = ControlServices(node, self.controls, self.revise_on_request)
                made.callback(services.close)
            self.requirements = RequirementWatch(self, options.signals or LiveSignals)
            self.status_publisher = StatusPublisher(node, has_topics=options.has_controls)
            made.callback(self.status_publisher.close)
            self.status_publisher.begin(self, self.requirements)
            self.executive.after_tick.append(self.status_publisher.publish_if_changed)
            made.callback(node.destroy_timer, node.create_timer(1 / TICK_RATE_HZ, self.tick))
            self._exit = made.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            self.end_without_node()
            if not self.executive.status.is_final:
                why = "its caller has left"
                self.halt(why if kind is None else f"{why}: {kind.__name__}")
                see_to_the_end(self)
        finally:
            self.close()

    @property
    def status(self) -> MissionStatus:
        """The state of the mission; a mission whose node was destroyed has failed."""
        is_cut_off = not self.executive.status.is_final and self._is_node_gone
        return MissionStatus.FAILURE if is_cut_off else self.executive.status

    def report(self) -> Report:
        """Return the report of the run so far; a mission whose node was destroyed has failed."""
        self.end_without_node()
        executive = self.executive
        now_ns = executive.ended_ns or self.now_ns
        virtual_s = (now_ns - (executive.started_ns or now_ns)) / NS
        wall_s = self._wall.elapsed_s if self._wall_s is None else self._wall_s
        results = self.requirements.results()
        return report_on(
            self.mission, executive, self.trace, virtual_s, wall_s, results, self.warnings
        )

    def halt(self, reason: str = "halted by its caller") -> None:
        """Halt the tree and cancel every goal; later ticks wait until they end."""
        self.executive.interrupt(reason)

    def revise(
        self, mission: Mission, *, dry_run: bool = False, keep_goals: bool = False
    ) -> Revision:
        """Continue with another version of the mission, or say why that is not possible.

        Call it between two ticks. Nodes that stay continue, with their goals. Goals of nodes that
        change or are gone are cancelled, and no goal is sent before these have ended. A running
        node that changes starts again. Clean-ups of nodes that are gone run. If it is refused,
        nothing changes.

        Args:
            mission: The new version, as :func:`bt_mission.load` returns it.
            dry_run: Only say what would happen.
            keep_goals: Let leaves that run and change continue with the values with which they
                started; the new values apply when they start again.

        Raises:
            BtMissionError: It is called within a tick.
        """
        if self._tick_ns is not None:
            raise BtMissionError(
                "a mission cannot be revised within a tick; call revise() between two ticks",
                code="BT-908",
            )
        plan = self.plan_revision(mission, keep_goals=keep_goals)
        if dry_run:
            plan.build()
            return plan.preview()
        plan.build(self.revising.emit)
        return self.apply_revision(plan)

    def plan_revision(self, mission: Mission, *, keep_goals: bool = False) -> RevisionPlan:
        """Compare another version with the running one, as the first step of a revision."""
        return RevisionPlan(self.executive, self, self.mission, mission, keep_goals=keep_goals)

    def apply_revision(self, plan: RevisionPlan) -> Revision:
        """Exchange the trees, between two ticks, or say why that is not possible."""
        return plan.apply(self.revising.emit, self._accept)

    async def revise_on_request(self, request: Any) -> Revision:
        """Continue with the version that another process has sent.

        The work is done in three steps, each just after a tick, so that no tick is late: reading,
        comparing and building, exchanging. The result is the same at each instant of the request.

        Args:
            request: Of ``bt_mission_interfaces/srv/ReviseMission``.

        Raises:
            InputError: The new version has errors.
            BtMissionError: The mission was not started as editable.
        """
        if self._read_revision is None:
            raise BtMissionError(
                "the mission was not started with --editable, so it cannot change while it runs; "
                "start it with `bt-mission run MISSION --editable`",
                code="BT-908",
            )
        await self.next_tick()
        mission = self._read_revision(self.mission, request)
        await self.next_tick()
        plan = self.plan_revision(mission, keep_goals=request.keep_goals)
        plan.build(None if request.dry_run else self.revising.emit)
        if request.dry_run:
            return plan.preview()
        await self.next_tick()
        if not plan.is_current:
            return self.revise(mission, keep_goals=request.keep_goals)
        return self.apply_revision(plan)

    def next_tick(self) -> Future:
        """Return a future that is done after the next tick, or when the mission has ended."""
        self._after_tick = self._after_tick or Future()
        return self._after_tick

    def close(self) -> None:
        """Destroy the clients and topics on the node; further calls do nothing.

        A running mission is interrupted: its goals are cancelled, and not waited for.
        """
        self.end_without_node()
        self.executive.interrupt("closed by its caller")
        self.executive.abandon("")
        self._note_end()
        self._release()
        if self.node.context.ok() and not self._is_node_gone:
            self.status_publisher.publish_if_changed()
        self._exit.close()

    def show_waypoints(self) -> None:
        """Publish the poses of goals from now on; further calls do nothing."""
        if self._waypoints is None:
            self._waypoints = WaypointMarkers(self.node)
            self.executive.events.subscribe(self._waypoints.take, GoalChanged)

    @override
    def tick(self) -> None:
        try:
            super().tick()
        finally:
            if self.executive.status.is_final:
                self._note_end()
            if self._after_tick is not None:
                self._release()

    # ---- inside --------------------------------------------------------------------------

    @override
    def _listen(self, action: str) -> Callable[[], str]:
        why = self._why_rejected
        if why is None or why(action) is None:
            return self._logs.listen(action)
        return lambda: why(action) or ""

    def _accept(self, mission: Mission) -> None:
        self.mission = mission
        self.__dict__.pop("_subtrees", None)  # those of the tree before

    @override
    def _close_clients(self) -> None:
        super()._close_clients()
        if self._waypoints is not None:
            self._waypoints.close()

    def _claim_controls(self, made: ExitStack) -> None:
        """Take the topics for tools over from an earlier mission on this node that has ended."""
        before = _with_controls.get(id(self.node))
        if before is not None and before.node is self.node:
            if not before.executive.status.is_final:
                name = self.node.get_fully_qualified_name()
                raise BtMissionError(
                    f"mission '{before.mission.name}' runs on {name} and has its topics for tools: "
                    "close its runner first, or give this one RunnerOptions(has_controls=False)",
                    code="BT-914",
                )
            before.close()
        _with_controls[id(self.node)] = self
        made.callback(_with_controls.pop, id(self.node), None)

    def _release(self) -> None:
        """Let the coroutines that wait for a tick continue."""
        waiting, self._after_tick = self._after_tick, None
        if waiting is not None:
            waiting.set_result(None)

    def _note_end(self) -> None:
        if self._wall_s is None and self.executive.status.is_final:
            self._wall_s = self._wall.elapsed_s
