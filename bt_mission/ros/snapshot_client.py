"""A tree of py_trees_ros, as a watcher's node hears it: by a stream of snapshots of its own."""

from __future__ import annotations

from collections import deque
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.messages import Told, in_order
from bt_mission.events.snapshots import SnapshotReader
from bt_mission.events.source import ControlRequest, ControlResponse, Heard
from bt_mission.ros.graph import type_hash_of
from bt_mission.ros.interface_types import message_type, service_type
from bt_mission.ros.snapshot_messages import PACKAGE, TREE_TYPE
from bt_mission.ros.snapshot_streams import FOLDER

OPEN_TYPE = f"{PACKAGE}/srv/OpenSnapshotStream"
CLOSE_TYPE = f"{PACKAGE}/srv/CloseSnapshotStream"
OPEN = f"/{FOLDER}/open"
"""After the name of a tree's node."""

LIMITS = (
    "a tree of py_trees_ros: it can be looked at, and no more; "
    "pausing, steps, breakpoints, goals and progress are not available"
)

PERIOD_S = 0.5
"""What nodes say is as new as this; a change of status comes at once."""

SNAPSHOTS = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)

ANSWER_S = 3.0
"""Wall time after which a stream is asked for again."""

GONE_S = 2.0
"""Wall time without a publisher after which a stream counts as gone."""


class SnapshotClient:
    """One tree of py_trees_ros, as a node hears it. Opens a stream, and another when it breaks.

    Args:
        node: Owns the subscription; somebody serves it.
        name: Of the tree's node, such as ``/tree``.
        has_variables: Ask for the blackboard, too: the tree's process then writes each variable
            as text.
    """

    limits = LIMITS

    def __init__(self, node: Node, name: str, *, has_variables: bool = False) -> None:
        self.name = name
        self._node = node
        self._has_variables = has_variables
        self._kind = message_type(TREE_TYPE)
        self._opener = node.create_client(service_type(OPEN_TYPE), f"{name}{OPEN}")
        self._closer = node.create_client(service_type(CLOSE_TYPE), f"{name}/{FOLDER}/close")
        self._reader = SnapshotReader()
        self._snapshots: deque[Any] = deque(maxlen=SNAPSHOTS.depth)
        self._news: list[Told] = []
        self._answers: list[ControlResponse] = []
        self._asked: tuple[Future, Stopwatch] | None = None
        self._topic = ""
        self._subscription: Any = None
        self._since_published = Stopwatch()
        self._closing: Future | None = None
        self._has_left = False

    @property
    def is_there(self) -> bool:
        """Is the tree in the graph?"""
        return bool(self._opener.service_is_ready())

    @property
    def is_closed(self) -> bool:
        """After :meth:`close`: has the tree closed the stream? Ask again until it has."""
        if self._closing is None and self._asked is not None and self._asked[0].done():
            self._take_answer()
            self._ask_to_close()
        if self._closing is None:
            return self._asked is None or not self.is_there
        return self._closing.done() or not self.is_there

    def take(self, *, needs_statuses: bool) -> Heard:
        """What has come since the last time."""
        self._keep_open()
        told, self._news = self._news, []
        while self._snapshots:
            told += self._reader.take(self._snapshots.popleft())
        if needs_statuses:
            told += self._reader.statuses()
        answers, self._answers = tuple(self._answers), []
        return Heard(tuple(in_order(told)), (), answers)

    def send(self, _command: ControlRequest) -> None:
        """Answer that this cannot be done."""
        self._answers.append(ControlResponse(False, f"not available: {self.name} is {LIMITS}"))

    def watch_camera(self, *, is_on: bool) -> None:
        """Do nothing: such a tree does not say which robot is its own."""

    def close(self) -> None:
        """Listen no longer, and have the tree close the stream; see :attr:`is_closed`."""
        self._has_left = True
        self._ask_to_close()

    # ---- inside --------------------------------------------------------------------------

    def _keep_open(self) -> None:
        """Open a stream where there is none, and notice when it has gone."""
        if not self.is_there:
            self._forget()
        elif self._topic:
            if self._node.count_publishers(self._topic):
                self._since_published = Stopwatch()
                self._listen()
            elif self._since_published.elapsed_s > GONE_S:
                self._forget()
        elif self._asked is None:
            request = service_type(OPEN_TYPE).Request()
            request.parameters.snapshot_period = PERIOD_S
            request.parameters.blackboard_data = self._has_variables
            self._asked = (self._opener.call_async(request), Stopwatch())
        elif self._asked[0].done():
            self._take_answer()
        elif self._asked[1].elapsed_s > ANSWER_S:
            self._asked = None

    def _take_answer(self) -> None:
        assert self._asked is not None
        future, since = self._asked
        self._topic = future.result().topic_name
        self._since_published = Stopwatch()
        if self._topic or self._has_left:
            self._asked = None
            return
        self._news += self._reader.refused("it opened no stream: its own log says why")
        if since.elapsed_s > ANSWER_S:
            self._asked = None

    def _listen(self) -> None:
        """Subscribe, unless its messages are of another version."""
        if self._subscription is not None:
            return
        own = type_hash_of(self._node, self._kind)
        for one in self._node.get_publishers_info_by_topic(self._topic):
            theirs = one.topic_type_hash
            if theirs != own and theirs.version > 0:  # older releases of ROS do not tell it
                why = f"its snapshots are of another version of {PACKAGE}"
                self._news += self._reader.refused(why)
                return
        self._subscription = self._node.create_subscription(
            self._kind, self._topic, self._keep, SNAPSHOTS
        )

    def _keep(self, snapshot: Any) -> None:
        self._snapshots.append(snapshot)

    def _forget(self) -> None:
        """Let go of a stream that has gone, as with its process."""
        self._topic, self._asked = "", None
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _ask_to_close(self) -> None:
        if self._topic and self.is_there:
            request = service_type(CLOSE_TYPE).Request(topic_name=self._topic)
            self._closing = self._closer.call_async(request)
        if self._asked is None:
            self._forget()
