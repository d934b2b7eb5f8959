"""Reads a recording back into what is known of its run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from py_trees.common import Status

from bt_mission.executive.events.events import (
    GoalChanged,
    NodeChanged,
    RunStarted,
    StateChanged,
    TreeRevised,
)
from bt_mission.recording.facts import RunFacts
from bt_mission.recording.goal_lives import GoalLives
from bt_mission.recording.model import Picture, RecordedLine, RecordedRun, Span
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.recorded_messages import (
    ExecutiveMessage,
    GoalMessage,
    PictureMessage,
    RecordedMessage,
    RobotMessage,
    RosoutMessage,
    TraceLine,
    fold,
)
from bt_mission.recording.robot_life import RobotLife

WORDS = {
    Status.INVALID: "halted",
    Status.RUNNING: "running",
    Status.SUCCESS: "success",
    Status.FAILURE: "failure",
}


def read_run(path: str | Path, robot: str | None = None) -> RecordedRun:
    """Read a recording; a cut one yields its content.

    Args:
        robot: The robot of several with missions; None is the first.

    Raises:
        RecordingError: The file is invalid, or has no run of a mission.
    """
    file = RecordedFile(Path(path), robot)
    run = RunReader(file)
    fold(file, run.take)
    return run.run()


def spans_of(
    nodes: int, changes: Iterable[tuple[int, NodeChanged]], end_ns: int
) -> tuple[tuple[Span, ...], ...]:
    """Return the spans of each node, in order, from the changes of its status.

    Args:
        nodes: The number of nodes.
        changes: Changes with their times, ns.
        end_ns: The end of nodes that are still running at the end.
    """
    spans: list[list[Span]] = [[] for _ in range(nodes)]
    running: dict[int, tuple[int, str]] = {}
    for time_ns, change in changes:
        begun = running.pop(change.node, (time_ns, change.message))
        if change.status is Status.RUNNING:
            running[change.node] = begun
        else:
            word = WORDS[change.status]
            spans[change.node].append(Span(begun[0], time_ns, word, change.message))
    for node, (start_ns, message) in running.items():
        spans[node].append(Span(start_ns, max(end_ns, start_ns), WORDS[Status.RUNNING], message))
    return tuple(map(tuple, spans))


class RunReader:
    """Reads messages one by one: a fold of a recording."""

    def __init__(self, file: RecordedFile) -> None:
        self._file = file
        self._tree: RunStarted | None = None
        self._node = ""
        self._changes: list[tuple[int, NodeChanged]] = []
        self._state = StateChanged(0, "", "", "", "")
        self._log: list[RecordedLine] = []
        self._pictures: list[Picture] = []
        self._goals = GoalLives()
        self._robot: RobotLife | None = None

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take a message, if a report shows it."""
        match happening:
            case ExecutiveMessage():
                self._take_batch(happening, time_ns)
            case RosoutMessage():
                line = happening.message
                self._log.append(RecordedLine(time_ns, line.level, line.name, line.msg))
            case PictureMessage():
                image, topic = happening.message, happening.channel.topic
                kind = "image/png" if "png" in image.format else "image/jpeg"
                self._pictures.append(Picture(time_ns, topic, kind, image.data.tobytes()))
            case TraceLine():
                if happening.name.startswith("goal "):
                    change = happening.event({})
                    assert isinstance(change, GoalChanged), "its name says so"
                    self._goals.take_change(time_ns, change)
            case GoalMessage():
                self._goals.take(time_ns, happening)
            case RobotMessage():
                if self._robot is None:
                    facts = RunFacts(self._file.notes, self._file.node)
                    self._robot = RobotLife(facts.namespace, facts.hull)
                if happening.namespace == self._robot.namespace:
                    self._robot.take(time_ns, happening)

    def _take_batch(self, happening: ExecutiveMessage, time_ns: int) -> None:
        count = len(self._tree.nodes) if self._tree else 0
        for event in happening.batch.events:
            match event:
                case RunStarted():
                    self._tree, self._node = event, happening.node
                case TreeRevised():
                    self._revise(event)
                    count = len(event.nodes)
                case NodeChanged(node=node) if node < count:
                    self._changes.append((time_ns, event))
                case StateChanged():
                    self._state = event

    def _revise(self, event: TreeRevised) -> None:
        """Show the tree of a revision, with the changes so far of the nodes that it has."""
        self._tree = event.as_start()
        now = {index: new for new, index in enumerate(event.kept)}
        self._changes = [
            (time_ns, replace(change, node=now[change.node]))
            for time_ns, change in self._changes
            if change.node in now
        ]

    # ---- the end ---------------------------------------------------------------------------

    def run(self) -> RecordedRun:
        """All of it.

        Raises:
            RecordingError: Where there is no mission in it.
        """
        file = self._file
        facts = file.facts
        if self._tree is None or not self._tree.nodes:
            raise RecordingError(f"{file.path}: {self._why_no_run(facts.texts)}")
        start_ns = file.started_ns(self._tree.time_ns)
        robot = self._robot or RobotLife(facts.namespace, None)
        texts = {
            attached.name: attached.data.decode(errors="replace")
            for attached in file.attached
            if attached.media_type == "text/plain"
        }
        saved = [
            Picture(attached.time_ns, attached.name, attached.media_type, attached.data)
            for attached in file.attached
            if attached.media_type.startswith("image/")
            and not file.is_of_another(f"/{attached.name}")
        ]
        return RecordedRun(
            path=file.path,
            mission=self._tree.mission,
            node=self._node,
            facts=facts.texts,
            summary=facts.summary,
            start_ns=start_ns,
            end_ns=file.last_ns,
            status=self._state.status,
            reason=self._state.reason,
            why_cut=file.why_cut,
            missing=file.missing,
            tree=self._tree.nodes,
            spans=spans_of(len(self._tree.nodes), self._changes, file.last_ns),
            truth=robot.truth,
            measured=robot.measured,
            scans=robot.scans,
            grid=robot.grid,
            goals=self._goals.lives,
            log=tuple(self._log),
            battery=robot.battery,
            collisions=tuple(robot.collisions),
            pictures=tuple(sorted([*saved, *self._pictures], key=lambda picture: picture.time_ns)),
            files=texts,
            versions=facts.versions,
            inputs=facts.inputs,
            hull=robot.hull,
        )

    def _why_no_run(self, facts: Mapping[str, str]) -> str:
        if facts:
            return f"it ends before the mission began: {self._file.why_cut or 'nothing was ticked'}"
        return (
            "contains no run of a mission; record one with `bt-mission run --record` (topics "
            f"here: {self._file.topics or 'none'})"
        )
