"""The content of a recording for viewers: what they would have received during the run.

Everything is read and converted to plain data at once, apart from scans and maps, of which only the
newest of an instant is needed.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from py_trees.common import Status

from bt_mission.base.geometry import yaw_of
from bt_mission.executive.events import events, messages
from bt_mission.executive.events.codec import is_of_log
from bt_mission.executive.events.log import words_of
from bt_mission.recording.facts import LARGEST_NS, robot_of
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.recorded_messages import (
    TREE,
    VIEWED,
    ExecutiveMessage,
    OtherRobotMessage,
    RecordedMessage,
    RobotMessage,
    TraceLine,
    fold,
)

LATER = ("scan", "map", "zones")
"""Topics whose messages are decoded when they are looked at."""

OTHERS_NS = 200_000_000
"""ROS time between two places of another robot that are kept."""

Frame = events.Event | messages.Robot | RobotMessage
"""An item of the recording at some instant."""


@dataclass(frozen=True)
class Timeline:
    """The items of a recording, in the order of time.

    Args:
        start_ns: ROS time at which the first mission in it began, ns; end_ns: of its end.
        frames: The items, at ``times_ns``.
        trace: The lines of the run's trace; none where another recorder has made the file.
        why_cut: Why the file ends before its end; empty where it does not.
        missing: What of it could not be recorded, or not be read; empty where all could.
    """

    path: Path
    start_ns: int
    end_ns: int
    times_ns: tuple[int, ...] = field(repr=False)
    frames: tuple[Frame, ...] = field(repr=False)
    trace: tuple[str, ...] = field(repr=False)
    why_cut: str
    changes_ns: tuple[int, ...] = field(repr=False)
    """When the tree changes."""
    starts_ns: Mapping[tuple[str, int, int], tuple[int, ...]] = field(repr=False)
    """When the node of a run, by a revision and its index there, has begun to run."""
    missing: str = ""
    robots: tuple[str, ...] = ()
    """The names of the robots whose missions are in the file."""
    notes: Mapping[str, Mapping[str, str]] = field(default_factory=dict, repr=False)
    """The facts that the recorder has written besides messages."""


def beside(times: Sequence[int], time_ns: int, steps: int) -> int | None:
    """Return which of these times is next after an instant, or (-1) last before it."""
    at = bisect_right(times, time_ns) if steps > 0 else bisect_left(times, time_ns) - 1
    return times[at] if 0 <= at < len(times) else None


def read_timeline(path: Path, robot: str | None = None) -> Timeline:
    """Read a recording; a cut one yields its content.

    Args:
        robot: The robot of several with missions; None is the first.

    Raises:
        RecordingError: The file is invalid, or has no tree of a mission.
    """
    file = RecordedFile(path, robot)
    timeline = TimelineReader(file)
    fold(file, timeline.take)
    return timeline.timeline()


class TimelineReader:
    """Reads messages one by one: a fold of a recording."""

    def __init__(self, file: RecordedFile) -> None:
        self._file = file
        self._kept: list[tuple[int, Frame]] = []
        self._robots: dict[str, list[tuple[int, Frame]]] = {}
        """By namespace: which robot is the mission's is known once there is a tree."""
        self._charges: dict[str, messages.BatteryState] = {}
        """The newest of each robot: it is published often, and changes seldom."""
        self._others_ns: dict[str, int] = {}
        """When the pose of each other robot was last kept."""
        self._trace: list[str] = []
        self._node = ""
        """Of the executive that is shown."""
        self._trees: list[events.RunStarted] = []
        self._batches: list[tuple[int, str, events.Event]] = []
        """Times, runs and events."""
        self._logged: list[tuple[int, Frame]] = []

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take a message, if a viewer shows it."""
        match happening:
            case ExecutiveMessage():
                self._take_batch(happening.batch, happening.node, time_ns)
            case TraceLine():
                self._take_line(happening)
            case OtherRobotMessage():
                self._take_other(happening, time_ns)
            case RobotMessage() if happening.topic in VIEWED:
                self._take_robot(happening, time_ns)

    def _take_robot(self, happening: RobotMessage, time_ns: int) -> None:
        frames = self._robots.setdefault(happening.namespace, [])
        if happening.topic in LATER:
            happening.check_type()
            frames.append((time_ns, happening))
            return
        seen = happening.viewed()
        if isinstance(seen, messages.BatteryState):
            if seen == self._charges.get(happening.namespace):
                return
            self._charges[happening.namespace] = seen
        frames.append((time_ns, seen))

    def _take_other(self, happening: OtherRobotMessage, time_ns: int) -> None:
        """Take the pose of another robot, several times a second."""
        robot = happening.namespace.strip("/")
        if time_ns - self._others_ns.get(robot, -OTHERS_NS) >= OTHERS_NS:
            happening.check_type()
            pose = happening.message.pose.pose
            self._others_ns[robot] = time_ns
            x, y = float(pose.position.x), float(pose.position.y)
            other = messages.OtherRobot(robot, x, y, yaw_of(pose.orientation))
            self._kept.append((time_ns, other))

    def _take_batch(self, batch: messages.Batch, node: str, time_ns: int) -> None:
        for event in batch.events:
            if isinstance(event, events.RunStarted):
                self._node = node
                self._trees.append(event)
            at_ns = time_ns if event.time_ns is None else min(event.time_ns, time_ns)
            self._batches.append((at_ns, batch.run, event))

    def _take_line(self, line: TraceLine) -> None:
        self._trace.append(line.text)
        if line.name == "requirement" or is_of_log(line.name):
            fields = line.fields
            event = line.event({})
            if event is None or abs(time_ns := int(fields["t"])) > LARGEST_NS:
                return
            if line.name == "requirement":
                event = events.LogLine(time_ns, words_of(fields))
            self._logged.append((time_ns, event))

    # ---- the end ---------------------------------------------------------------------------

    def timeline(self) -> Timeline:
        """All of it.

        Raises:
            RecordingError: Where there is no tree of a mission in it.
        """
        if not self._trees:
            raise RecordingError(f"{self._file.path}: {self._why_no_timeline()}")
        start_ns = self._begin_at_start()
        runs = {tree.run for tree in self._trees}
        happened = [
            (at_ns, run, event)
            for at_ns, run, event in self._batches
            if run in runs or isinstance(event, events.StateChanged)
        ]
        kept = [*self._kept, *((at_ns, event) for at_ns, _, event in happened), *self._logged]
        kept += self._robots.get(self._node.rpartition("/")[0], [])
        kept.sort(key=lambda timed: (timed[0], _rank(timed[1])))
        return Timeline(
            path=self._file.path,
            start_ns=start_ns,
            end_ns=max(self._file.last_ns, start_ns),
            times_ns=tuple(time_ns for time_ns, _ in kept),
            frames=tuple(frame for _, frame in kept),
            trace=tuple(self._trace),
            why_cut=self._file.why_cut,
            missing=self._file.missing,
            robots=tuple(robot_of(node) for node in self._file.facts.missions),
            notes=self._file.notes,
            changes_ns=tuple(
                sorted({at_ns for at_ns, frame in kept if isinstance(frame, CHANGES)})
            ),
            starts_ns=_starts(happened),
        )

    def _begin_at_start(self) -> int:
        """Give the first tree the time from which `run` counts, ns, which may be earlier."""
        first = self._trees[0]
        begin = replace(first, time_ns=self._file.started_ns(first.time_ns))
        self._trees[0] = begin
        at = next(index for index, batch in enumerate(self._batches) if batch[2] is first)
        self._batches[at] = (begin.time_ns, begin.run, begin)
        return begin.time_ns

    def _why_no_timeline(self) -> str:
        if TREE in self._file.unread:
            return (
                "its tree cannot be read; another version of bt-mission made it "
                f"({self._file.unread[TREE]})"
            )
        if "bt_mission" in self._file.notes:
            why = self._file.why_cut or "nothing was ticked"
            return f"it ends before the mission began: {why}"
        if not self._file.topics:
            return f"contains no messages: {self._file.why_cut or 'nothing was recorded'}"
        return (
            f"contains no tree of a mission (topics here: {self._file.topics}). "
            "Record with `bt-mission run --record`; with ros2 bag record, include "
            "/bt_mission/tree, changes, state, details and log from the start of the mission"
        )


CHANGES = (events.NodeChanged, events.NodesReset)


def _rank(frame: Frame) -> int:
    """The order within an instant: a mission starts, things happen, a mission ends."""
    if isinstance(frame, events.RunStarted):
        return 0
    return 2 if isinstance(frame, events.StateChanged) and frame.status in events.FINAL else 1


def _starts(
    happened: Iterable[tuple[int, str, events.Event]],
) -> dict[tuple[str, int, int], tuple[int, ...]]:
    starts: defaultdict[tuple[str, int, int], list[int]] = defaultdict(list)
    revisions: defaultdict[str, int] = defaultdict(int)
    for at_ns, run, event in happened:
        revision = revisions[run]
        if isinstance(event, events.TreeRevised):
            revisions[run] = event.number
            for new, old in enumerate(event.kept):
                if old >= 0:  # one list for the node in all versions of the tree
                    starts[run, event.number, new] = starts[run, revision, old]
        elif isinstance(event, events.NodeChanged) and event.status is Status.RUNNING:
            starts[run, revision, event.node].append(at_ns)
    return {key: tuple(times) for key, times in starts.items() if times}
