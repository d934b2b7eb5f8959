"""Options of commands that keep a run in files: its trace, a recording, a page, a video."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Protocol

from bt_mission.cli.argument_types import output_file
from bt_mission.cli.options import add_force_option
from bt_mission.cli.outputs import file_of_robot
from bt_mission.core.errors import BtMissionError, cause_of

if TYPE_CHECKING:
    from bt_mission.core.output import OutputFile
    from bt_mission.executive.trace import TraceFile
    from bt_mission.recording.writer import RunRecorder
    from bt_mission.sessions.session import ObservableSession, ObservedRun
    from bt_mission.views.video.recorder import VideoRecorder


PAGES = (".html", ".htm")


class Summary(Protocol):
    """What a run came to."""

    def as_dict(self) -> dict[str, Any]:
        """Its fields by name, ready for JSON."""


Kept = dict[str, str | int]
"""What was kept of a run, by name, as programs are told."""


def add_recording_options(parser: argparse.ArgumentParser) -> None:
    """Where a run is kept, and what of it."""
    parser.add_argument(
        "--trace",
        type=output_file,
        metavar="FILE.jsonl",
        help="write what happens to this file, as JSON lines",
    )
    parser.add_argument(
        "--record",
        type=output_file,
        metavar="FILE.mcap",
        help="record the run: every topic, the tree, goals and feedback (docs/how-to/recording.md)",
    )
    parser.add_argument(
        "--report",
        type=output_file,
        metavar="FILE.html",
        help="make a page of the run, for any browser",
    )
    parser.add_argument(
        "--record-camera",
        choices=("compressed", "raw"),
        nargs="?",
        const="compressed",
        help="with --record: the camera's pictures too, as JPEGs or as they are; a simulated "
        "camera then draws all the time, which takes long",
    )
    parser.add_argument(
        "--record-raw-actions",
        action="store_true",
        help="with --record: name the types of goals and feedback as ROS does "
        "(Turn_SendGoal_Event), which mcap-ros2-support and rosbags refuse",
    )
    parser.add_argument(
        "--video",
        type=output_file,
        metavar="FILE.mp4",
        help="film the simulated run: from above, and by the camera (docs/how-to/recording.md)",
    )
    add_force_option(parser)


def refuse_recording(options: argparse.Namespace) -> None:
    """Refuse options that contradict each other.

    Raises:
        BtMissionError: With what to do instead.
    """
    if options.record_camera and not (options.record or options.report):
        raise BtMissionError("--record-camera: name the file to record to with --record FILE.mcap")
    if options.record_raw_actions and not options.record:
        raise BtMissionError(
            "--record-raw-actions: name the file to record to with --record FILE.mcap"
        )
    _refuse_video(options)
    if options.record is not None and not is_recording_name(options.record):
        raise BtMissionError(
            f"--record: recordings are MCAP files, call it {options.record.stem}.mcap"
        )
    page = options.report
    if page is not None and page.suffix.lower() not in PAGES and not _is_device(page):
        raise BtMissionError(f"--report: a report is a page of HTML, call it {page.stem}.html")


def is_recording_name(path: Path) -> bool:
    """Is this what a recording may be called? A device is no file, and may have any name."""
    return path.suffix.lower() == ".mcap" or _is_device(path)


def _is_device(path: Path) -> bool:
    return path.exists() and not path.is_file()


def _refuse_video(options: argparse.Namespace) -> None:
    """Refuse what cannot be filmed, before anything moves."""
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
    from bt_mission.views.video.mp4 import load_encoder

    load_encoder()


@contextmanager
def recorder_for(options: argparse.Namespace, session: ObservableSession) -> Iterator[RunFiles]:
    """What keeps the run as the options ask for: in a recording, a page, a film, or not at all.

    Raises:
        BtMissionError: When a file cannot be written.
    """
    from bt_mission.executive.trace import TraceFile

    with ExitStack() as stack:
        traces = [
            stack.enter_context(TraceFile(run.runner.trace, path))
            for run, path in _traces_of(options.trace, session)
        ]
        film = stack.enter_context(_film_of(options.video, session))
        path = options.record
        if path is None and options.report is not None:
            path = Path(stack.enter_context(TemporaryDirectory())) / "run.mcap"
        if path is None:
            yield RunFiles(None, None, None, film, traces)
            return
        from bt_mission.recording.contents import RecordingOptions
        from bt_mission.recording.writer import RunRecorder

        wanted = RecordingOptions(
            camera=options.record_camera or "none", raw_actions=options.record_raw_actions
        )
        recorder = stack.enter_context(RunRecorder(session, path, wanted))
        yield RunFiles(recorder, options.record, options.report, film, traces)


def _traces_of(path: Path | None, session: ObservableSession) -> Iterator[tuple[ObservedRun, Path]]:
    """Yield the runs of a session with the files of their traces: of several, one for each."""
    if path is not None:
        for run in session.runs:
            name = run.node.get_namespace().strip("/")
            yield run, path if len(session.runs) == 1 else file_of_robot(path, name)


@contextmanager
def _film_of(path: Path | None, session: ObservableSession) -> Iterator[VideoRecorder | None]:
    """A film of a session on the stage, to be finished; None where none is wanted."""
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


@dataclass(frozen=True)
class RunFiles:
    """A run on its way into files."""

    recorder: RunRecorder | None
    recording: Path | None
    page: Path | None
    film: VideoRecorder | None
    traces: Sequence[TraceFile] = ()

    def finish(self, report: Summary) -> Kept:
        """Close all files, and make the page; gives what is to be said of them, by name."""
        return {**self._finish_traces(), **self._finish_film(), **self._finish_recording(report)}

    def _finish_traces(self) -> Kept:
        for trace in self.traces:
            trace.close()
        if not self.traces:
            return {}
        return {
            "trace": ", ".join(str(trace.file.place) for trace in self.traces),
            "trace_lacks": _lacks(*((trace.missing, trace.file) for trace in self.traces)),
        }

    def _finish_film(self) -> Kept:
        film = self.film
        if film is None:
            return {}
        film.finish()
        return {
            "video": str(film.file.path),
            "video_frames": film.file.frames,
            "video_bytes": film.file.bytes,
            "video_lacks": _lacks((film.missing, film.file.output)),
        }

    def _finish_recording(self, report: Summary) -> Kept:
        if self.recorder is None:
            return {}
        summary = report.as_dict()
        self.recorder.finish(summary, summary.get("robots", ()))
        kept: Kept = {}
        if self.recording is not None:
            file = self.recorder.file
            lacks = _lacks((self.recorder.missing, file.output))
            kept = {"recording": str(file.path), "recording_lacks": lacks}
        if self.page is not None:
            from bt_mission.cli.report import pages_of, write_page

            recording = self.recorder.file.path
            try:
                pages = pages_of(recording, self.page, None)
                for robot, page in pages.items():
                    write_page(recording, page, robot)
            except Exception as error:  # noqa: BLE001 - the run has ended, and is told of
                return kept | {"report_lacks": cause_of(error)}
            kept["report"] = ", ".join(map(str, pages.values()))
        return kept


def _lacks(*files: tuple[str, OutputFile]) -> str:
    """Say what closed files lack, and where an old one is still there."""
    return "; ".join(filter(None, (text for lacks, file in files for text in (lacks, file.remark))))


def told(kept: Kept) -> list[str]:
    """What was kept, for people, one line each; of the trace only what it lacks."""
    lines = []
    if kept.get("trace_lacks"):
        lines.append(_line(f"  trace in {kept['trace']}", kept["trace_lacks"]))
    if "video" in kept:
        size = f"{kept['video_frames']} frames, {int(kept['video_bytes']) / 1e6:.2f} MB"
        lines.append(_line(f"  filmed to {kept['video']} ({size})", kept["video_lacks"]))
    if "recording" in kept:
        lines.append(_line(f"  recorded to {kept['recording']}", kept["recording_lacks"]))
    if "report" in kept:
        lines.append(f"  report: {kept['report']}")
    if "report_lacks" in kept:
        lines.append(f"  no report: {kept['report_lacks']}")
    return lines


def _line(text: str, lacks: str | int) -> str:
    return f"{text}; it lacks {lacks}" if lacks else text
