"""A recording, for pages: where in it one is, and how it moves."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from bt_mission.core.stamps import NS
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import RunStarted, VariableChanged
from bt_mission.events.mission_state import MissionState
from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import Timeline
from bt_mission.views.web.board import Board, Series
from bt_mission.views.web.encoding import ROBOT_PARTS
from bt_mission.views.web.page_requests import PageRequest
from bt_mission.views.web.shown_mission import Notices, OpenPanels, put_state

MARKS = 500
"""Places on the line of time at which changes of the tree are marked."""


@dataclass(frozen=True)
class ForkOffer:
    """How the recording is forked at the instant that is shown.

    Attributes:
        command: Of a terminal, up to that instant in seconds.
        refusal: Why the run cannot run again; empty where it can.
    """

    command: str
    refusal: str = ""


class ReplayedMission:
    """Plays a recording; all pages see the same instant of it.

    Args:
        player: Where in which recording to begin, and how fast.
        fork: What pages are told of forks; None where none are offered.
        robot: Of a recorded fleet, the robot whose mission is shown.
    """

    def __init__(self, player: Player, fork: ForkOffer | None = None, robot: str = "") -> None:
        self.board = Board()
        self.picture: tuple[int, bytes] | None = None  # a timeline holds none
        self._player = player
        name = player.timeline.path.name
        self._source = f"{name}, robot {robot}" if robot else name
        self._notices = Notices(self.board)
        self._since_last = Stopwatch()
        self._shown_ns: int | None = None
        self.board.set_series(series_of(player.timeline))
        self._marks = marks_of(player.timeline)
        if fork is not None:
            self.board.put("fork", asdict(fork))
        self._was_playing = False
        self._has_moved = True

    @property
    def mission(self) -> MissionState:
        """What was known at the instant that is shown."""
        return self._player.mission

    def look(self, panels: OpenPanels) -> None:
        """Move on by the time that has passed, and put on the board what was then."""
        player = self._player
        passed_s, self._since_last = self._since_last.elapsed_s, Stopwatch()
        player.advance(passed_s)
        if self._was_playing and player.is_at_end and player.timeline.why_cut:
            self._notices.say(f"the recording ends here: {player.timeline.why_cut}")
        self._was_playing = player.is_playing
        mission = player.mission
        if self._shown_ns != player.time_ns:
            self._shown_ns = player.time_ns
            self._has_moved = True
            self.board.show(mission, None)
        if panels.map:
            self.board.show_robot(mission, ROBOT_PARTS if self._has_moved else ())
            self._has_moved = False
        put_state(self.board, mission, source=self._source, is_there=True)
        self.board.put(
            "replay",
            {
                "at": player.at_s,
                "duration": player.duration_s,
                "speed": player.speed,
                "is_playing": player.is_playing,
                "is_backwards": player.is_backwards,
                "cut": player.timeline.why_cut,
                "missing": player.timeline.missing,
            },
        )
        self.board.put("marks", self._marks)

    def perform(self, request: PageRequest) -> None:
        """Move in the recording."""
        player = self._player
        self._since_last = Stopwatch()
        match request.do:
            case "play" if player.is_playing:
                player.pause()
            case "play":
                player.play()
            case "reverse":
                player.reverse()
            case "speed" if request.number > 0:
                player.faster(request.number)
            case "go":
                player.go(request.number)
            case "change":
                self._step(1 if request.number > 0 else -1)
            case "start":
                self._start(request.node, 1 if request.number > 0 else -1)
            case _:
                self._notices.say("a mission that is over takes no wishes")

    def _step(self, steps: int) -> None:
        if not self._player.step(steps):
            after = steps > 0
            self._notices.say(
                "the tree does not change after this" if after else "nothing before this"
            )

    def _start(self, node: int, steps: int) -> None:
        tree = self.mission.tree
        if tree is None or node >= len(tree.nodes) or self._player.step_to_start(node, steps):
            return
        when = "later" if steps > 0 else "before this"
        self._notices.say(f"'{tree.nodes[node].name}' does not start {when}")


def series_of(timeline: Timeline) -> dict[str, Series]:
    """The values of each variable that is a number, with their times since the mission's start."""
    found: dict[str, Series] = {}
    start_ns = timeline.start_ns
    for frame in timeline.frames:
        match frame:
            case RunStarted(time_ns):
                found, start_ns = {}, time_ns
            case VariableChanged(time_ns, name, value):
                try:
                    number = float(value)
                except ValueError:
                    continue
                found.setdefault(name, []).append(((time_ns - start_ns) / NS, number))
    return found


def marks_of(timeline: Timeline) -> list[float]:
    """Where in a recording the tree changes, as shares of its length; neighbours count as one."""
    length_ns = max(timeline.end_ns - timeline.start_ns, 1)
    places = {(at_ns - timeline.start_ns) * MARKS // length_ns for at_ns in timeline.changes_ns}
    return sorted(place / MARKS for place in places if 0 <= place <= MARKS)
