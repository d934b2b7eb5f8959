"""Reads a recording back into what is known of its run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from py_trees.common import Status

from bt_mission.cdr.decoder import DecodedMessage, DecodingError
from bt_mission.cdr.definitions import action_of
from bt_mission.executive.events.events import (
    GoalChanged,
    NodeChanged,
    RunStarted,
    StateChanged,
    TreeRevised,
)
from bt_mission.recording.facts import RunFacts
from bt_mission.recording.happenings import (
    ExecutiveMessage,
    GoalMessage,
    PictureMessage,
    RecordedMessage,
    RobotMessage,
    RosoutMessage,
    TraceLine,
    fold,
)
from bt_mission.recording.model import Picture, RecordedGoal, RecordedLine, RecordedRun, Span
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.robot_life import RobotLife

STATUSES = {0: "unknown", 4: "succeeded", 5: "canceled", 6: "aborted"}
"""By the numbers of ``action_msgs/msg/GoalStatus``; others are not final."""

GOAL_ID_BYTES = 16


class GoalLives:
    """Takes in what concerns goals, in the order of time."""

    def __init__(self) -> None:
        self._goals: dict[str, RecordedGoal] = {}

    @property
    def lives(self) -> tuple[RecordedGoal, ...]:
        """All goals, in the order of their first message."""
        return tuple(self._goals.values())

    def take(self, time_ns: int, happening: GoalMessage) -> None:
        """Take a message between an action's client and its server."""
        action = happening.action
        match happening.part:
            case "feedback":
                message = happening.message
                goal = self._goal(message.goal_id, action)
                goal.feedback.append((time_ns, _fields(message.feedback)))
            case "send_goal/_service_event":
                type_name = happening.channel.type_name
                self._take_send(action, type_name, time_ns, happening.message)
            case "get_result/_service_event":
                self._take_result(action, time_ns, happening.message)
            case "cancel_goal/_service_event":
                self._take_cancel(action, time_ns, happening.message)

    def take_change(self, time_ns: int, event: GoalChanged) -> None:
        """Handle a change that the executive reports."""
        goal = self._of(event.id, event.action)
        goal.owner = event.owner
        match event.change:
            case "sent" | "found again":
                goal.sent_ns = time_ns if goal.sent_ns is None else goal.sent_ns
            case "released":
                goal.handed_over_ns = time_ns
            case "abandoned":
                goal.given_up_ns = time_ns
            case "ended" if event.state == "rejected" and goal.rejected_ns is None:
                goal.rejected_ns, goal.status = time_ns, "rejected"

    def _take_send(
        self, action: str, type_name: str, time_ns: int, message: DecodedMessage
    ) -> None:
        for request in message.request:
            goal = self._goal(request.goal_id, action)
            goal.type_name = action_of(type_name)
            goal.values = _fields(request.goal)
            if goal.sent_ns is None:
                goal.sent_ns = time_ns
            for answer in message.response:
                if answer.accepted:
                    goal.accepted_ns = time_ns
                else:
                    goal.rejected_ns, goal.status = time_ns, "rejected"

    def _take_result(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        for request in message.request:
            for answer in message.response:
                goal = self._goal(request.goal_id, action)
                goal.ended_ns = time_ns
                goal.status = STATUSES.get(answer.status, "unknown")
                goal.result = _fields(answer.result)

    def _take_cancel(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        if message.response:
            return
        for request in message.request:
            goal = self._goal(request.goal_info.goal_id, action)
            goal.cancel_ns = time_ns if goal.cancel_ns is None else goal.cancel_ns

    def _goal(self, goal_id: DecodedMessage, action: str) -> RecordedGoal:
        if np.shape(goal_id.uuid) != (GOAL_ID_BYTES,):
            raise DecodingError(f"a goal's id is expected to have {GOAL_ID_BYTES} bytes")
        return self._of(bytes(goal_id.uuid).hex(), action)

    def _of(self, goal_id: str, action: str) -> RecordedGoal:
        return self._goals.setdefault(goal_id, RecordedGoal(goal_id, action))


def _fields(message: Any) -> DecodedMessage:
    """Return the fields of a goal, a result or a feedback, without its envelope."""
    if not isinstance(message, DecodedMessage):
        raise DecodingError(f"expected a message, got {type(message).__name__}")
    return message


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
