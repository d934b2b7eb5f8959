"""A recording as the messages of a page: changes with their times.

The messages are those of a live page, since both come from a :class:`Board`. The page applies them
in order for any instant. Poses, scans and maps are thinned: a page shows them, nothing is computed
from them.
"""

from __future__ import annotations

import math
from itertools import groupby
from operator import itemgetter
from typing import Any

import numpy as np

from bt_mission.base.geometry import Pose2D
from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control
from bt_mission.executive.events import messages
from bt_mission.executive.events.events import Event
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.reading import UNREADABLE
from bt_mission.recording.recorded_messages import RobotMessage
from bt_mission.recording.replay.timeline import Frame, Timeline
from bt_mission.views.web.board import Board, put_state, touched_by

POSE_NS = 200_000_000
SCAN_NS = 1_000_000_000
"""ROS time between two poses, and between two scans, that are kept."""

MOST_SCANS = 3_600
MOST_MAPS = 60
"""Maps of a recording, spread over it; a map that equals the one before does not count."""

SCAN_POINTS = 180
"""Points of one scan, spread over it."""

STEP_M, TURN_RAD = 0.005, 0.02
"""A robot that has moved less stands."""


class ReportHistory:
    """Walks through a timeline once, and keeps what a page needs to show any instant of it."""

    def __init__(self, timeline: Timeline) -> None:
        self.mission = MissionState()
        """The state at the end."""
        self._timeline = timeline
        self._length_ns = timeline.end_ns - timeline.start_ns
        self._board = Board()
        self._revision = 0
        self._times: list[float] = []
        self._messages: list[dict[str, Any]] = []
        self._poses = RobotTrack()
        self._others: dict[str, RobotTrack] = {}
        self._scan_ns = self._map_ns = -math.inf
        self._skipped_map: RobotMessage | None = None
        for time_ns, same in groupby(
            zip(timeline.times_ns, timeline.frames, strict=True), itemgetter(0)
        ):
            self._take(time_ns, [frame for _, frame in same])
        self._take_last_map()

    def data(self) -> dict[str, Any]:
        """Return it, ready for JSON; times are s since the start of the recording."""
        timeline = self._timeline
        return {
            "start": timeline.start_ns / NS,
            "duration": self._length_ns / NS,
            "changes": sorted({self._s(time_ns) for time_ns in timeline.changes_ns}),
            "times": self._times,
            "messages": self._messages,
            "poses": self._poses.data(),
            "others": {escape_control(name): track.data() for name, track in self._others.items()},
        }

    def _s(self, time_ns: int) -> float:
        return round((time_ns - self._timeline.start_ns) / NS, 3)

    def _take(self, time_ns: int, frames: list[Frame]) -> None:
        """Take in all that happened at an instant."""
        happened: list[Event] = []
        has_moved = has_seen = has_charge = False
        for frame in frames:
            if isinstance(frame, tuple):
                self.mission.robot.take(frame)
                has_moved = True
                continue
            match frame:
                case RobotMessage():
                    has_seen |= self._see(time_ns, frame)
                case messages.OtherRobot(name, x, y, yaw):
                    self._others.setdefault(name, RobotTrack()).add(
                        self._s(time_ns), Pose2D(x, y, yaw)
                    )
                case messages.BatteryState():
                    before = self.mission.robot.charge or 0.0
                    self.mission.robot.take(frame)
                    has_charge = round(before, 1) != round(self.mission.robot.charge or 0.0, 1)
                case messages.ScanPoints() | messages.Map() | messages.Zones():
                    self.mission.robot.take(frame)
                    has_seen = True
                case event:
                    self.mission.apply(event)
                    happened.append(event)
        if has_moved and self._poses.is_due(self._s(time_ns), POSE_NS / NS):
            pose = self.mission.robot.pose
            if pose is not None:
                self._poses.add(self._s(time_ns), pose)
        if happened or has_seen or has_charge:
            self._keep(time_ns, happened, has_seen=has_seen)

    def _see(self, time_ns: int, message: RobotMessage) -> bool:
        """Handle a scan, a map or zones if one is due; return whether it is."""
        match message.topic:
            case "scan":
                if time_ns - self._scan_ns < max(SCAN_NS, self._length_ns // MOST_SCANS):
                    return False
                self._scan_ns = time_ns
            case "map":
                if time_ns - self._map_ns < self._length_ns // MOST_MAPS:
                    self._skipped_map = message
                    return False
                self._map_ns, self._skipped_map = time_ns, None
        seen = viewed(message)
        if seen is None or seen == self.mission.robot.map:
            return False
        self.mission.robot.take(seen)
        return True

    def _take_last_map(self) -> None:
        """Take in the last map, whether it was due or not."""
        newest = None if self._skipped_map is None else viewed(self._skipped_map)
        if newest is not None:
            self.mission.robot.take(newest)
            self._keep(self._timeline.end_ns, [], has_seen=True)

    def _keep(self, time_ns: int, happened: list[Event], *, has_seen: bool) -> None:
        """Keep what has changed on the board."""
        board, mission = self._board, self.mission
        board.show(mission, touched_by(happened))
        board.show_robot(mission, ("frame", "zones", "scan") if has_seen else ())
        put_state(board, mission, is_there=True)
        board.put("ended", mission.elapsed_ns / NS if mission.is_over else None)
        changed = board.since(self._revision)
        if robot := board.robot_since(self._revision):
            changed["robot"] = robot
            if "scan" in robot:
                robot["scan"] = thinned_scan(robot["scan"])
        self._revision = board.revision
        changed.pop("clock", None)  # the page knows the time that it shows
        changed.pop("past", None)
        if changed:
            self._times.append(self._s(time_ns))
            self._messages.append(changed)


def viewed(message: RobotMessage) -> messages.Robot | None:
    """Return a message for viewers; None if it cannot be read."""
    try:
        return message.viewed()
    except UNREADABLE:
        return None


class RobotTrack:
    """The track of a robot: times, s, and poses, m and rad; in columns, for JSON."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float, float]] = []
        self._is_still = False

    def is_due(self, time_s: float, every_s: float) -> bool:
        """Return whether the last pose is old enough."""
        return not self._rows or time_s - self._rows[-1][0] >= every_s

    def add(self, time_s: float, pose: Pose2D) -> None:
        """Keep a pose; of a standing robot the first and the last."""
        if not math.isfinite(pose.x + pose.y + pose.yaw):
            return
        row = (time_s, round(pose.x, 3), round(pose.y, 3), round(pose.yaw, 3))
        if self._rows:
            _, x, y, yaw = self._rows[-1]
            is_still = (
                math.hypot(pose.x - x, pose.y - y) < STEP_M and abs(pose.yaw - yaw) < TURN_RAD
            )
            if is_still and self._is_still:
                self._rows[-1] = (time_s, x, y, yaw)
                return
            self._is_still = is_still
        self._rows.append(row)

    def data(self) -> dict[str, list[float]]:
        """Return it in columns."""
        columns = [list(column) for column in zip(*self._rows, strict=True)] or [[], [], [], []]
        return dict(zip(("t", "x", "y", "yaw"), columns, strict=True))


def thinned_scan(points: list[int]) -> list[int]:
    """Return at most :data:`SCAN_POINTS` of a scan's points, x and y in turn, cm."""
    places = np.asarray(points, np.int64).reshape(-1, 2)
    kept: list[int] = np.unique(places[spread(len(places), SCAN_POINTS)], axis=0).ravel().tolist()
    return kept


def spread(count: int, most: int) -> Any:
    """Return at most `most` of the first numbers, spread evenly."""
    return np.unique(np.linspace(0, max(0, count - 1), min(count, most)).astype(int))
