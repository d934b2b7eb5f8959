"""``bt-mission report``: a recorded run as one page."""

from __future__ import annotations

import argparse

from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, RECORDING, recorded_robot
from bt_mission.cli.outputs import refuse_existing
from bt_mission.cli.parser import Command, Option


def report(options: argparse.Namespace) -> int:
    """Make the page; gives the exit code."""
    from bt_mission.views.web.report.page import write_report

    output = options.output or options.file.with_suffix(".html")
    if not options.force:
        refuse_existing([output])
    write_report(options.file, output, options.robot)
    print(output)
    return SUCCESS


COMMANDS = {
    "report": Command(
        report,
        "Generates one HTML page of a recording, which plays the run in the browser: the tree, the "
        "log, the map, variables and goals at any instant; outcome and reason, requirements with "
        "their margins against time, a timeline of every node, figures against time, pictures and "
        "the mission's file. The page needs no network and no other file.",
        (
            RECORDING,
            Option(
                "-o --output FILE.html",
                "the page (default: beside the recording, with its name)",
                output_file,
            ),
            recorded_robot("all; the page offers a choice"),
            FORCE,
        ),
        "exit codes: 0 success, 2 no such file, or not a recorded run",
    )
}
