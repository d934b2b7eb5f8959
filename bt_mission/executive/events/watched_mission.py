"""A watched mission, for every view: its state, its pace, and the possible requests."""

from __future__ import annotations

from collections import Counter, deque

from bt_mission.executive.events.events import (
    FINAL,
    OPEN,
    CountsChanged,
    Event,
    NodeChanged,
    NodesReset,
    RunStarted,
    TreeRevised,
)
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_file import FileCheck, MissionOrigin
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import ControlRequest, Received, Verb

WINDOW_S = 3.0
"""Wall time over which the pace is taken."""


class RealTimeFactor:
    """Virtual seconds per second, over the last few seconds."""

    def __init__(self) -> None:
        self._seen: deque[tuple[int, float]] = deque()

    def note(self, time_ns: int, wall_s: float) -> None:
        """Note a ROS time, ns, and the wall time at which it was received, s."""
        if self._seen and time_ns < self._seen[-1][0]:
            self._seen.clear()  # time has restarted
        self._seen.append((time_ns, wall_s))
        while self._seen[-1][1] - self._seen[0][1] > WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()

    @property
    def factor(self) -> float | None:
        """Virtual seconds per second; None if too little was received."""
        if len(self._seen) < 2:
            return None
        (first_ns, first_s), (last_ns, last_s) = self._seen[0], self._seen[-1]
        wall_s = last_s - first_s
        return (last_ns - first_ns) / 1e9 / wall_s if wall_s > 0.2 else None


class WatchedMission:
    """A mission and its pace, from the messages of its executive and its robot."""

    def __init__(self) -> None:
        self.mission = MissionState()
        self._feed = MissionFeed(self.mission)
        self.pace = RealTimeFactor()
        self._file: MissionOrigin | None = None
        self._file_check = FileCheck()

    @property
    def file_note(self) -> str:
        """Whether the mission's file differs from what runs, as text; empty if it does not."""
        return self._file_check.note

    def check_file(self) -> None:
        """Compare the mission's file with what runs; called about once a second."""
        self._file_check.look(self._file)

    @property
    def needs_statuses(self) -> bool:
        """Whether all statuses have to be requested."""
        return self._feed.needs_statuses

    def take(self, received: Received, wall_s: float) -> list[Event]:
        """Apply what was received. Return the events that change the state, in order.

        Args:
            wall_s: Wall time of the reception, s.
        """
        happened: list[Event] = []
        for batch in received.messages:
            self._note_pace(batch, wall_s)
            if batch.file is not None:
                self._file = batch.file
                self.check_file()
            for event in self._feed.take(batch):
                happened.append(event)
                if isinstance(event, RunStarted):
                    self.pace = RealTimeFactor()
                if isinstance(event, RunStarted | TreeRevised):
                    self.on_tree(self.mission.tree)
        for reading in received.robot:
            self.mission.robot.take(reading)
        return happened

    def on_tree(self, tree: RunStarted | None) -> None:
        """Called when another tree is shown from now on; does nothing here."""

    def _note_pace(self, batch: Batch, wall_s: float) -> None:
        tree = self.mission.tree
        for event in batch.events:
            if isinstance(event, CountsChanged | NodeChanged | NodesReset) and (
                event.time_ns is not None and tree is not None and batch.run == tree.run
            ):
                self.pace.note(event.time_ns, wall_s)
                return

    def with_names(self, text: str) -> str:
        """Replace the paths of nodes in a text by their names, such as ``'0.1'``."""
        nodes = self.mission.tree.nodes if self.mission.tree else ()
        names = Counter(node.name for node in nodes)
        for node in nodes:
            where = f" ({node.path})" if names[node.name] > 1 else ""
            text = text.replace(f"'{node.path}'", f"'{node.name}'{where}")
        return text

    def toggled_breakpoint(self, index: int) -> ControlRequest | None:
        """Return the request to set a breakpoint at a node, or to remove the one that is set."""
        tree = self.mission.tree
        if tree is None or not 0 <= index < len(tree.nodes):
            return None
        node = tree.nodes[index]
        for name in (node.path, node.name):
            if name in self.mission.breakpoints:
                return ControlRequest(Verb.UNBREAK, name)
        return ControlRequest(Verb.BREAK, node.path)


def possible_verbs(status: str) -> tuple[Verb, ...]:
    """Return the requests that are possible in a state of a mission."""
    if not status or status in FINAL:
        return ()
    if status == "paused":
        return (Verb.RESUME, Verb.STEP, Verb.STOP, Verb.BREAK)
    if status == "recovering":
        return (Verb.STOP, Verb.BREAK)
    return (Verb.PAUSE, Verb.PAUSE_KEEPING_GOALS, Verb.STOP, Verb.BREAK)


def targets(mission: MissionState) -> tuple[tuple[float, float], ...]:
    """The places of the newest goal that names any, as long as the mission runs."""
    if mission.status in FINAL:
        return ()
    with_places = [goal for goal in mission.goals.values() if goal.targets]
    are_open = [goal for goal in with_places if goal.state in OPEN]
    chosen = are_open or with_places
    return tuple((target.x, target.y) for target in chosen[-1].targets) if chosen else ()
