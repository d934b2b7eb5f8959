"""``bt-mission report``: a recorded run as one page, or as a picture of its path."""

from __future__ import annotations

import argparse

from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, RECORDING, recorded_robot
from bt_mission.cli.outputs import refuse_existing
from bt_mission.cli.parser import Command, Option


def report(options: argparse.Namespace) -> int:
    """Make the page, or the picture; gives the exit code."""
    output = options.output or options.file.parent / f"{options.file.stem}.html"
    if not options.force:
        refuse_existing([output])
    if output.suffix == ".png":
        from bt_mission.base.output import write_file
        from bt_mission.recording.replay.timeline import read_timeline
        from bt_mission.views.drawing.path import path_png

        write_file(output, path_png(read_timeline(options.file, options.robot)))
    else:
        from bt_mission.views.web.report.page import write_report

        write_report(options.file, output, options.robot)
    print(output)
    return SUCCESS


COMMANDS = {
    "report": Command(
        report,
        "Generates an HTML report of a recording. It plays the run in the browser and shows the "
        "tree, log, map, variables and goals at any instant, the outcome and its reason, the "
        "margins of requirements over time, a timeline of all nodes, charts, pictures and the "
        "mission file. The report needs no network and no other file. With -o FILE.png the command "
        "draws the path over the map instead, with the verdicts of the requirements.",
        (
            RECORDING,
            Option(
                "-o --output FILE",
                "file to write: .png for a picture, else HTML (default: the name of the recording "
                "with .html)",
                output_file,
            ),
            recorded_robot("all, with a choice on the page"),
            FORCE,
        ),
        "exit codes: 0 success, 2 not a readable recording",
    )
}
