"""``bt-mission diff``: the first difference between two runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.options import JSON
from bt_mission.cli.parser import Command, Option


def compare(options: argparse.Namespace) -> int:
    """Print the difference; gives the exit code."""
    from bt_mission.executive.stored_trace import read_trace
    from bt_mission.executive.trace_diff import first_difference

    first, second = read_trace(options.first), read_trace(options.second)
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


COMMANDS = {
    "diff": Command(
        compare,
        "Compares two traces of `bt-mission run --trace FILE` and shows the first difference: "
        "the last equal events, the next events of each trace, and how much their numbers differ.",
        (
            Option("first", "first trace", Path),
            Option("second", "second trace", Path),
            JSON.but(help="print one JSON object, or null if the traces are equal"),
        ),
        "exit codes: 0 equal, 1 different, 2 bad input",
    )
}
