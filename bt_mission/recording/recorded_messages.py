"""A recording as a stream of all its messages, in the order of the file.

:func:`recorded_messages` reads a file once. It alone finds the meaning of a message
from its topic and type. Reports, replays, verdicts and forks are folds of it (:func:`fold`). A
message is decoded when a fold reads it, and only once.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from bt_mission.cdr.decoder import DecodedMessage, DecodingError
from bt_mission.executive.events import messages, reader
from bt_mission.executive.events.codec import event_of, knows
from bt_mission.executive.events.events import Event
from bt_mission.recording.expected_types import is_installed
from bt_mission.recording.reading import UNREADABLE, Channel, RecordedFile

TREE = "bt_mission_interfaces/msg/Tree"
EXECUTIVE: Mapping[str, Callable[[Any], messages.Batch]] = {
    TREE: reader.tree,
    "bt_mission_interfaces/msg/StatusChanges": reader.changes,
    "bt_mission_interfaces/msg/MissionState": reader.state,
    "bt_mission_interfaces/msg/MissionDetails": reader.details,
    "bt_mission_interfaces/msg/MissionLog": reader.log,
    "bt_mission_interfaces/msg/Requirements": reader.requirements,
}
"""Readers of messages of an executive, by type."""

TEXT = "std_msgs/msg/String"
OURS = "bt_mission_interfaces/msg/"
TRACE, SIGNALS = "trace", "signals"
"""Topics of an executive that carry lines of JSON."""

TRUTH, ODOMETRY = "ground_truth/odom", "odom"
ROBOT: Mapping[str, str] = {
    ODOMETRY: "nav_msgs/msg/Odometry",
    TRUTH: "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
    "battery_state": "sensor_msgs/msg/BatteryState",
    "map": "nav_msgs/msg/OccupancyGrid",
    "collisions": "bt_mission_interfaces/msg/Collision",
    "tf": "tf2_msgs/msg/TFMessage",
    "tf_static": "tf2_msgs/msg/TFMessage",
    "zones": "visualization_msgs/msg/MarkerArray",
}
"""The topics of a robot within its namespace, and their types."""

VIEWED: Mapping[str, Callable[[Any], messages.Robot]] = {
    "tf": reader.transforms,
    "tf_static": reader.transforms,
    "battery_state": reader.battery,
    "scan": reader.scan,
    "map": reader.grid,
    "zones": reader.zones,
}
"""Readers of messages that viewers show, by topic."""

_NAME = re.compile(rb'"event": "([^"\\]*)"')
_POSE = b'"event": "pose"'


class RecordedMessage:
    """A message of any topic. It is decoded when it is first looked at."""

    __slots__ = ("_message", "channel", "data")

    def __init__(self, channel: Channel, data: bytes) -> None:
        self.channel = channel
        self.data = data
        self._message: DecodedMessage | None = None

    @property
    def message(self) -> DecodedMessage:
        """Its fields.

        Raises:
            DecodingError: Where the definition of its type does not fit it.
        """
        if self._message is None:
            self._message = self.channel.decode(self.data)
        return self._message

    def forget(self) -> None:
        """Drop the decoded fields: who keeps the message keeps its bytes only."""
        self._message = None


class MissionMessage(RecordedMessage):
    """A message of the mission's executive."""

    __slots__ = ()

    @property
    def node(self) -> str:
        """Full name of the executive's node."""
        return self.channel.topic.rpartition("/")[0]


class ExecutiveMessage(MissionMessage):
    """A message of the mission's executive with events."""

    __slots__ = ()

    @property
    def batch(self) -> messages.Batch:
        """The events, and the run that they belong to."""
        return EXECUTIVE[self.channel.type_name](self.message)


class _JsonLine(MissionMessage):
    __slots__ = ()

    @property
    def text(self) -> str:
        """The line."""
        self.channel.expect(TEXT)
        return str(self.message["data"])

    @property
    def fields(self) -> dict[str, Any]:
        """The fields of the line.

        Raises:
            ValueError: For a line that is not a JSON object.
        """
        fields = json.loads(self.text)
        if not isinstance(fields, dict):
            raise DecodingError("a line is expected to be a JSON object")
        return fields


class TraceLine(_JsonLine):
    """A line of the mission's trace; it lies where it was written, between two control steps."""

    __slots__ = ()

    @property
    def is_pose(self) -> bool:
        """Whether it is the line of a control step."""
        return _POSE in self.data

    @property
    def name(self) -> str:
        """The name of its event; empty for the first line, which names the format."""
        name = _NAME.search(self.data)
        return "" if name is None else name[1].decode(errors="replace")

    def event(self, indices: Mapping[str, int]) -> Event | None:
        """Return its event; None for an unknown one.

        Args:
            indices: The indices of the nodes by path.
        """
        return event_of(self.fields, indices)


class SignalLine(_JsonLine):
    """The signals of a control step."""

    __slots__ = ()


class RobotMessage(RecordedMessage):
    """A message of a robot's sensors.

    Attributes:
        namespace: Of the robot, without a slash at its end.
        topic: Within the namespace: a key of :data:`ROBOT`.
    """

    __slots__ = ("namespace", "topic")

    def __init__(self, namespace: str, topic: str, channel: Channel, data: bytes) -> None:
        super().__init__(channel, data)
        self.namespace, self.topic = namespace, topic

    def check_type(self) -> None:
        """Raise DecodingError where the topic has another type than a robot's."""
        self.channel.expect(ROBOT[self.topic])

    def viewed(self) -> messages.Robot:
        """Return what viewers show of it; the decoded message is not kept."""
        self.check_type()
        return VIEWED[self.topic](self.channel.decode(self.data))


