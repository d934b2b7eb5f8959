"""Options of commands that keep a run in files: its trace, a recording, a page, a video."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from bt_mission.base.errors import cause_of
from bt_mission.cli.argument_types import FileType, output_file
from bt_mission.cli.options import FORCE
from bt_mission.cli.outputs import file_of_robot
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.base.output import OutputFile
    from bt_mission.cli.run_plan import Summary
    from bt_mission.commands.video.recorder import VideoRecorder
    from bt_mission.executive.trace import TraceFile
    from bt_mission.recording.writer import RunRecorder
    from bt_mission.sessions.session import Run, Session


Kept = dict[str, str | int]
"""The files of a run by name, for output as JSON."""


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
RECORDING_OPTIONS = (
    Option(
        "--trace FILE.jsonl", "write the events of the run to this file, as JSON lines", output_file
    ),
    Option(
        "--record FILE.mcap",
        "record the run: all topics, the tree, goals and feedback",
        FileType("output", (".mcap",), "recordings are MCAP files"),
        page="recording",
    ),
    Option(
        "--report FILE.html",
        "generate an HTML report of the run",
        FileType("output", (".html", ".htm"), "reports are HTML files"),
    ),
    Option(
        "--record-camera",
        "also record the camera's pictures, as JPEG (compressed, the default) or raw; a "
        "simulated camera then renders all the time, which slows the run down",
        choices=("compressed", "raw"),
        nargs="?",
        const="compressed",
        needs=each("record", "report"),
    ),
    Option(
        "--record-raw-actions",
        "use the ROS type names of goals and feedback (Turn_SendGoal_Event), which "
        "mcap-ros2-support and rosbags refuse",
        needs=each("record"),
    ),
    VIDEO,
    FORCE,
)
"""Where a run is kept, and what of it."""


@contextmanager
def recorder_for(options: argparse.Namespace, session: Session) -> Iterator[RunFiles]:
    """Save the run as the options ask: a recording, a page, a video, or nothing.

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


def _traces_of(path: Path | None, session: Session) -> Iterator[tuple[Run, Path]]:
    """Yield the runs of a session with the files of their traces: of several, one for each."""
    if path is not None:
        for run in session.runs:
            name = run.node.get_namespace().strip("/")
            yield run, path if len(session.runs) == 1 else file_of_robot(path, name)


@contextmanager
def _film_of(path: Path | None, session: Session) -> Iterator[VideoRecorder | None]:
    """A film of a session on the stage, to be finished; None where none is wanted."""
    from bt_mission.sessions.stage import Stage

    if path is None or not isinstance(session, Stage):
        yield None
        return
    from bt_mission.commands.video.mp4 import Mp4File
    from bt_mission.commands.video.recorder import ABOVE, AHEAD, FPS, HEIGHT, WIDTH, VideoRecorder
    from sim.views.views import WorldViews

    robot = session.runs[0].robot
    views = WorldViews(robot, above=ABOVE, ahead=AHEAD)
    zones = [(zone.name, zone.x, zone.y, zone.radius) for zone in robot.physics.world.zones]
    with VideoRecorder(session, views, Mp4File(path, WIDTH, HEIGHT, FPS), zones) as film:
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

    def is_incomplete(self, kept: Kept) -> bool:
        """Return whether a file that was asked for is cut, or was not written.

        A recording that only lacks topics is not one of these.
        """
        outputs = [trace.file for trace in self.traces]
        if self.film is not None:
            outputs.append(self.film.file.output)
        if self.recorder is not None and self.recording is not None:
            outputs.append(self.recorder.file.output)
        cut = (file.fault is not None or file.is_deleted or file.remark for file in outputs)
        return "report_lacks" in kept or any(cut)

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
            from bt_mission.views.web.report.page import write_report

            try:
                write_report(self.recorder.file.path, self.page)
            except Exception as error:  # noqa: BLE001 - the run has ended, and is told of
                return kept | {"report_lacks": cause_of(error)}
            kept["report"] = str(self.page)
        return kept


def _lacks(*files: tuple[str, OutputFile]) -> str:
    """Say what closed files lack, and where an old one is still there."""
    return "; ".join(filter(None, (text for lacks, file in files for text in (lacks, file.remark))))


def file_lines(kept: Kept) -> list[str]:
    """Return a line about each saved file, and about the trace only if it is incomplete."""
    lines = []
    if kept.get("trace_lacks"):
        lines.append(_line(f"  trace in {kept['trace']}", kept["trace_lacks"]))
    if "video" in kept:
        size = f"{kept['video_frames']} frames, {int(kept['video_bytes']) / 1e6:.2f} MB"
        lines.append(_line(f"  video saved to {kept['video']} ({size})", kept["video_lacks"]))
    if "recording" in kept:
        lines.append(_line(f"  recorded to {kept['recording']}", kept["recording_lacks"]))
    if "report" in kept:
        lines.append(f"  report: {kept['report']}")
    if "report_lacks" in kept:
        lines.append(f"  no report: {kept['report_lacks']}")
    return lines


def _line(text: str, lacks: str | int) -> str:
    return f"{text}; it lacks {lacks}" if lacks else text
