"""The option of commands that film a run, and what it does."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.core.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.sessions.observers import ObservableSession
    from bt_mission.views.video.recorder import VideoRecorder


def add_video_option(parser: argparse.ArgumentParser) -> None:
    """Where a run is filmed to."""
    parser.add_argument(
        "--video",
        type=Path,
        metavar="FILE.mp4",
        help="film the simulated run: from above, and by the camera (docs/how-to/recording.md)",
    )


def refuse_video(options: argparse.Namespace) -> None:
    """Refuse what cannot be filmed, before anything moves.

    :raises BtMissionError: with what to do instead.
    """
    if options.video is None:
        return
    if options.attach:
        raise BtMissionError(
            "--video films a simulation in this process; of an attached run, record the camera "
            "(--record FILE.mcap --record-camera) and look at it in Foxglove, or make a page of "
            "it (--report FILE.html)"
        )
    if options.video.suffix.lower() != ".mp4":
        raise BtMissionError(f"--video: films are MP4 files, call it {options.video.stem}.mp4")
    if not options.video.parent.is_dir():
        raise BtMissionError(f"{options.video}: there is no folder {options.video.parent}")
    from bt_mission.views.video.mp4 import load_encoder

    load_encoder()


@contextmanager
def film_of(path: Path | None, session: ObservableSession) -> Iterator[VideoRecorder | None]:
    """A film of a session on the stage, to be finished; None where none is wanted.

    :raises BtMissionError: when its file cannot be written, or nothing can be drawn.
    """
    from bt_mission.sessions.stage import Stage

    if path is None or not isinstance(session, Stage):
        yield None
        return
    from bt_mission.views.video.mp4 import Mp4File
    from bt_mission.views.video.recorder import ABOVE, AHEAD, FPS, HEIGHT, WIDTH, VideoRecorder
    from sim.views.views import WorldViews

    simulation = session.sim.simulation
    views = WorldViews(simulation, above=ABOVE, ahead=AHEAD)
    zones = [(zone.name, zone.x, zone.y, zone.radius) for zone in simulation.world.zones]
    with VideoRecorder(session, views, Mp4File(path, WIDTH, HEIGHT, FPS), zones) as film:
        session.runner.log_listeners.append(film.hear)
        yield film