class OtherRobotMessage(RobotMessage):
    """The true pose of another robot whose mission is in the recording, too."""

    __slots__ = ()


class GoalMessage(RecordedMessage):
    """A message between an action's client and its server.

    Attributes:
        action: Its name.
        part: ``feedback``, ``send_goal/_service_event``, ...
    """

    __slots__ = ("action", "part")

    def __init__(self, action: str, part: str, channel: Channel, data: bytes) -> None:
        super().__init__(channel, data)
        self.action, self.part = action, part


class RosoutMessage(RecordedMessage):
    """A line of ``/rosout``."""

    __slots__ = ()


class PictureMessage(RecordedMessage):
    """A compressed image of a camera."""

    __slots__ = ()


Make = Callable[[Channel, bytes], RecordedMessage]


def recorded_messages(file: RecordedFile) -> Iterator[tuple[int, RecordedMessage]]:
    """Yield everything in a file with its time, ns.

    Messages of the chosen robot and of its mission's executive have separate classes. If the
    recorder has not named the executive, it is the one with the first tree. All other messages are
    plain :class:`RecordedMessage`. Events and types of a newer version are noted in the file.

    Raises:
        RecordingError: For a file that is not a recording, or that cannot be opened.
    """
    makes: dict[int, tuple[Make, Channel]] = {}
    node = ""
    for time_ns, channel, data in file.timed_messages():
        make = makes.get(id(channel))
        if make is None:
            make = makes[id(channel)] = (_kind_of(channel, file), channel)
        happening = make[0](channel, data)
        if isinstance(happening, MissionMessage):
            if node not in ("", happening.node):
                happening = RecordedMessage(channel, data)
            elif isinstance(happening, TraceLine):
                name = happening.name
                if name and not knows(name):
                    file.note_unknown(name)
            elif not node and channel.type_name == TREE and _is_readable(happening):
                node = happening.node
        yield time_ns, happening


def fold(
    file: RecordedFile,
    *takes: Callable[[int, Any], None],
    among: Iterable[tuple[int, RecordedMessage]] | None = None,
) -> None:
    """Pass on everything in a file; what cannot be read is noted in the file, once a message.

    Args:
        takes: Each is called with the time, ns, and the message.
        among: These messages of the file instead of all.

    Raises:
        RecordingError: As :func:`recorded_messages`.
    """
    for time_ns, happening in recorded_messages(file) if among is None else among:
        unread: Exception | None = None
        for take in takes:
            try:
                take(time_ns, happening)
            except UNREADABLE as error:
                unread = unread or error
        if unread is not None:
            file.note_unread(happening.channel, unread)
        happening.forget()


def _is_readable(happening: RecordedMessage) -> bool:
    try:
        return bool(EXECUTIVE[TREE](happening.message).events)
    except UNREADABLE:
        return False  # the fold notes it


def _kind_of(channel: Channel, file: RecordedFile) -> Make:
    """Return the class of a topic's messages."""
    topic, type_name = channel.topic, channel.type_name
    if file.is_of_another(topic):
        is_truth = topic.endswith(f"/{TRUTH}")
        place = topic.removesuffix(f"/{TRUTH}")
        return partial(OtherRobotMessage, place, TRUTH) if is_truth else RecordedMessage
    if type_name == "rcl_interfaces/msg/Log":
        return partial(_rosout, file)
    if type_name == "sensor_msgs/msg/CompressedImage":
        return PictureMessage
    action, is_part, part = topic.partition("/_action/")
    if is_part:
        return partial(GoalMessage, action, part)
    kind = _executive_kind(topic, type_name) if file.is_of_mission(topic) else None
    return kind or _robot_kind(topic, type_name, file)


def _executive_kind(topic: str, type_name: str) -> Make | None:
    if type_name in EXECUTIVE:
        return ExecutiveMessage
    return {TRACE: TraceLine, SIGNALS: SignalLine}.get(topic.rpartition("/")[2])


def _robot_kind(topic: str, type_name: str, file: RecordedFile) -> Make:
    if type_name.startswith(OURS) and not is_installed(type_name):
        return partial(_unknown, file)
    place, _, name = topic.rpartition("/")
    if topic.endswith(f"/{TRUTH}"):
        place, name = topic.removesuffix(f"/{TRUTH}"), TRUTH
    if name not in ROBOT or (name == "zones" and type_name != ROBOT[name]):
        return RecordedMessage  # markers of that name are not always zones
    return partial(RobotMessage, place, name)


def _rosout(file: RecordedFile, channel: Channel, data: bytes) -> RecordedMessage:
    """Return a line of the log; a plain message if it is of another robot."""
    line = RosoutMessage(channel, data)
    try:
        is_of_another = file.is_of_another(f"/{line.message.name.replace('.', '/')}")
    except UNREADABLE:
        is_of_another = False  # the fold notes it
    return RecordedMessage(channel, data) if is_of_another else line


def _unknown(file: RecordedFile, channel: Channel, data: bytes) -> RecordedMessage:
    file.note_unread(channel, DecodingError("an unknown type in this version of bt-mission"))
    return RecordedMessage(channel, data)
