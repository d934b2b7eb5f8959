"""One executive and its robot, as a viewer's node receives them, and requests to them.

Nothing here waits: the caller reads what was received.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from bt_mission_interfaces.msg import (
    MissionDetails,
    MissionLog,
    MissionState,
    Requirements,
    StatusChanges,
    Tree,
)
from bt_mission_interfaces.srv import GetStatuses, PauseMission, SetBreakpoint
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_srvs.srv import Trigger

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events import reader
from bt_mission.executive.events.feed import in_order
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.source import ControlRequest, ControlResponse, Received, Verb
from bt_mission.ros.control_services import TRIGGERS
from bt_mission.ros.graph import LATCHED, REQUESTS
from bt_mission.ros.robot_topics import RobotTopics

ALL = QoSProfile(depth=1000)

TOPICS: dict[str, tuple[Any, QoSProfile, Callable[[Any], Batch]]] = {
    "tree": (Tree, LATCHED, reader.tree),
    "requirements": (Requirements, LATCHED, reader.requirements),
    "changes": (StatusChanges, ALL, reader.changes),
    "state": (MissionState, LATCHED, reader.state),
    "details": (MissionDetails, ALL, reader.details),
    "log": (MissionLog, ALL, reader.log),
}
"""The topics of an executive below its name."""

LOOK_S = 0.25
"""Wall time between two looks at the graph."""

ASK_AGAIN_S = 1.0
"""Wall time after which statuses are requested again."""

ANSWER_S = 3.0
"""Wall time after which a request counts as unanswered."""


class MissionClient:
    """One executive and its robot, as a node receives them.

    Args:
        node: The node of the subscriptions; the caller serves it.
        name: The executive's name, such as ``/robot1/bt_mission``.
        with_robot: Receive its robot, too.
    """

    def __init__(self, node: Node, name: str, *, with_robot: bool = True) -> None:
        self.name = name
        self._node = node
        self._batches: deque[Batch] = deque()
        self._raw: deque[tuple[Callable[[Any], Batch], Any]] = deque()
        self._answers: deque[ControlResponse] = deque()
        self._asked: list[tuple[Future, str, Stopwatch]] = []
        self._since_asked: Stopwatch | None = None
        self._since_look: Stopwatch | None = None
        self._is_there = False
        self._robot = RobotTopics(node, name.rpartition("/")[0]) if with_robot else None
        self._subscriptions = [
            node.create_subscription(kind, f"{name}/{topic}", partial(self._keep, read), qos)
            for topic, (kind, qos, read) in TOPICS.items()
        ]
        client = partial(node.create_client, qos_profile=REQUESTS)
        self._statuses = client(GetStatuses, f"{name}/statuses")
        self._pause = client(PauseMission, f"{name}/pause")
        self._breakpoint = client(SetBreakpoint, f"{name}/breakpoint")
        self._triggers = {
            verb: client(Trigger, f"{name}/{service}") for verb, service in TRIGGERS.items()
        }
        self._find_robot()

    @property
    def is_there(self) -> bool:
        """Whether the executive is in the graph."""
        if self._since_look is None or self._since_look.elapsed_s > LOOK_S:
            self._since_look = Stopwatch()
            self._is_there = self._node.count_publishers(f"{self.name}/state") > 0
            self._find_robot()
        return self._is_there

    def take(self, *, needs_statuses: bool) -> Received:
        """Return what was received since the last call."""
        if needs_statuses:
            self._ask_statuses()
        self._settle()
        while self._raw:
            read, message = self._raw.popleft()
            self._batches.append(read(message))
        readings, image = ((), None) if self._robot is None else self._robot.take()
        received = Received(tuple(in_order(self._batches)), readings, tuple(self._answers), image)
        self._batches.clear()
        self._answers.clear()
        return received

    def send(self, command: ControlRequest) -> None:
        """Send a request to the executive."""
        match command.verb:
            case Verb.PAUSE | Verb.PAUSE_KEEPING_GOALS:
                keep = command.verb is Verb.PAUSE_KEEPING_GOALS
                self._ask(self._pause, PauseMission.Request(keep_goals=keep))
            case Verb.BREAK | Verb.UNBREAK:
                remove = command.verb is Verb.UNBREAK
                self._ask(self._breakpoint, SetBreakpoint.Request(node=command.node, remove=remove))
            case verb:
                self._ask(self._triggers[verb], Trigger.Request())

    def watch_camera(self, *, is_on: bool) -> None:
        """Receive the images of the robot's camera, or no longer."""
        if self._robot is not None:
            self._robot.watch_camera(is_on=is_on)

    def close(self) -> None:
        """Destroy the subscriptions and clients."""
        if self._robot is not None:
            self._robot.close()
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        for client in (self._statuses, self._pause, self._breakpoint, *self._triggers.values()):
            self._node.destroy_client(client)

    # ---- inside: callbacks only keep messages, so that none of them can raise ----------------

    def _find_robot(self) -> None:
        """Take the snapshots of the robot's stage for viewers, or else its topics."""
        if self._robot is not None:
            is_relayed = self._node.count_publishers(f"{self.name}/scan") > 0
            self._robot.follow(self.name if is_relayed else self.name.rpartition("/")[0])

    def _keep(self, read: Callable[[Any], Batch], message: Any) -> None:
        self._raw.append((read, message))

    def _ask_statuses(self) -> None:
        if self._since_asked is not None and self._since_asked.elapsed_s < ASK_AGAIN_S:
            return
        if not self._statuses.service_is_ready():
            return
        self._since_asked = Stopwatch()
        self._statuses.call_async(GetStatuses.Request()).add_done_callback(
            lambda future: self._raw.append((reader.statuses, future.result()))
        )

    def _ask(self, client: Any, request: Any) -> None:
        if not client.service_is_ready():
            self._answers.append(ControlResponse(False, f"{client.srv_name} has no server"))
            return
        self._asked.append((client.call_async(request), client.srv_name, Stopwatch()))

    def _settle(self) -> None:
        """Handle the responses to requests."""
        waiting = []
        for future, service, since in self._asked:
            if future.done():
                answer = future.result()
                self._answers.append(ControlResponse(answer.success, answer.message))
            elif since.elapsed_s > ANSWER_S:
                self._answers.append(ControlResponse(False, f"{service} does not answer"))
            else:
                waiting.append((future, service, since))
        self._asked = waiting
