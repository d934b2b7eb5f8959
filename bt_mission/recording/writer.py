"""The recorder of one run: topics, goals, and the events of its missions."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Self

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from bt_mission.base.dds.liveliness import RECORDER
from bt_mission.base.dds.liveliness import TOPIC as PRESENCE
from bt_mission.base.errors import described
from bt_mission.base.files import SUFFIXES
from bt_mission.base.output import DELETED
from bt_mission.base.stamps import set_ns
from bt_mission.base.versions import versions
from bt_mission.cdr.decoder import Decoder, Take, decoder_of
from bt_mission.cdr.definitions import NoDefinitionError, definition_of, with_plain_names
from bt_mission.executive.events.events import Event, TreeRevised
from bt_mission.executive.events.log import rosout_line
from bt_mission.recording import signal_samples
from bt_mission.recording.contents import (
    PictureFolder,
    RecordingOptions,
    compressed,
    facts_of,
    files_of,
    string_message,
)
from bt_mission.recording.facts import FACTS, MISSIONS, SUMMARY, note_of
from bt_mission.recording.file import MOST_WAITING, McapFile
from bt_mission.recording.goals import GoalEvents
from bt_mission.recording.topics import GraphTopics
from bt_mission.ros.mission_details import MissionDetailsBuilder
from bt_mission.sessions.session import MissionRun, Onlooker, Session

LOOK_NS = 2_000_000_000
"""Time between two looks at what topics and pictures there are."""

IMAGE = "sensor_msgs/msg/Image"
CAMERA_TYPES = (IMAGE, "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo")
MOST_LEAD_NS = 1_000_000_000
"""A header may be this far ahead of the clock of a recording, ns; one further ahead is wrong."""

DETAILS_EVERY_NS = 500_000_000
"""ROS time between two messages of details while nothing happens but the progress of nodes."""

DETAILS_TYPE = "bt_mission_interfaces/msg/MissionDetails"
STATUS_TYPES = {
    "tree": "bt_mission_interfaces/msg/Tree",
    "requirements": "bt_mission_interfaces/msg/Requirements",
    "state": "bt_mission_interfaces/msg/MissionState",
    "changes": "bt_mission_interfaces/msg/StatusChanges",
}

NEVER = ("/clock", "/parameter_events")
"""Topics without content of interest: every message has its ROS time; parameters do not change."""


class RunRecorder(Onlooker):
    """Records a session from now on, until it is closed.

    Use it as a context manager around the steps of the session, before the first one.

    Args:
        session: The session to record.
        path: The file to write. It replaces an existing one when it is closed complete.
        options: What to record besides what is always recorded.
        file: Write into this one instead.

    Raises:
        BtMissionError: The file cannot be opened.
    """

    def __init__(
        self,
        session: Session,
        path: Path,
        options: RecordingOptions | None = None,
        *,
        file: McapFile | None = None,
    ) -> None:
        self.file = file or McapFile(path, f"bt-mission {versions()['bt-mission']}")
        self._session = session
        self._options = options or RecordingOptions()
        self._looked_ns = session.now_ns
        self._pending: list[tuple[int, bytes]] = []
        self._has_head = False
        self._noted_faults: list[str] = []
        self._start_ns = session.now_ns
        clock = session.node.get_parameter("use_sim_time")
        self._follows_clock = bool(clock.value) and not session.inside()
        self._stamped: dict[int, Decoder] = {}
        """Of the channels whose messages have a header, where the session follows ``/clock``."""
        self._takes: dict[str, Take] = {}
        self._log = self._open_channel("/rosout", "rcl_interfaces/msg/Log")
        self._pictures = PictureFolder(session.image_folder)
        self.node = Node(
            RECORDER,
            context=session.node.context,
            namespace=session.node.get_namespace(),
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )
        presence = {run.node.resolve_topic_name(PRESENCE) for run in session.runs}
        # The events of executives are recorded at their source, at another pace than for viewers.
        self._own = tuple(f"{run.node.get_fully_qualified_name()}/" for run in session.runs)
        self._topics = GraphTopics(self.node, self, (*NEVER, *presence), session.inside)
        self._is_closed = False
        self._goals = GoalEvents(self.open_own, self._stamp)
        self._look = self.guarded(self._take_in)
        self._on_exchange = self.guarded(self._goals.take)
        self._begin()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(replaces=kind is None)

    @property
    def missing(self) -> str:
        """The missing part of the file, as text; empty if it is complete."""
        if self.file.output.is_deleted:
            return DELETED
        lacks = []
        if self.file.write_error is not None:
            at_s = ((self.file.kept_ns or 0) - self._start_ns) / 1e9
            lacks.append(f"everything after {max(0.0, at_s):.1f} s ({self.file.write_error})")
        lacks += [f"{topic} ({why})" for topic, why in sorted(self._topics.faults.items())]
        return "; ".join(lacks)

    def after_step(self) -> None:
        """Take what has arrived since the last step."""
        self._look()

    def _take_in(self) -> None:
        if self.file.write_error is not None:
            self._topics.close()
            return
        now_ns = self._session.now_ns
        is_due = not 0 <= now_ns - self._looked_ns < LOOK_NS
        busy = self._goals.take_busy()
        self._topics.poll(None if is_due else busy)
        for mission in self._missions:
            mission.look(now_ns)
        self._hand_over()
        if self._has_head and self._faults != self._noted_faults:
            self._note_facts()
        if is_due:
            self._looked_ns = now_ns
            self._look_around()

    def _take_last(self) -> None:
        self._look_around()
        self._topics.poll()
        for mission in self._missions:
            mission.look(self._session.now_ns, is_due=True)
        self._hand_over()

    def _hand_over(self) -> None:
        """Write what has arrived since the last call; all of it belongs to one instant.

        While the simulation sends, the clock is still at the instant before. A session that follows
        ``/clock`` may receive a message before the instant of its header: the message waits for
        that. Until the first ``/clock`` no instant is known, and everything waits.
        """
        now_ns = self._session.now_ns
        if not self._has_head:
            if self._follows_clock and now_ns == 0 and len(self._pending) < MOST_WAITING:
                return
            self._write_head(now_ns)
        if not self._stamped:
            self.file.write(now_ns, self._pending)
            self._pending.clear()
            return
        due: list[tuple[int, bytes]] = []
        early: list[tuple[int, bytes]] = []
        for message in self._pending:
            is_early = 0 < self._lead_ns(message, now_ns) <= MOST_LEAD_NS
            (early if is_early else due).append(message)
        self.file.write(now_ns, due)
        self._pending[:] = early

    def _hand_over_last(self) -> None:
        """Give the file also what waits for an instant that the clock did not reach."""
        if not self._has_head:
            self._write_head(self._session.now_ns)
        self._hand_over()
        for message in sorted(self._pending, key=lambda pending: self._lead_ns(pending, 0)):
            self.file.write(self._lead_ns(message, 0), [message])

    def _lead_ns(self, message: tuple[int, bytes], now_ns: int) -> int:
        """Return by how much a message's header is ahead of the clock, ns; 0 without a header."""
        decoder = self._stamped.get(message[0])
        return 0 if decoder is None else decoder.stamp_ns(message[1]) - now_ns

    def finish(self, summary: Mapping[str, Any], robots: Sequence[Mapping[str, Any]] = ()) -> None:
        """Write the result of the run to the file, and close it.

        Args:
            summary: The summary of the run.
            robots: The summary of each of several robots, in the order of the session's runs.
        """
        for mission in self._missions:
            mission.note_changes()
        self.guarded(self._take_last)()
        self._note_summary(SUMMARY, summary)
        for mission, of_robot in zip(self._missions, robots, strict=False):
            self._note_summary(note_of(SUMMARY, mission.name), of_robot)
        self.close()

    def _note_summary(self, name: str, summary: Mapping[str, Any]) -> None:
        facts = {name: json.dumps(value) for name, value in summary.items()}
        self.file.note(name, {**facts, "missing": json.dumps(self.missing)})

    def close(self, *, replaces: bool = True) -> None:
        """Stop recording; further calls do nothing.

        Args:
            replaces: Whether a complete recording replaces an existing file.
        """
        if self._is_closed:
            return
        self._is_closed = True
        for mission in self._missions:
            mission.close()
        for run in self._session.runs:
            run.runner.exchanges.unsubscribe(self._on_exchange)
        self._topics.close()
        self._session.detach(self)
        self.guarded(self._hand_over_last)()
        self.file.close(replaces=replaces)

    def guarded(self, call: Callable[..., None]) -> Callable[..., None]:
        """``call``, the failure of which ends the recording, and nothing else."""
        file = self.file

        def guarded(*arguments: Any) -> None:
            try:
                call(*arguments)
            except Exception as error:  # noqa: BLE001 - looking on must not change what happens
                file.abandon(f"the recorder failed: {described(error)}")

        return guarded

    # ---- beginning -------------------------------------------------------------------------

    def _begin(self) -> None:
        session = self._session
        is_alone = len(session.runs) == 1
        self._missions = [MissionRecorder(run, self, is_alone=is_alone) for run in session.runs]
        for run in session.runs:
            run.runner.show_waypoints()
        self._topics.look_around()
        for run, mission in zip(session.runs, self._missions, strict=True):
            mission.begin()
            run.runner.exchanges.subscribe(self._on_exchange)
        session.attach(self)
        self.guarded(self._hand_over)()
        self.file.flush()

    def _write_head(self, now_ns: int) -> None:
        """Write the facts of the run, at the first known instant."""
        self._has_head, self._start_ns, session = True, now_ns, self._session
        self._note_facts()
        files = {
            (name, text.encode()): "text/plain"
            for run in session.runs
            for name, text in files_of(run.mission)
        }
        for name, data in session.files.items():
            is_yaml = Path(name).suffix in SUFFIXES
            files[name, data] = "application/yaml" if is_yaml else "application/octet-stream"
        for (name, data), kind in files.items():
            self.file.attach(name, kind, data, self._start_ns)
        self._missions[0].attach_simulation(self.file, self._start_ns)

    @property
    def _faults(self) -> list[str]:
        """The faults of each run, as its facts have them."""
        return [run.facts.get("faults", "") for run in self._session.runs]

    def _note_facts(self) -> None:
        """Write the facts of the runs; of several notes with one name the last one counts."""
        self._noted_faults, session = self._faults, self._session
        is_fleet = len(session.runs) > 1
        facts = [
            {**facts_of(run, self._start_ns), **session.facts, **run.facts, **mission.facts}
            for run, mission in zip(session.runs, self._missions, strict=True)
        ]
        names = (
            {MISSIONS: json.dumps([mission.name for mission in self._missions])} if is_fleet else {}
        )
        self.file.note(FACTS, {**facts[0], **names})
        for mission, of_mission in zip(self._missions, facts if is_fleet else (), strict=False):
            self.file.note(note_of(FACTS, mission.name), of_mission)

    def _look_around(self) -> None:
        self._topics.look_around()
        for name, data in self._pictures.take_new():
            self.file.attach(name, "image/png", data, self._session.now_ns)

    # ---- channels --------------------------------------------------------------------------

    def trimming(self, type_name: str, *, has_fixed_shape: bool) -> Callable[[Take], Take] | None:
        """Return a function that removes rclpy's additions from messages; None if too slow."""
        decoder = decoder_of(type_name)
        if has_fixed_shape or decoder.has_known_length:
            return partial(decoder.trimming, has_fixed_shape=has_fixed_shape)
        return None

    def open_topic(self, topic: str, type_name: str, offered_qos: str) -> Take | None:
        """Return the receiver of the messages of a topic, if any."""
        if topic.startswith(self._own):
            return None
        camera = self._options.camera
        if type_name not in CAMERA_TYPES:
            return self._open_channel(topic, type_name, offered_qos)
        if camera == "none":
            return None
        if camera == "compressed" and type_name == IMAGE:
            take = self._open_channel(
                f"{topic}/compressed", "sensor_msgs/msg/CompressedImage", offered_qos
            )
            return self.guarded(lambda data: take(compressed(data)))
        return self._open_channel(topic, type_name, offered_qos)

    def open_text(self, topic: str) -> Callable[[str], None]:
        """Give what takes texts for a topic."""
        take = self._open_channel(topic, "std_msgs/msg/String")
        return lambda text: take(string_message(text))

    def _open_channel(self, topic: str, type_name: str, offered_qos: str = "") -> Take:
        """Return the receiver of the messages of a topic; the first message makes its channel."""
        if topic in self._takes:
            return self._takes[topic]
        keep = self._pending.append
        channel: int | None = None

        def take(data: bytes) -> None:
            nonlocal channel
            if channel is None:
                channel = self._channel(topic, type_name, offered_qos)
            if channel:
                keep((channel, data))

        self._takes[topic] = take
        return take

    def _channel(self, topic: str, type_name: str, offered_qos: str) -> int:
        """Make a channel. Return its number, 0 if the definition of its type is not installed."""
        try:
            definition = definition_of(type_name)
        except NoDefinitionError as error:
            self._topics.faults[topic] = str(error)
            return 0
        if not self._options.raw_actions:
            type_name, definition = with_plain_names(type_name, definition)
        metadata = {"offered_qos_profiles": offered_qos}
        channel = self.file.channel(topic, type_name, definition, metadata)
        if self._follows_clock and (decoder := Decoder(type_name, definition)).has_header:
            self._stamped[channel] = decoder
        return channel

    def open_own(self, topic: str, type_name: str) -> Take:
        """The same for messages that are serialized here."""
        take = self._open_channel(topic, type_name)
        return decoder_of(type_name).trimming(take, has_fixed_shape=False)

    # ---- besides topics --------------------------------------------------------------------

    def take_log(self, level: int, name: str, text: str) -> None:
        """Take a line of a mission's log."""
        entry = Log(stamp=self._stamp(), level=level, name=name)
        entry.msg = text
        self._log(serialize_message(entry))

    def poll_feedback(self) -> None:
        """Write the received feedback of goals."""
        self._topics.poll_feedback(self._goals.busy)

    def _stamp(self) -> Time:
        return set_ns(Time(), self._session.now_ns)


