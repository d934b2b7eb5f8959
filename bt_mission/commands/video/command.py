"""``--video``: a video of a simulated run, which commands that keep a run take."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.cli.argument_types import FileType
from bt_mission.cli.extensions import Kept, RunFileKind
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.base.output import OutputFile
    from bt_mission.commands.video.recorder import VideoRecorder
    from bt_mission.sessions.session import Session


def _check_encoder() -> None:
    from bt_mission.commands.video.mp4 import load_encoder

    load_encoder()


VIDEO = Option(
    "--video FILE.mp4",
    "save a video of the simulated run, from above and through the camera",
    FileType("output", (".mp4",), "videos are MP4 files", takes_devices=False),
    excludes=each(
        "attach",
        why="it shows a simulation in this process; record the camera (--record FILE.mcap "
        "--record-camera) for Foxglove, or generate a report (--report FILE.html)",
    ),
    not_for=each(
        "fleet",
        why="a video shows one robot; record the fleet (--record FILE.mcap) and replay it",
    ),
    page="recording",
    check=_check_encoder,
)


@dataclass(frozen=True)
class Film:
    """The video of a run while it is written."""

    recorder: VideoRecorder

    @property
    def output(self) -> OutputFile:
        """Its file."""
        return self.recorder.file.output

    def finish(self) -> Kept:
        """Close it; return what is to be said of it, by name."""
        from bt_mission.cli.recording import lacks

        film = self.recorder
        film.finish()
        return {
            "video": str(film.file.path),
            "video_frames": film.file.frames,
            "video_bytes": film.file.bytes,
            "video_lacks": lacks((film.missing, film.file.output)),
        }


@contextmanager
def film_of(path: Path, session: Session) -> Iterator[Film | None]:
    """A video of a session on the stage, to be finished; None of another session."""
    from bt_mission.sessions.stage import Stage

    if not isinstance(session, Stage):
        yield None
        return
    from bt_mission.commands.video.mp4 import Mp4File
    from bt_mission.commands.video.recorder import ABOVE, AHEAD, FPS, HEIGHT, WIDTH, VideoRecorder
    from sim.views.views import WorldViews

    robot = session.runs[0].robot
    views = WorldViews(robot, above=ABOVE, ahead=AHEAD)
    zones = [(zone.name, zone.x, zone.y, zone.radius) for zone in robot.physics.world.zones]
    with VideoRecorder(session, views, Mp4File(path, WIDTH, HEIGHT, FPS), zones) as film:
        yield Film(film)


def film_lines(kept: Kept) -> Iterator[str]:
    """Yield a line about a video that is closed."""
    from bt_mission.cli.recording import file_line

    if "video" in kept:
        size = f"{kept['video_frames']} frames, {int(kept['video_bytes']) / 1e6:.2f} MB"
        yield file_line(f"  video saved to {kept['video']} ({size})", kept["video_lacks"])


VIDEO_FILE = RunFileKind(VIDEO, film_of, film_lines)
