"""A running mission, for pages: the attachment, the received messages, and the requests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events import messages
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import (
    Attachment,
    ControlRequest,
    Graph,
    Received,
    Verb,
)
from bt_mission.executive.events.watched_mission import WatchedMission, possible_verbs
from bt_mission.views.web.board import Board, put_state, touched_by
from bt_mission.views.web.camera_jpeg import jpeg_of
from bt_mission.views.web.encoding import ROBOT_PARTS
from bt_mission.views.web.page_requests import PageRequest

if TYPE_CHECKING:
    from bt_mission.scenarios.faults.live import LiveFaults

CHECK_S = 1.0
"""Wall time between two searches for executives, once one is attached."""

PICTURE_S = 0.15
"""Wall time between two pictures of the camera."""

VERBS = {
    "pause": Verb.PAUSE,
    "pause_keeping_goals": Verb.PAUSE_KEEPING_GOALS,
    "resume": Verb.RESUME,
    "step": Verb.STEP,
    "stop": Verb.STOP,
}
WORDS = {verb: word for word, verb in VERBS.items()} | {Verb.BREAK: "breakpoint"}


@dataclass(frozen=True)
class OpenPanels:
    """The open panels of pages, besides those that are always shown."""

    map: bool = False
    camera: bool = False


class LiveMission:
    """Watches an executive of a graph.

    Args:
        graph: The executives.
        name: The executive to watch; None takes the only one, or has a page choose.
        refusal: Returns why no request is possible any more; empty as long as requests are.
        is_fleet: Offer the choice of another executive as long as there are several.
        faults: Makes the faults that pages ask for; None where none can be made.
    """

    def __init__(
        self,
        graph: Graph,
        name: str | None = None,
        refusal: Callable[[], str] = lambda: "",
        *,
        is_fleet: bool = False,
        faults: LiveFaults | None = None,
    ) -> None:
        self.board = Board()
        self.picture: tuple[int, bytes] | None = None
        """The newest image of the camera as JPEG, and its number; None without one."""
        self.nobody_s = 0.0
        """Wall time for which nobody was there, s, as long as nobody has been watched yet."""
        self._graph = graph
        self._attachment = Attachment(graph, name)
        self._refusal = refusal
        self._faults = faults
        self._watched = WatchedMission()
        self._notices = 0
        self._wall, self._since_check = Stopwatch(), Stopwatch()
        self._since_picture = Stopwatch()
        self._hint = ""
        self._has_moved = self._is_new = True
        """Whether the robot has sent anything, and whether the mission is another one than before,
        that is not on the board yet.
        """
        self._is_choice, self._is_fleet = False, is_fleet

    @property
    def mission(self) -> MissionState:
        """Its state now."""
        return self._watched.mission

    def attach(self, name: str) -> None:
        """Watch this executive from now on."""
        self._watch_anew()
        self._attachment.attach(name)

    def look(self, panels: OpenPanels) -> None:
        """Put what was received on the board."""
        self._graph.serve()
        self._look_round()
        source, watched = self._attachment.source, self._watched
        received = Received()
        if source is not None:
            source.watch_camera(is_on=panels.camera)
            received = source.take(needs_statuses=watched.needs_statuses)
        happened = watched.take(received, self._wall.elapsed_s)
        for answer in received.answers:
            self._say(watched.with_names(answer.text))
        self._has_moved |= bool(received.robot)
        self._show_image(received.image)
        if received.messages or self._is_new:
            self._is_new = False
            self.board.show(watched.mission, touched_by(happened))
            self.board.remember(watched.mission, happened)
        if panels.map:
            self.board.show_robot(watched.mission, ROBOT_PARTS if self._has_moved else ())
            self._has_moved = False
        self._show_faults()
        self._put_state()

    def perform(self, request: PageRequest) -> None:
        """Send a request to the executive; its response arrives later, as a notice."""
        source = self._attachment.source
        if request.do == "attach":
            if request.name in (executive.name for executive in self._graph.find()):
                self.attach(request.name)
            else:
                self._say(f"{request.name} no longer exists")
            return
        if refusal := self._refusal():
            self._say(refusal)
        elif source is None:
            self._say("no executive is watched yet")
        elif request.do == "fault":
            self._make_fault(request.name)
        elif request.do == "breakpoint":
            if (wish := self._watched.toggled_breakpoint(request.node)) is not None:
                source.send(wish)
        else:
            source.send(ControlRequest(VERBS[request.do]))

    def _make_fault(self, text: str) -> None:
        if self._faults is None:
            self._say("only a simulated run of one robot takes faults, and no fork")
        else:
            self._faults.make(text)

    def _show_faults(self) -> None:
        if self._faults is not None:
            self.board.put("faults", [[text, at] for text, at in self._faults.begun])
            for line in self._faults.take_lines():
                self._say(line)

    def _show_image(self, image: messages.CameraImage | None) -> None:
        """Keep a picture for the pages, a few times a second at most."""
        if image is None or self._since_picture.elapsed_s < PICTURE_S:
            return
        self._since_picture = Stopwatch()
        jpeg = jpeg_of(image)
        if jpeg is not None:
            self.picture = (self.picture[0] + 1 if self.picture else 1, jpeg)

    # ---- inside ---------------------------------------------------------------------------

    def _say(self, text: str) -> None:
        """Send a line to all pages; each counts, so that the same one can be sent twice."""
        self._notices += 1
        self.board.put("notice", [self._notices, text])

    def _watch_anew(self) -> None:
        self._watched, self._has_moved, self._is_new = WatchedMission(), True, True

    def _look_round(self) -> None:
        """Search for executives: always without an attachment, and every few seconds with one."""
        if self._attachment.source is not None and self._since_check.elapsed_s < CHECK_S:
            return
        self._since_check = Stopwatch()
        self._watched.check_file()
        change = self._attachment.look()
        self._is_choice = change.is_choice
        if change.is_new:
            self._watch_anew()
        self._hint = change.text if change.is_nobody else ""
        if change.text and not change.is_nobody:
            self._say(change.text)
        self.nobody_s = self._wall.elapsed_s if change.is_nobody else 0.0

    def _put_state(self) -> None:
        source, mission = self._attachment.source, self.mission
        can: list[str] = []
        if source is not None and source.is_there and not self._refusal():
            can = [WORDS[verb] for verb in possible_verbs(mission.status)]
        factor = self._watched.pace.factor
        put_state(
            self.board,
            mission,
            source=source.name if source else "",
            is_there=source is not None and source.is_there,
            can=can,
            file_note=self._watched.file_note,
        )
        self.board.put("factor", None if factor is None else round(factor, 1))
        self.board.put("hint", self._hint)
        is_choice = self._is_choice or self._is_fleet
        choices = (
            [(executive.name, executive.problem) for executive in self._graph.find()]
            if is_choice
            else []
        )
        self.board.put("choices", choices)
