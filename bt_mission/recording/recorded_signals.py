"""The signals of requirements, from a recording of this package or of any robot's topics."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from bt_mission.base.stamps import NS
from bt_mission.executive.events.events import NodeInfo, RunStarted, TreeRevised
from bt_mission.language.expressions.values import Plain
from bt_mission.language.mission import Requirement
from bt_mission.recording.facts import LARGEST_NS
from bt_mission.recording.reading import UNREADABLE, RecordedFile, RecordingError
from bt_mission.recording.recorded_messages import (
    TRUTH,
    ExecutiveMessage,
    RecordedMessage,
    SignalLine,
    fold,
)
from bt_mission.recording.recorded_mission import RecordedMission
from bt_mission.recording.signal_samples import ACCEPTED_GOALS, MODEL_FILE
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.formula import root_of, signals_in
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.signals import (
    BATTERY,
    ODOMETRY,
    OF_ODOMETRY,
    SCAN,
    PathLength,
    SimulationModel,
    field_of,
    smallest_range,
)
from bt_mission.sessions.stage_signals import OF_STATE, RecordedTruth

BY_ODOMETRY = ("speed", "turn_rate", "distance")
"""Signals that are true in a simulation, and measured by the robot elsewhere."""
MISSION = frozenset(
    ("$", *(name for name, known in SIGNALS.items() if known.known_by == "mission"))
)
MOST_BYTES = 100_000_000
"""Of the model of a simulation."""
_OF_TOPICS: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
    "scan_clearance": (SCAN, smallest_range),
    "battery": (BATTERY, lambda message: float(message.percentage)),
    **{name: (ODOMETRY, read) for name, read in OF_ODOMETRY.items() if "." in name},
}
_OF_TRUTH = {name.removeprefix("odometry."): read for name, read in OF_ODOMETRY.items()}
"""Signals of ``ground_truth/odom``, if the simulation's states were not recorded."""


