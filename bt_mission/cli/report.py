"""``bt-mission report``: a recorded run as one page."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, RECORDING, recorded_robot
from bt_mission.cli.outputs import file_of_robot, refuse_existing
from bt_mission.cli.parser import Command, Option


def report(options: argparse.Namespace) -> int:
    """Make the page; gives the exit code."""
    output = options.output or options.file.with_suffix(".html")
    pages = pages_of(options.file, output, options.robot)
    if not options.force:
        refuse_existing(pages.values())
    for robot, page in pages.items():
        write_page(options.file, page, robot)
        print(page)
    return SUCCESS


def pages_of(recording: Path, output: Path, robot: str | None) -> dict[str | None, Path]:
    """Return the page of each robot of a recording: of several, each has its name in the file's."""
    from bt_mission.recording.robots import recorded_robots

    robots = recorded_robots(recording) if robot is None else []
    if len(robots) < 2:
        return {robot: output}
    return {one: file_of_robot(output, one) for one in robots}


def write_page(recording: Path, output: Path, robot: str | None = None) -> None:
    """Make a page of a recording, of one robot in it.

    Raises:
        BtMissionError: For a file that holds no run, and one that cannot be written.
    """
    from bt_mission.core.output import write_file
    from bt_mission.recording.verification import read_verified_run
    from bt_mission.views.html_report.page import page_of

    write_file(output, page_of(read_verified_run(recording, robot)))


COMMANDS = {
    "report": Command(
        report,
        "Makes one HTML page of a recording: outcome and reason, requirements with their margins "
        "against time, a timeline of every node, the robot's way over the map, figures against "
        "time, goals, pictures, the log and the mission's file. The page needs no network and no "
        "other file.",
        (
            RECORDING,
            Option(
                "-o --output FILE.html",
                "the page (default: beside the recording, with its name)",
                output_file,
            ),
            recorded_robot("a page for each, with its name in the file's"),
            FORCE,
        ),
        "exit codes: 0 success, 2 no such file, or not a recorded run",
    )
}
