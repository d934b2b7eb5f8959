"""``bt-mission convert``: missions from YAML to the XML that Groot 2 edits, and back."""

from __future__ import annotations

import argparse

from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, MISSION, mission_file, write_output
from bt_mission.cli.outputs import refuse_overwritten
from bt_mission.cli.parser import Command, Option
from bt_mission.core.errors import BtMissionError

DESCRIPTION = """\
Turns a mission in YAML into XML in the format of BehaviorTree.CPP 4, which Groot 2 shows and
edits, and XML into YAML. The file's suffix tells which: .yaml, .yml or .xml.

What the other side cannot say is an error, with its line, its column and what to write instead;
nothing is left out silently, comments apart. All such places are shown at once, and nothing is
written then. 'run' and 'check' take XML files as they are.
"""
EPILOG = """\
examples:
  bt-mission convert missions/explore.yaml -o explore.xml   for Groot 2
  bt-mission convert explore.xml -o explore.yaml            back, as Groot 2 has left it
  bt-mission convert explore.xml                            to the terminal
  bt-mission convert --palette -o leaves.xml                all our leaves, for Groot 2's palette
  bt-mission convert --palette tour.yaml -o leaves.xml      with the ports that a mission uses
  bt-mission check explore.xml                              without converting

A leaf is an element with its kind as name and its ports as attributes; {name} is $name:
  <turn angle="{step}" timeout="30" out_angle_turned="{turned}"/>
"""


def convert(options: argparse.Namespace) -> int:
    """Write the other form of a file."""
    from bt_mission.core.file_index import files_of

    if options.file is None and not options.palette:
        raise BtMissionError("expected the file of a mission, or --palette")
    file = options.file and mission_file(options)
    from bt_mission.sessions import load

    text = load.palette(file) if options.palette or file is None else load.convert(file)
    if options.output is None:
        print(text, end="")
    else:
        refuse_overwritten(options, [] if file is None else files_of(file))
        write_output(options.output, text.encode())
    return SUCCESS


COMMANDS = {
    "convert": Command(
        convert,
        DESCRIPTION,
        (
            MISSION.but(
                help="the mission: a YAML or an XML file, or the name of a shipped one",
                nargs="?",
                completes="missions",
            ),
            Option(
                "-o --output OUTPUT", "the file to write (default: standard output)", output_file
            ),
            FORCE,
            Option(
                "--palette",
                "the models of all leaves, for Groot 2, with the ports that FILE uses, if it is "
                "given",
            ),
        ),
        EPILOG,
    )
}
