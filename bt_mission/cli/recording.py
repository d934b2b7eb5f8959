"""Options of commands that record a run, and what they do."""

from __future__ import annotations

import argparse
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.common.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.observing import Observable
    from bt_mission.recording.recorder import Recorder
    from bt_mission.report import Report


def add_recording_options(parser: argparse.ArgumentParser) -> None:
    """Where a run is recorded, and what of it."""
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE.mcap",
        help="record the run: every topic, the tree, goals and feedback (docs/recording.md)",
    )
    parser.add_argument(
        "--record-camera",
        choices=("compressed", "raw"),
        nargs="?",
        const="compressed",
        help="with --record: the camera's pictures too, as JPEGs or as they are; a simulated "
        "camera then draws all the time, which takes long",
    )


def refuse_recording(options: argparse.Namespace) -> None:
    """Refuse options that contradict each other.

    :raises BtMissionError: with what to do instead.
    """
    if options.record_camera and not options.record:
        raise BtMissionError("--record-camera: name the file to record to with --record FILE.mcap")


def recorder_for(
    options: argparse.Namespace, session: Observable
) -> AbstractContextManager[Recorder | None]:
    """The recorder that the options ask for, if any.

    :raises BtMissionError: when its file cannot be written.
    """
    if options.record is None:
        return nullcontext()
    from bt_mission.recording.options import RecordingOptions
    from bt_mission.recording.recorder import Recorder

    return Recorder(
        session, options.record, RecordingOptions(camera=options.record_camera or "none")
    )


def finish(recorder: Recorder | None, report: Report) -> dict[str, str]:
    """End a recording; gives what is to be said about it, by name, for programs."""
    if recorder is None:
        return {}
    recorder.finish(report.as_dict())
    return {"recording": str(recorder.file.path), "recording_lacks": recorder.missing}


def told(kept: dict[str, str]) -> list[str]:
    """The same for people, one line each."""
    if not kept:
        return []
    lacks = kept["recording_lacks"]
    return [f"  recorded to {kept['recording']}" + (f"; it lacks {lacks}" if lacks else "")]
