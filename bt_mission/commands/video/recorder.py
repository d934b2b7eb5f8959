"""The recorder of a video: a frame for each twentieth of a second of virtual time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol, Self

import numpy as np
import numpy.typing as npt

from bt_mission.base.errors import described
from bt_mission.commands.video.ground import Ground, Zone
from bt_mission.commands.video.mp4 import Mp4File, Picture
from bt_mission.commands.video.panel import Captions, PanelLeaf, panel
from bt_mission.executive.behaviours.leaves import progress_of
from bt_mission.executive.events.events import Event, GoalChanged, LogLine
from bt_mission.executive.goals.poses import NamedPose
from bt_mission.sessions.session import Session

FPS = 20
"""Frames a second of virtual time: one for each tick."""

WIDTH, HEIGHT = 1280, 720
ABOVE = (720, 720)
AHEAD = (560, 420)
"""Widths and heights of the two images; captions are below the second."""

AHEAD_EVERY = 2
"""Frames for each new picture of the robot's camera, which takes 10 a second."""

SEEN_EVERY = 4
"""Frames for each new scan of the lidar, which takes 5 a second."""

OUTCOME_S = 2.5
"""The time for which the outcome is shown at the end."""

FRAMES = ("", "map")
"""The frames that goals use on the map of the image."""


class MovingImage(Protocol):
    """Something that moves."""

    def paint(self, onto: Picture, /) -> None:
        """Put it into a whole picture."""


class RobotViews(Protocol):
    """The source of the images: `sim.views.views`."""

    still: Picture

    @property
    def pose(self) -> tuple[float, float, float]:
        """The robot's pose: m, m, rad."""

    def pixel(self, x: Any, y: Any, /) -> tuple[Any, Any]:
        """Return the pixels of points of the map from above."""

    def look(self) -> None:
        """Have the next pictures be those of the present instant."""

    def moving(self) -> Iterable[MovingImage]:
        """Return the moving objects from above."""

    def ahead(self) -> Picture:
        """Return the image of the robot's camera."""

    def seen(self) -> npt.NDArray[np.float64]:
        """Return the ends of the lidar's rays: n x 2, m."""

    def close(self) -> None:
        """Give the renderers back."""


class VideoRecorder:
    """Records a video of a session from now on, until it is closed.

    Use it as a context manager around the steps of the session, before the first one. It runs after
    each tick, and changes nothing: an error ends the video, and the mission continues.

    Args:
        session: A mission on the stage.
        views: The source of the images; closed with the video.
        file: Where the frames go, :data:`WIDTH` x :data:`HEIGHT`, :data:`FPS`.
        zones: Named places of the world.
    """

    def __init__(
        self, session: Session, views: RobotViews, file: Mp4File, zones: Iterable[Zone] = ()
    ) -> None:
        self.file = file
        self._session = session
        self._views = views
        self._ground = Ground(views.still, views.pixel)
        self._ground.name_zones(zones)
        self._frame: Picture = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
        self._seen = np.empty((0, 2))
        self._log_line = ""
        self._is_closed = False
        session.executive.after_tick.append(self._look)
        session.executive.events.subscribe(self._take)
        self._look()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(replaces=kind is None)

    @property
    def missing(self) -> str:
        """The missing part of the video, as text; empty if it is complete."""
        if self.file.write_error is None:
            return ""
        return f"everything after {self.file.frames / FPS:.1f} s ({self.file.write_error})"

    def finish(self) -> None:
        """Show the result of the mission, and close the video."""
        self._guarded(lambda: self._shoot(round(OUTCOME_S * FPS)))
        self.close()

    def close(self, *, replaces: bool = True) -> None:
        """Stop recording; further calls do nothing.

        Args:
            replaces: Whether a complete video replaces an existing file.
        """
        if self._is_closed:
            return
        self._is_closed = True
        self._session.executive.after_tick.remove(self._look)
        self._session.executive.events.unsubscribe(self._take)
        self._guarded(self._views.close)
        self.file.close(replaces=replaces)

    # ---- while it runs ---------------------------------------------------------------------

    def _look(self) -> None:
        self._guarded(self._look_now)

    def _look_now(self) -> None:
        """Add the frames that are due; after a jump of time, several equal ones."""
        elapsed_ns = self._session.now_ns - self._session.start_ns
        due = elapsed_ns * FPS // 1_000_000_000 + 1 - self.file.frames
        if due > 0:
            self._shoot(due)

    def _take(self, event: Event) -> None:
        match event:
            case LogLine(text=text):
                self._log_line = text
            case GoalChanged(change="sent", targets=targets):
                self._guarded(lambda: self._mark(targets))

    def _mark(self, targets: Sequence[NamedPose]) -> None:
        for place in targets:
            if place.frame in FRAMES:
                self._ground.mark(place.x, place.y)

    def _shoot(self, times: int) -> None:
        if self.file.write_error is not None:
            return
        views, frame = self._views, self._frame
        views.look()
        x, y, _ = views.pose
        self._ground.go(x, y)
        if self.file.frames % SEEN_EVERY == 0:
            self._seen = views.seen()
        above = self._ground.with_scan(self._seen)
        for patch in views.moving():
            patch.paint(above)
        frame[:, : ABOVE[0]] = above
        if self.file.frames % AHEAD_EVERY == 0:
            frame[: AHEAD[1], ABOVE[0] :] = views.ahead()
        frame[AHEAD[1] :, ABOVE[0] :] = panel(self._captions(), AHEAD[0], HEIGHT - AHEAD[1])
        self.file.add(frame, times)

    def _captions(self) -> Captions:
        session, executive = self._session, self._session.executive
        driven = session.runs[0].distance_travelled_m or 0.0
        counts = f"goals sent: {executive.goals_sent}, collisions: {session.runs[0].collisions}"
        leaves = executive.running_leaves if executive.status.is_active else []
        return Captions(
            mission=session.mission.name,
            seconds=(session.now_ns - session.start_ns) / 1e9,
            state=executive.mission_state.conclusion[0],
            leaves=tuple(PanelLeaf(leaf.name, progress_of(leaf)) for leaf in leaves),
            log_line=self._log_line,
            facts=f"{driven:.2f} m driven, {counts}",
            reason=executive.mission_state.conclusion[1],
        )

    def _guarded(self, call: Callable[[], None]) -> None:
        try:
            call()
        except Exception as error:  # noqa: BLE001 - looking on must not change what happens
            self.file.abandon(f"the video failed: {described(error)}")
