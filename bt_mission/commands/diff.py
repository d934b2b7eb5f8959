"""``bt-mission diff``: the first difference between two runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import input_file
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.options import JSON
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.executive.stored_trace import StoredTrace


def compare(options: argparse.Namespace) -> int:
    """Print the difference; gives the exit code."""
    from bt_mission.executive.trace_diff import first_difference

    first, second = _trace_of(options.first), _trace_of(options.second)
    difference = first_difference(first, second)
    if options.json:
        print(json.dumps(difference and asdict(difference)))
    else:
        for trace in (first, second):
            if trace.is_cut:
                print(f"{trace.file}: its last line is incomplete and was ignored")
        if difference is None:
            count = len(first.events)
            print(f"the same {count} events at the same times (sha256 {first.sha256[:16]})")
        else:
            print(f"< {options.first}\n> {options.second}\n{difference}")
    return SUCCESS if difference is None else MISSION_FAILED


def _trace_of(path: Path) -> StoredTrace:
    """Return a trace, also that of a recording.

    Raises:
        BtMissionError: It is neither, or a recording without a trace.
    """
    from bt_mission.executive.stored_trace import read_trace, trace_of
    from bt_mission.recording.reading import is_recording
    from bt_mission.recording.replay.timeline import read_timeline

    if not is_recording(path):
        return read_trace(path)
    trace = read_timeline(path, None).trace
    if not trace:
        raise BtMissionError(f"{path}: the recording has no trace", code="BT-1002")
    return trace_of(str(path), trace)


_TRACE = Option("trace", "", input_file, takes=("trace", "recording"))

COMMANDS = {
    "diff": Command(
        compare,
        "Compares two traces of `bt-mission run --trace FILE`, or those of two recordings, and "
        "shows the first difference: the last equal events, the next events of each trace, and "
        "how much their numbers differ.",
        (
            _TRACE.but(form="first", help="first trace, or a recording"),
            _TRACE.but(form="second", help="second trace, or a recording"),
            JSON.but(help="print one JSON object, or null if the traces are equal"),
        ),
        "exit codes: 0 equal, 1 different, 2 bad input",
    )
}
