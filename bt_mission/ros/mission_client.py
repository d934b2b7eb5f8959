"""One executive and its robot, as a viewer's node receives them, and requests to them.

Nothing here waits: the caller reads what was received. Robots are subscribed to with best effort
and short queues, so that a slow viewer costs nothing elsewhere.
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
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import BatteryState, Image, LaserScan
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events import messages, reader
from bt_mission.executive.events.feed import in_order
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.source import ControlRequest, ControlResponse, Received, Verb
from bt_mission.ros.graph import LATCHED, REQUESTS

ALL = QoSProfile(depth=1000)
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
FRAMES = QoSProfile(depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)
STATIC_FRAMES = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)

TOPICS: dict[str, tuple[Any, QoSProfile, Callable[[Any], Batch]]] = {
    "tree": (Tree, LATCHED, reader.tree),
    "requirements": (Requirements, LATCHED, reader.requirements),
    "changes": (StatusChanges, ALL, reader.changes),
    "state": (MissionState, LATCHED, reader.state),
    "details": (MissionDetails, ALL, reader.details),
    "log": (MissionLog, ALL, reader.log),
}
"""The topics of an executive below its name."""

ROBOT: dict[str, tuple[Any, QoSProfile, Callable[[Any], messages.Robot]]] = {
    "scan": (LaserScan, NEWEST, reader.scan),
    "battery_state": (BatteryState, NEWEST, reader.battery),
}
"""The topics of a robot with many messages a second, apart from its frames."""

SURROUNDINGS: dict[str, tuple[Any, Callable[[Any], messages.Robot]]] = {
    "map": (OccupancyGrid, reader.grid),
    "zones": (MarkerArray, reader.zones),
}
"""Topics on the robot's surroundings, which are published once."""

LOOK_S = 0.25
"""Wall time between two looks at the graph."""

ASK_AGAIN_S = 1.0
"""Wall time after which statuses are requested again."""

ANSWER_S = 3.0
"""Wall time after which a wish counts as unanswered."""

TRIGGERS = {Verb.RESUME: "resume", Verb.STEP: "step", Verb.STOP: "stop"}


class MissionClient:
    """One executive and its robot, as a node receives them.

    Args:
        node: The node of the subscriptions; the caller serves it.
        name: The executive's name, such as ``/robot1/bt_mission``.
        with_robot: Receive its robot, too.
    """

    def __init__(self, node: Node, name: str, *, with_robot: bool = True) -> None:
        self.name = name
        self._with_robot = with_robot
        self._node = node
        self._batches: deque[Batch] = deque()
        self._raw: deque[tuple[Callable[[Any], Batch], Any]] = deque()
        self._robot: dict[str, tuple[Callable[[Any], messages.Robot], Any]] = {}
        self._frames: deque[Any] = deque(maxlen=100)
        self._answers: deque[ControlResponse] = deque()
        self._asked: list[tuple[Future, str, Stopwatch]] = []
        self._since_asked: Stopwatch | None = None
        self._since_look: Stopwatch | None = None
        self._is_there = False
        self._ears = self._subscribe_to_mission()
        self._robot_ears: list[Any] = []
        self._robot_prefix: str | None = None
        self._camera: Any = None
        self._image: Any = None
        client = partial(node.create_client, qos_profile=REQUESTS)
        self._statuses = client(GetStatuses, f"{name}/statuses")
        self._pause = client(PauseMission, f"{name}/pause")
        self._breakpoint = client(SetBreakpoint, f"{name}/breakpoint")
        self._triggers = {
            verb: client(Trigger, f"{name}/{service}") for verb, service in TRIGGERS.items()
        }
        self._tune_in()

    @property
    def is_there(self) -> bool:
        """Whether the executive is in the graph."""
        if self._since_look is None or self._since_look.elapsed_s > LOOK_S:
            self._since_look = Stopwatch()
            self._is_there = self._node.count_publishers(f"{self.name}/state") > 0
            self._tune_in()
        return self._is_there

    def take(self, *, needs_statuses: bool) -> Received:
        """Return what was received since the last call."""
        if needs_statuses:
            self._ask_statuses()
        self._settle()
        while self._raw:
            read, message = self._raw.popleft()
            self._batches.append(read(message))
        robot: list[messages.Robot] = [reader.transforms(frame) for frame in self._frames]
        robot += [read(message) for read, message in self._robot.values()]
        image = None if self._image is None else reader.image(self._image)
        batches = tuple(in_order(self._batches))
        received = Received(batches, tuple(robot), tuple(self._answers), image)
        self._image = None
        for queue in (self._batches, self._frames, self._answers):
            queue.clear()
        self._robot.clear()
        return received

    def send(self, command: ControlRequest) -> None:
        """Pass a wish on."""
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
        """Hear the robot's camera, or no longer."""
        if is_on and self._camera is None:
            topic = f"{self.name.rpartition('/')[0]}/camera/image_raw"
            self._camera = self._listen(Image, topic, self._keep_image, NEWEST)
        elif not is_on and self._camera is not None:
            self._node.destroy_subscription(self._camera)
            self._camera = self._image = None

    def close(self) -> None:
        """Listen no longer."""
        self.watch_camera(is_on=False)
        for subscription in (*self._ears, *self._robot_ears):
            self._node.destroy_subscription(subscription)
        for client in (self._statuses, self._pause, self._breakpoint, *self._triggers.values()):
            self._node.destroy_client(client)

    # ---- inside: callbacks only keep messages, so that none of them can raise ----------------

    def _listen(self, kind: Any, topic: str, keep: Callable[[Any], Any], qos: QoSProfile) -> Any:
        return self._node.create_subscription(kind, topic, keep, qos)

    def _subscribe_to_mission(self) -> list[Any]:
        return [
            self._listen(kind, f"{self.name}/{topic}", partial(self._keep, read), qos)
            for topic, (kind, qos, read) in TOPICS.items()
        ]

    def _tune_in(self) -> None:
        """Subscribe to the robot: the snapshots of its stage for viewers, else its topics."""
        own = self.name.rpartition("/")[0]
        is_relayed = self._node.count_publishers(f"{self.name}/scan") > 0
        prefix = self.name if is_relayed else own
        if not self._with_robot or prefix == self._robot_prefix:
            return
        self._robot_prefix = prefix
        for subscription in self._robot_ears:
            self._node.destroy_subscription(subscription)
        self._robot_ears = [*self._subscribe_to_robot(prefix), *self._subscribe_to_map(own)]

    def _subscribe_to_robot(self, prefix: str) -> list[Any]:
        return [
            *(
                self._listen(kind, f"{prefix}/{name}", partial(self._keep_newest, name, read), qos)
                for name, (kind, qos, read) in ROBOT.items()
            ),
            self._listen(TFMessage, f"{prefix}/tf", self._keep_frames, FRAMES),
        ]

    def _subscribe_to_map(self, own: str) -> list[Any]:
        return [
            *(
                self._listen(kind, f"{own}/{name}", partial(self._keep_newest, name, read), LATCHED)
                for name, (kind, read) in SURROUNDINGS.items()
            ),
            self._listen(TFMessage, f"{own}/tf_static", self._keep_frames, STATIC_FRAMES),
        ]

    def _keep(self, read: Callable[[Any], Batch], message: Any) -> None:
        self._raw.append((read, message))

    def _keep_newest(self, topic: str, read: Callable[[Any], messages.Robot], message: Any) -> None:
        self._robot[topic] = (read, message)

    def _keep_image(self, message: Any) -> None:
        self._image = message

    def _keep_frames(self, message: Any) -> None:
        self._frames.append(message)

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
