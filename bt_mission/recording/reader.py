"""Reads a recording back into what is known of its run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_mission.core.cdr.decoder import Decoder, DecodingError
from bt_mission.recording.goal_lives import GoalLives
from bt_mission.recording.model import (
    Picture,
    RecordedChange,
    RecordedLine,
    RecordedNode,
    RecordedRun,
)
from bt_mission.recording.reading import Channel, RecordedFile, RecordingError
from bt_mission.recording.robot_life import RobotLife
from bt_mission.recording.spans import spans_of

STATUSES = ("halted", "running", "success", "failure")
"""By the numbers of ``bt_mission_interfaces/msg/NodeStatus``."""

_POSE_LINE = b'"event": "pose"'


def read_run(path: Path) -> RecordedRun:
    """Read a recording; one that was cut gives what stands in it.

    :raises RecordingError: for a file that is none, or holds no run of a mission.
    """
    file = RecordedFile(path)
    reader = _RunReader(file)
    for channel, time_ns, data in file.messages():
        reader.take(channel, time_ns, data)
    return reader.run()


class _RunReader:
    """Takes messages in, topic by topic."""

    def __init__(self, file: RecordedFile) -> None:
        self._file = file
        self._decoders: dict[Channel, Decoder] = {}
        self._topics: set[str] = set()
        self._first_ns: int | None = None
        self._last_ns = 0
        self._nodes: tuple[RecordedNode, ...] = ()
        self._mission = self._node = ""
        self._changes: list[RecordedChange] = []
        self._state = ("", "")
        self._log: list[RecordedLine] = []
        self._pictures: list[Picture] = []
        self._goals = GoalLives()
        self._robot: RobotLife | None = None
        self._takers = {
            "bt_mission_interfaces/msg/Tree": self._take_tree,
            "bt_mission_interfaces/msg/StatusChanges": self._take_changes,
            "bt_mission_interfaces/msg/MissionState": self._take_state,
            "rcl_interfaces/msg/Log": self._take_log,
            "sensor_msgs/msg/CompressedImage": self._take_picture,
        }

    def take(self, channel: Channel, time_ns: int, data: bytes) -> None:
        """Take a message in; one that cannot be read is passed over."""
        self._topics.add(channel.topic)
        if channel.encoding != "cdr":
            return
        if self._first_ns is None:
            self._first_ns = time_ns
        self._last_ns = max(self._last_ns, time_ns)
        try:
            self._hand_on(channel, time_ns, data)
        except DecodingError:
            return

    def _hand_on(self, channel: Channel, time_ns: int, data: bytes) -> None:
        taker = self._takers.get(channel.type_name)
        if taker is not None:
            taker(channel.topic, time_ns, self._decode(channel, data))
        elif channel.topic.endswith("/trace"):
            if _POSE_LINE not in data:
                self._take_line(time_ns, self._decode(channel, data)["data"])
        elif "/_action/" in channel.topic:
            self._goals.take(channel, time_ns, lambda: self._decode(channel, data))
        else:
            if self._robot is None:
                facts = self._file.notes.get("bt_mission", {})
                hull = json.loads(facts.get("robot_hull", "null"))
                self._robot = RobotLife(facts.get("namespace", "/"), hull)
            self._robot.take(channel.topic, time_ns, lambda: self._decode(channel, data))

    def _decode(self, channel: Channel, data: bytes) -> dict[str, Any]:
        if channel not in self._decoders:
            self._decoders[channel] = Decoder(channel.type_name, channel.definition)
        return self._decoders[channel].decode(data)

    # ---- one kind of message each ----------------------------------------------------------

    def _take_tree(self, topic: str, _time_ns: int, message: Mapping[str, Any]) -> None:
        self._node = topic.removesuffix("/tree")
        self._mission = message["mission"]
        self._nodes = tuple(
            RecordedNode(node["name"], node["kind"], node["path"], node["parent"])
            for node in message["nodes"]
        )

    def _take_changes(self, _topic: str, time_ns: int, message: Mapping[str, Any]) -> None:
        self._changes += [
            RecordedChange(time_ns, one["node"], STATUSES[one["status"]], one["message"])
            for one in message["changes"]
            if one["node"] < len(self._nodes) and one["status"] < len(STATUSES)
        ]

    def _take_state(self, _topic: str, _time_ns: int, message: Mapping[str, Any]) -> None:
        self._state = (message["status"], message["reason"])

    def _take_log(self, _topic: str, time_ns: int, message: Mapping[str, Any]) -> None:
        self._log.append(RecordedLine(time_ns, message["level"], message["name"], message["msg"]))

    def _take_picture(self, topic: str, time_ns: int, message: Mapping[str, Any]) -> None:
        kind = "png" if "png" in message["format"] else "jpeg"
        self._pictures.append(Picture(time_ns, topic, f"image/{kind}", message["data"].tobytes()))

    def _take_line(self, time_ns: int, line: str) -> None:
        try:
            event = json.loads(line)
        except ValueError:
            return
        if str(event.get("event", "")).startswith("goal "):
            self._goals.take_event(event, time_ns)

    # ---- the end ---------------------------------------------------------------------------

    def run(self) -> RecordedRun:
        """All of it.

        :raises RecordingError: where there is no mission in it.
        """
        file = self._file
        facts = file.notes.get("bt_mission", {})
        if not self._nodes:
            raise RecordingError(f"{file.path}: {self._why_no_run(facts)}")
        summary = {
            name: json.loads(value)
            for name, value in file.notes.get("bt_mission_summary", {}).items()
        }
        start_ns = int(facts.get("start_ns", self._first_ns or 0))
        robot = self._robot or RobotLife(facts.get("namespace", "/"), None)
        texts = {
            one.name: one.data.decode(errors="replace")
            for one in file.attached
            if one.media_type == "text/plain"
        }
        saved = [
            Picture(one.time_ns, one.name, one.media_type, one.data)
            for one in file.attached
            if one.media_type.startswith("image/")
        ]
        return RecordedRun(
            path=file.path,
            mission=self._mission,
            node=self._node,
            facts=facts,
            summary=summary,
            start_ns=start_ns,
            end_ns=self._last_ns,
            status=self._state[0],
            reason=self._state[1],
            why_cut=file.why_cut,
            missing=summary.get("missing", ""),
            tree=self._nodes,
            changes=tuple(self._changes),
            spans=spans_of(len(self._nodes), self._changes, self._last_ns),
            truth=robot.truth,
            measured=robot.measured,
            scans=robot.scans,
            grid=robot.grid,
            goals=self._goals.lives,
            log=tuple(self._log),
            battery=robot.battery,
            collisions=tuple(robot.collisions),
            pictures=tuple(sorted([*saved, *self._pictures], key=lambda one: one.time_ns)),
            files=texts,
            versions=json.loads(facts.get("versions", "{}")),
            hull=robot.hull,
        )

    def _why_no_run(self, facts: Mapping[str, str]) -> str:
        if facts:
            return f"it ends before the mission began: {self._file.why_cut or 'nothing was ticked'}"
        topics = ", ".join(sorted(self._topics)[:5]) or "none"
        return (
            "no run of a mission is in it; bt-mission run --record makes such files "
            f"(topics here: {topics}{', ...' if len(self._topics) > 5 else ''})"
        )
