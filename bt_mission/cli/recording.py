"""Options of commands that keep a run in files: its trace, a recording, a page, and added ones."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.commands import added
from bt_mission.base.errors import cause_of
from bt_mission.cli.argument_types import FileType, output_file
from bt_mission.cli.extensions import Kept, RunFile, RunFileKind
from bt_mission.cli.options import FORCE
from bt_mission.cli.outputs import file_of_robot
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.base.output import OutputFile
    from bt_mission.cli.run_plan import Summary
    from bt_mission.executive.trace import TraceFile
    from bt_mission.recording.writer import RunRecorder
    from bt_mission.sessions.session import MissionRun, Session


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
    *(kind.option for kind in added("recording")),
    FORCE,
)
"""Where a run is kept, and what of it."""


@contextmanager
def recorder_for(options: argparse.Namespace, session: Session) -> Iterator[RunFiles]:
    """Save the run as the options ask, or nothing.

    Raises:
        BtMissionError: When a file cannot be written.
    """
    from bt_mission.executive.trace import TraceFile

    with ExitStack() as stack:
        traces = [
            stack.enter_context(TraceFile(run.runner.trace, path))
            for run, path in _traces_of(options.trace, session)
        ]
        others = [
            made
            for kind, path in _other_files(options)
            if (made := stack.enter_context(kind.open(path, session))) is not None
        ]
        path = options.record
        if path is None and options.report is not None:
            from tempfile import TemporaryDirectory

            path = Path(stack.enter_context(TemporaryDirectory())) / "run.mcap"
        if path is None:
            yield RunFiles(None, None, None, others, traces)
            return
        from bt_mission.recording.contents import RecordingOptions
        from bt_mission.recording.writer import RunRecorder

        wanted = RecordingOptions(
            camera=options.record_camera or "none", raw_actions=options.record_raw_actions
        )
        recorder = stack.enter_context(RunRecorder(session, path, wanted))
        yield RunFiles(recorder, options.record, options.report, others, traces)


def _traces_of(path: Path | None, session: Session) -> Iterator[tuple[MissionRun, Path]]:
    """Yield the runs of a session with the files of their traces: of several, one for each."""
    if path is not None:
        for run in session.runs:
            name = run.node.get_namespace().strip("/")
            yield run, path if len(session.runs) == 1 else file_of_robot(path, name)


def _other_files(options: argparse.Namespace) -> Iterator[tuple[RunFileKind, Path]]:
    """Yield the added kinds of files that are asked for, with their paths."""
    for kind in added("recording"):
        path = getattr(options, kind.option.attribute)
        if path is not None:
            yield kind, path


@dataclass(frozen=True)
class RunFiles:
    """A run on its way into files."""

    recorder: RunRecorder | None
    recording: Path | None
    page: Path | None
    others: Sequence[RunFile] = ()
    traces: Sequence[TraceFile] = ()

    def finish(self, report: Summary) -> Kept:
        """Close all files, and make the page; gives what is to be said of them, by name."""
        kept = self._finish_traces()
        for made in self.others:
            kept |= made.finish()
        return kept | self._finish_recording(report)

    def is_incomplete(self, kept: Kept) -> bool:
        """Return whether a file that was asked for is cut, or was not written.

        A recording that only lacks topics is not one of these.
        """
        outputs = [trace.file for trace in self.traces]
        outputs += [made.output for made in self.others]
        if self.recorder is not None and self.recording is not None:
            outputs.append(self.recorder.file.output)
        cut = (file.write_error is not None or file.is_deleted or file.remark for file in outputs)
        return "report_lacks" in kept or any(cut)

    def _finish_traces(self) -> Kept:
        for trace in self.traces:
            trace.close()
        if not self.traces:
            return {}
        return {
            "trace": ", ".join(str(trace.file.place) for trace in self.traces),
            "trace_lacks": lacks(*((trace.missing, trace.file) for trace in self.traces)),
        }

    def _finish_recording(self, report: Summary) -> Kept:
        if self.recorder is None:
            return {}
        summary = report.as_dict()
        self.recorder.finish(summary, summary.get("robots", ()))
        kept: Kept = {}
        if self.recording is not None:
            file = self.recorder.file
            missing = lacks((self.recorder.missing, file.output))
            kept = {"recording": str(file.path), "recording_lacks": missing}
        if self.page is not None:
            from bt_mission.views.web.report.page import write_report

            try:
                write_report(self.recorder.file.path, self.page)
            except Exception as error:  # noqa: BLE001 - the run has ended, and is told of
                return kept | {"report_lacks": cause_of(error)}
            kept["report"] = str(self.page)
        return kept


def lacks(*files: tuple[str, OutputFile]) -> str:
    """Say what closed files lack, and where an old one is still there."""
    return "; ".join(filter(None, (text for lacks, file in files for text in (lacks, file.remark))))


def file_lines(kept: Kept) -> list[str]:
    """Return a line about each saved file, and about the trace only if it is incomplete."""
    lines = []
    if kept.get("trace_lacks"):
        lines.append(file_line(f"  trace in {kept['trace']}", kept["trace_lacks"]))
    lines += [line for kind in added("recording") for line in kind.lines(kept)]
    if "recording" in kept:
        lines.append(file_line(f"  recorded to {kept['recording']}", kept["recording_lacks"]))
    if "report" in kept:
        lines.append(f"  report: {kept['report']}")
    if "report_lacks" in kept:
        lines.append(f"  no report: {kept['report_lacks']}")
    return lines


def file_line(text: str, lacks: str | int) -> str:
    """Return a line about a file, with what it lacks."""
    return f"{text}; it lacks {lacks}" if lacks else text