def record(
    session: Session, path: str | Path, options: RecordingOptions | None = None
) -> RunRecorder:
    """Record a session from its present step on; a context manager that closes the file.

    Args:
        session: A :class:`bt_mission.Stage`, or another session.
        path: The MCAP file to write. It replaces an existing one when it is closed complete.
        options: What to record besides what is always recorded.

    Raises:
        BtMissionError: The file cannot be opened.
    """
    return RunRecorder(session, Path(path), options)


class MissionRecorder:
    """Records the events of an executive.

    Args:
        run: The mission, with its executive.
        recording: The recording.
        is_alone: Whether it is the only mission in the recording. Otherwise the log names the
            robot.
    """

    def __init__(self, run: MissionRun, recording: RunRecorder, *, is_alone: bool) -> None:
        self.name = run.node.get_fully_qualified_name()
        """Full name of the executive's node: below it lie the mission's topics."""
        self._runner = run.runner
        self._is_alone = is_alone
        self._logger = run.node.get_name() if is_alone else self.name.strip("/").replace("/", ".")
        self._recording = recording
        self._status = {
            what: recording.open_own(f"{self.name}/{what}", type_name)
            for what, type_name in STATUS_TYPES.items()
        }
        self._details = MissionDetailsBuilder(run.runner)
        self._take_details = recording.open_own(f"{self.name}/details", DETAILS_TYPE)
        self._is_due = False
        """Whether something has happened since the last details."""
        self._described_ns: int | None = None
        """None before the first: details are useless before there is a tree."""
        self._trace = recording.open_text(f"{self.name}/trace")
        self._signals = recording.open_text(f"{self.name}/{signal_samples.TOPIC}")
        self._on_status = recording.guarded(self._take_status)
        self._on_line = recording.guarded(self._trace)
        self._on_event = recording.guarded(self._take_event)
        self._samples = signal_samples.SignalSamples(run.runner, self._sample, recording.guarded)

    @property
    def facts(self) -> Mapping[str, str]:
        """The facts at the start."""
        return self._samples.facts

    def attach_simulation(self, file: McapFile, time_ns: int) -> None:
        """Add the model of the simulation, if any, to a file."""
        self._samples.attach_to(file, time_ns)

    def begin(self) -> None:
        """Record the events so far, and all from now on."""
        self._runner.status_publisher.add(self._on_status)
        trace = self._runner.trace
        for line in trace.newest:
            self._on_line(line)
        trace.lines.subscribe(self._on_line)
        self._runner.executive.events.subscribe(self._on_event)

    def look(self, now_ns: int, *, is_due: bool = False) -> None:
        """Record the progress of running nodes, if something has happened, and twice a second.

        The details of viewers are sent at the pace of the wall clock, these at that of the mission.
        """
        last_ns = self._described_ns
        is_late = last_ns is not None and not 0 <= now_ns - last_ns < DETAILS_EVERY_NS
        if is_due or self._is_due or is_late:
            self._is_due, self._described_ns = False, now_ns
            self._take_details(serialize_message(self._details.describe_changes()))

    def note_changes(self) -> None:
        """Have the mission emit its pending changes."""
        self._runner.status_publisher.publish_if_changed()

    def close(self) -> None:
        """Record no more."""
        self.note_changes()
        self._runner.status_publisher.remove(self._on_status)
        self._runner.trace.lines.unsubscribe(self._on_line)
        self._runner.executive.events.unsubscribe(self._on_event)
        self._samples.close()

    def _take_status(self, what: str, message: Any) -> None:
        self._is_due = True
        self._status[what](serialize_message(message))

    def _take_event(self, event: Event) -> None:
        if isinstance(event, TreeRevised):
            self._attach_version(event)
        line = rosout_line(event, self._runner.executive.node_infos)
        if line is not None:
            self._recording.take_log(line[0], self._logger, line[1])

    def _attach_version(self, event: TreeRevised) -> None:
        """Write the files of a revision of the mission."""
        folder = f"revision_{event.number}"
        if not self._is_alone:
            folder = f"{self._logger}/{folder}"
        for name, text in files_of(self._runner.mission):
            self._recording.file.attach(
                f"{folder}/{name}", "text/plain", text.encode(), event.time_ns
            )

    def _sample(self, line: str) -> None:
        """Write the signals of a control step, after what was received before it."""
        self._recording.poll_feedback()
        self._signals(line)
