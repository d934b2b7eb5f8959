"""What one mission tells of itself on its way into a file: tree, changes, log, trace, signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rclpy.serialization import serialize_message

from bt_mission.core.cdr.decoder import Take
from bt_mission.events.events import Event
from bt_mission.events.log import rosout_line
from bt_mission.recording import signal_samples
from bt_mission.recording.contents import DETAILS_TYPE, DetailsRecorder
from bt_mission.recording.file import McapFile
from bt_mission.sessions.session import Run

STATUS_TYPES = {
    "tree": "bt_mission_interfaces/msg/Tree",
    "requirements": "bt_mission_interfaces/msg/Requirements",
    "state": "bt_mission_interfaces/msg/MissionState",
    "changes": "bt_mission_interfaces/msg/StatusChanges",
}


class Recording(Protocol):
    """The file that a mission is recorded to, as the mission needs it."""

    def open_own(self, topic: str, type_name: str) -> Take:
        """Give what takes messages of a topic that are serialized here."""

    def open_text(self, topic: str) -> Callable[[str], None]:
        """Give what takes texts for a topic."""

    def take_log(self, level: int, name: str, text: str) -> None:
        """Take a line of a mission's log."""

    def poll_feedback(self) -> None:
        """Take what has been heard of goals so far."""

    def guarded(self, call: Callable[..., None]) -> Callable[..., None]:
        """Give ``call`` without its exceptions."""


class MissionRecorder:
    """Records what an executive tells of its mission.

    Args:
        run: The mission, with its executive.
        recording: Takes it.
        is_alone: Is it the only one in the recording? The log names the robot otherwise.
    """

    def __init__(self, run: Run, recording: Recording, *, is_alone: bool) -> None:
        self.name = run.node.get_fully_qualified_name()
        """Full name of the executive's node: below it lie the mission's topics."""
        self._runner = run.runner
        self._logger = run.node.get_name() if is_alone else self.name.strip("/").replace("/", ".")
        self._recording = recording
        self._status = {
            what: recording.open_own(f"{self.name}/{what}", type_name)
            for what, type_name in STATUS_TYPES.items()
        }
        self._details = DetailsRecorder(
            run.runner, recording.open_own(f"{self.name}/details", DETAILS_TYPE)
        )
        self._trace = recording.open_text(f"{self.name}/trace")
        self._signals = recording.open_text(f"{self.name}/{signal_samples.TOPIC}")
        self._on_status = recording.guarded(self._take_status)
        self._on_line = recording.guarded(self._trace)
        self._on_event = recording.guarded(self._take_event)
        self._samples = signal_samples.SignalSamples(run.runner, self._sample, recording.guarded)

    @property
    def facts(self) -> Mapping[str, str]:
        """What is to be told at the start."""
        return self._samples.facts

    def attach_simulation(self, file: McapFile, time_ns: int) -> None:
        """Put the model of the simulation, if there is one, into a file."""
        self._samples.attach_to(file, time_ns)

    def begin(self) -> None:
        """Take what has been told so far, and what is told from now on."""
        self._runner.status_publisher.add(self._on_status)
        trace = self._runner.trace
        for line in trace.newest:
            self._on_line(line)
        trace.lines.subscribe(self._on_line)
        self._runner.executive.events.subscribe(self._on_event)

    def look(self, now_ns: int, *, is_due: bool = False) -> None:
        """Tell how running nodes get on, if it is time."""
        self._details.is_due |= is_due
        self._details.look(now_ns)

    def tell_changes(self) -> None:
        """Have the mission tell what it has not told yet."""
        self._runner.status_publisher.publish_if_changed()

    def close(self) -> None:
        """Record no more."""
        self.tell_changes()
        self._runner.status_publisher.remove(self._on_status)
        self._runner.trace.lines.unsubscribe(self._on_line)
        self._runner.executive.events.unsubscribe(self._on_event)
        self._samples.close()

    def _take_status(self, what: str, message: Any) -> None:
        self._details.is_due = True
        self._status[what](serialize_message(message))

    def _take_event(self, event: Event) -> None:
        line = rosout_line(event, self._runner.executive.node_infos)
        if line is not None:
            self._recording.take_log(line[0], self._logger, line[1])

    def _sample(self, line: str) -> None:
        """Take the signals of a control step, behind what was heard before it."""
        self._recording.poll_feedback()
        self._signals(line)