class RecordingSurvey:
    """The content of a recording, known before its signals are read: a fold of all messages."""

    def __init__(self, file: RecordedFile) -> None:
        self.file = file
        self.topics: dict[str, str] = {}
        """Types, by the names of topics."""
        self.tree: RunStarted | None = None
        self.node = ""
        """Full name of the executive's node; empty without one."""
        self.nodes: dict[NodeInfo, None] = {}
        """The nodes of the trees of all versions of the mission."""
        self.is_in_order = True
        """Whether the messages are in the order of time."""
        self._newest_ns, self._oldest_ns = 0, LARGEST_NS
        self._first_samples: dict[str, Mapping[str, Any]] = {}

    @classmethod
    def of(cls, file: RecordedFile) -> Self:
        """Read a file.

        Raises:
            RecordingError: The file is invalid, cannot be opened, or has no message.
        """
        survey = cls(file)
        fold(file, survey.take)
        if file.first_ns is None:
            why = f": {file.why_cut}" if file.why_cut else ""
            raise RecordingError(f"{file.path}: contains no messages{why}")
        return survey

    @property
    def first_ns(self) -> int:
        """The time of the oldest message."""
        return self._oldest_ns

    @property
    def first_sample(self) -> Mapping[str, Any] | None:
        """The first line of signals; None if they were not recorded."""
        return self._first_samples.get(self.node) if self.node else None

    @property
    def start_ns(self) -> int:
        """ROS time of the mission's start, or of the recording's without one."""
        if self.first_sample is not None:
            return int(self.first_sample.get("start", self.first_ns))
        return self.first_ns if self.tree is None else self.file.started_ns(self.tree.time_ns)

    def model(self) -> SimulationModel:
        """Return the model of the simulation. Raises ValueError with why it cannot be read."""
        for attached in self.file.attached:
            if attached.name == MODEL_FILE:
                try:
                    data = zlib.decompressobj(wbits=31).decompress(attached.data, MOST_BYTES)
                except zlib.error as error:
                    raise ValueError(f"the model of the simulation is damaged: {error}") from error
                return SimulationModel(data, self.file.facts.simulation)
        raise ValueError("the model of the simulation is not in the recording")

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take the next message."""
        topic = happening.channel.topic
        self.is_in_order = self.is_in_order and time_ns >= self._newest_ns
        self._newest_ns = time_ns
        self._oldest_ns = min(self._oldest_ns, time_ns)
        is_new = topic not in self.topics
        self.topics[topic] = happening.channel.type_name
        if isinstance(happening, SignalLine) and is_new:
            # It precedes the tree, which is sent at the end of the first tick.
            self._first_samples[happening.node] = happening.fields
        elif isinstance(happening, ExecutiveMessage):
            for event in happening.batch.events:
                if isinstance(event, RunStarted) and self.tree is None:
                    self.tree, self.node = event, happening.node
                if isinstance(event, RunStarted | TreeRevised) and happening.node == self.node:
                    self.nodes |= dict.fromkeys(event.nodes)


@dataclass
class RecordedTopic:
    """The newest message of a topic; it is decoded when a signal reads it."""

    came_ns: int | None = None
    newest: RecordedMessage | None = None
    problem: str = ""
    """Why a message could not be read."""

    def reading(self, read: Callable[[Any], Any]) -> Reader:
        """Return what reads the newest message, each only once."""
        value: Any = None
        of: RecordedMessage | None = None

        def newest() -> Any:
            nonlocal value, of
            if self.newest is not None and self.newest is not of:
                of, value = self.newest, None
                try:
                    number = read(of.message)
                except UNREADABLE as error:
                    self.problem = self.problem or str(error) or type(error).__name__
                else:
                    value = None if number != number else number  # noqa: PLR0124 - nan is no value
            return value

        return newest


class RecordedSignals:
    """Reads the messages of a recording, and returns the signals as known at each instant.

    Args:
        survey: The content of the recording.
        namespace: The robot's namespace; None is that of the recording.
    """

    def __init__(self, survey: RecordingSurvey, namespace: str | None = None) -> None:
        self.now_ns = survey.start_ns
        self.topics: dict[str, RecordedTopic] = {}
        """Those that signals are read from, by their names."""
        self._read_from: dict[str, RecordedTopic] = {}
        self.mission = RecordedMission(survey.node, survey.tree, survey.topics, survey.nodes)
        self._survey = survey
        facts = survey.file.facts
        self._namespace = (namespace or facts.namespace).strip("/")
        self._is_simulated = "world" in facts.texts
        self._has_states = bool(facts.simulation) and survey.first_sample is not None
        self._values: dict[str, Plain | None] = {}
        self._sampled = frozenset((survey.first_sample or {}).get("keys", ()))
        self._truth: RecordedTruth | None = None
        self._state = ""
        self._shown: str | None = None

    def wants(self, happening: RecordedMessage) -> bool:
        """Return whether a signal reads a message."""
        return happening.channel.topic in self.topics or self.mission.wants(happening)

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take a message."""
        topic = self.topics.get(happening.channel.topic)
        if topic is not None:
            topic.came_ns, topic.newest = time_ns, happening
        self.mission.take(happening)

    def sample(self, line: Mapping[str, Any]) -> None:
        """Take in the signals of a control step."""
        self.now_ns = int(line["t"])
        self._values |= line.get("values", {})
        self._state = line.get("state", "")

    def problem_of(self, requirement: Requirement) -> str:
        """Return why signals of a requirement cannot be read; empty if they can."""
        for signal in signals_in(root_of(requirement)):
            topic = self._read_from.get(signal.key)
            if topic is not None and topic.problem:
                return f"{signal.key}: a message cannot be read: {topic.problem}"
        return ""

    def forget(self) -> None:
        """Forget the statuses of an instant; called after each instant."""
        self.mission.forget()

    # ---- readers ---------------------------------------------------------------------------

    def reader(self, signal: SignalValue, /) -> Reader | str:
        """Return what gives a signal's present value, or why it is not known here."""
        name, arguments, key = signal.name, signal.arguments, signal.key
        if name == "time":
            return lambda: (self.now_ns - self._survey.start_ns) / NS
        if self._has_states and name in OF_STATE:
            return self._of_state(name)
        is_variable = name == "$" and self._survey.first_sample is not None
        if key in self._sampled or is_variable:
            return lambda: self._values.get(key)
        if name == "age":
            return self._age(arguments[0])
        if name == "topic":
            return self._of_topic(
                key, arguments[0], lambda message: field_of(message, arguments[1])
            )
        if name in _OF_TOPICS:
            return self._of_topic(key, *_OF_TOPICS[name])
        if name in MISSION:
            return self._of_mission(signal)
        return self._of_robot(signal)

    def measured_by(self, signal: SignalValue, /) -> str:
        """Return the measure of a signal that only a simulation knows exactly."""
        return "odometry" if signal.name in BY_ODOMETRY and not self._is_simulated else ""

    def lower_bound(self, _signal: SignalValue, /) -> None:
        """Return no lower bound of a signal: they all cost little."""

    def _of_mission(self, signal: SignalValue) -> Reader | str:
        if signal.name != "accepted":
            return self.mission.reader(signal)
        if ACCEPTED_GOALS not in self._sampled:
            return "the recording does not contain which goals were accepted"
        (node,) = signal.arguments
        return self.mission.accepted(node, lambda: self._values.get(ACCEPTED_GOALS))

    def _of_robot(self, signal: SignalValue) -> Reader | str:
        """Read the true signals of a simulation, as far as topics have them."""
        name = signal.name
        if not self._is_simulated:
            if name not in BY_ODOMETRY:
                return "only a simulation provides it"
            read = PathLength().add if name == "distance" else OF_ODOMETRY[name]
            return self._of_topic(name, ODOMETRY, read)
        if name == "collisions":
            return self.mission.reader(signal)
        if name == "distance":
            return self._of_topic(name, TRUTH, PathLength().add)
        if name in _OF_TRUTH:
            return self._of_topic(name, TRUTH, _OF_TRUTH[name])
        return "the recording does not contain it, as an earlier version of bt-mission made it"

    def _of_state(self, name: str) -> Reader | str:
        """Read what follows from the simulation's state, unless it was sampled."""
        if self._truth is None:
            try:
                self._truth = RecordedTruth(self._survey.model())
            except ValueError as error:
                return str(error)
        truth, of_state = self._truth, OF_STATE[name]

        def value() -> Plain | None:
            sampled = self._values.get(name)
            if sampled is not None:
                return sampled
            if self._shown is not self._state:
                self._shown = self._state
                truth.show(base64.b64decode(self._state))
            return of_state(truth)

        return value

    def _topic(self, name: str) -> RecordedTopic | str:
        """Return a topic by its name, relative to the robot's namespace or absolute."""
        prefix = f"/{self._namespace}/" if self._namespace else "/"
        full = name if name.startswith("/") else prefix + name
        if full not in self._survey.topics:
            return f"the recording has no topic {full}"
        return self.topics.setdefault(full, RecordedTopic())

    def _age(self, name: str) -> Reader | str:
        topic = self._topic(name)
        if isinstance(topic, str):
            return topic
        start_ns = self._survey.start_ns

        def age() -> float:
            came_ns = start_ns if topic.came_ns is None else topic.came_ns
            return (self.now_ns - came_ns) / NS

        return age

    def _of_topic(self, key: str, name: str, read: Callable[[Any], Any]) -> Reader | str:
        topic = self._topic(name)
        if isinstance(topic, str):
            return topic
        self._read_from[key] = topic
        return topic.reading(read)
