"""Executives of this process and their robots, for a view: their messages need no middleware."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

from rclpy.node import Node
from typing_extensions import override

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events import messages, reader
from bt_mission.executive.events.events import Event
from bt_mission.executive.events.source import ListedExecutive, Received
from bt_mission.ros import event_messages, robot_relay, status_publisher
from bt_mission.ros.graph import quiet_node
from bt_mission.ros.mission_client import TOPICS, MissionClient
from bt_mission.ros.mission_details import MissionDetailsBuilder
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.ros.robot_relay import RobotSnapshot


class LocalRun(Protocol):
    """The run of one mission in this process, such as :class:`bt_mission.sessions.session.Run`."""

    @property
    def node(self) -> Node:
        """The node below whose name the topics of the mission are."""

    @property
    def runner(self) -> MissionRunner:
        """Runs the mission."""

    def snapshot(self) -> RobotSnapshot | None:
        """Return the state of a simulated robot; None where the robot is not simulated here."""


class LocalClient(MissionClient):
    """As :class:`MissionClient`, for an executive of this process.

    Its events, and the snapshots of a simulated robot, are read directly: the cost of watching is
    less than half of that by topics. The map, pictures and requests use the topics and services.

    Args:
        node: The node of the subscriptions; the caller serves it.
        run: The run to watch.
    """

    def __init__(self, node: Node, run: LocalRun) -> None:
        self._run = run
        self._details = MissionDetailsBuilder(run.runner)
        self._since_details, self._since_snapshot = Stopwatch(), Stopwatch()
        self._is_simulated = run.snapshot() is not None
        super().__init__(node, run.node.get_fully_qualified_name())

    @override
    def take(self, *, needs_statuses: bool) -> Received:
        tree = self._run.runner.executive.mission_state.tree
        if (
            tree is not None
            and tree.time_ns
            and self._since_details.elapsed_s >= status_publisher.DETAILS_PERIOD_S
        ):
            self._since_details = Stopwatch()
            self._keep(reader.details, self._details.describe_changes())
        received = super().take(needs_statuses=needs_statuses)
        return replace(received, robot=(*received.robot, *self._robot_now()))

    @override
    def close(self) -> None:
        self._run.runner.status_publisher.remove(self._keep_status)
        self._run.runner.executive.events.unsubscribe(self._keep_log)
        super().close()

    # ---- inside --------------------------------------------------------------------------

    @override
    def _subscribe_to_mission(self) -> list[Any]:
        self._run.runner.status_publisher.add(self._keep_status)
        self._run.runner.executive.events.subscribe(self._keep_log)
        return []

    @override
    def _subscribe_to_robot(self, prefix: str) -> list[Any]:
        return [] if self._is_simulated else super()._subscribe_to_robot(prefix)

    def _keep_status(self, what: str, message: Any) -> None:
        self._keep(TOPICS[what][2], message)

    def _keep_log(self, event: Event) -> None:
        if event.event_topic == "log":
            executive = self._run.runner.executive
            line = event_messages.log(event, executive.run, executive.node_infos)
            self._keep(reader.log, line)

    def _robot_now(self) -> tuple[messages.Robot, ...]:
        if not self._is_simulated or self._since_snapshot.elapsed_s < robot_relay.EVERY_S:
            return ()
        self._since_snapshot = Stopwatch()
        look = self._run.snapshot()
        assert look is not None, "the robot is simulated"
        base = messages.FrameTransform("map", "base_footprint", *look.pose)
        lidar = messages.FrameTransform("base_footprint", "base_scan", *look.lidar)
        step, (least, most) = math.tau / len(look.ranges), look.reach
        ranges = tuple(look.ranges.tolist())
        scan = messages.ScanPoints("base_scan", 0.0, step, least, most, ranges)
        if look.charge is None:
            return ((base, lidar), scan)
        return ((base, lidar), scan, messages.BatteryState(look.charge, look.voltage))


class LocalSession(Protocol):
    """A session that serves a further node, such as :class:`bt_mission.sessions.stage.Stage`."""

    @property
    def runs(self) -> Sequence[LocalRun]:
        """Its missions, at least one."""

    @property
    def is_done(self) -> bool:
        """Whether the missions have ended."""

    def add_node(self, node: Node) -> None:
        """Serve it, too."""

    def drain(self) -> None:
        """Serve what is on its way, without a step."""


class LocalExecutive:
    """The executives of this process as a graph; their session serves the subscriptions.

    Args:
        session: Serves the subscriptions.
    """

    where = "this process"

    def __init__(self, session: LocalSession) -> None:
        self._runs = {run.node.get_fully_qualified_name(): run for run in session.runs}
        self.name = next(iter(self._runs))
        """The name of the first executive."""
        self._session = session
        self._node = quiet_node("bt_mission_screen", session.runs[0].node.context)
        session.add_node(self._node)

    def serve(self) -> None:
        """The session serves, step by step; messages of its last step are handled after it."""
        if self._session.is_done:
            self._session.drain()

    def find(self) -> tuple[ListedExecutive, ...]:
        """All of them."""
        return tuple(ListedExecutive(name) for name in self._runs)

    def attach(self, name: str) -> LocalClient:
        """Return the source of an executive."""
        return LocalClient(self._node, self._runs[name])

    def close(self) -> None:
        """Leave, before the session is closed."""
        self._node.destroy_node()
