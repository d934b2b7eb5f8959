"""``bt-mission report``: a recorded run as one page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import add_force_option, refuse_existing


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "report",
        description="Makes one HTML page of a recording: outcome and reason, requirements with "
        "their margins against time, a timeline of every node, the robot's way over the map, "
        "figures against time, goals, pictures, the log and the mission's file. The page needs no "
        "network and no other file.",
        epilog="exit codes: 0 success, 2 no such file, or not a recorded run",
    )
    parser.add_argument("file", type=Path, help="made by bt-mission run --record")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE.html",
        help="the page (default: beside the recording, with its name)",
    )
    add_force_option(parser)
    parser.set_defaults(command=report)


def report(options: argparse.Namespace) -> int:
    """Make the page; gives the exit code."""
    output = options.output or options.file.with_suffix(".html")
    refuse_existing(options, output)
    write_page(options.file, output)
    print(output)
    return SUCCESS


def write_page(recording: Path, output: Path) -> None:
    """Make a page of a recording.

    Raises:
        BtMissionError: For a file that holds no run, and one that cannot be written.
    """
    from bt_mission.core.errors import BtMissionError
    from bt_mission.recording.verification import read_verified_run
    from bt_mission.views.html_report.page import page_of

    page = page_of(read_verified_run(recording))
    try:
        output.write_text(page, encoding="utf-8", errors="replace")
    except OSError as error:
        raise BtMissionError(f"{output}: cannot write the report: {error.strerror}") from error
