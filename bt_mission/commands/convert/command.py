"""``bt-mission convert``: missions from YAML to the XML that Groot 2 edits, and back."""

from __future__ import annotations

import argparse

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import MISSIONS
from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, MISSION, mission_file, write_output
from bt_mission.cli.outputs import refuse_overwritten
from bt_mission.cli.parser import Command, Option

DESCRIPTION = """\
Converts a mission from YAML to XML in the format of BehaviorTree.CPP 4, which Groot 2 shows and
edits, or from XML to YAML. The suffix of the file decides: .yaml, .yml or .xml.

Parts without a counterpart in the other format are errors, each with its line, its column and what
to write instead. All are reported at once, and no file is written. Only comments are dropped.
`run` and `check` also accept XML files.
"""
EPILOG = """\
examples:
  bt-mission convert missions/explore.yaml -o explore.xml   for Groot 2
  bt-mission convert explore.xml -o explore.yaml            back, after editing in Groot 2
  bt-mission convert explore.xml                            to the terminal
  bt-mission convert --palette -o leaves.xml                all leaves, for the palette of Groot 2
  bt-mission convert --palette tour.yaml -o leaves.xml      only the ports that this mission uses
  bt-mission check explore.xml                              without converting

A leaf is an element. Its name is the kind, its attributes are the ports; {name} is $name:
  <turn angle="{step}" timeout="30" out_angle_turned="{turned}"/>
"""


def convert(options: argparse.Namespace) -> int:
    """Write the other form of a file."""
    from bt_mission.base.file_index import files_of

    if options.file is None and not options.palette:
        raise BtMissionError("expected the file of a mission, or --palette", code="BT-1101")
    file = options.file and mission_file(options)
    from bt_mission.commands.convert.xml_format import palette
    from bt_mission.sessions.load import convert as converted

    text = palette(file) if options.palette or file is None else converted(file)
    if options.output is None:
        print(text, end="")
    else:
        refuse_overwritten(options, [] if file is None else files_of(file))
        write_output(options.output, text.encode())
        if options.output.suffix != ".xml":
            print(f"next: bt-mission check {options.output}")
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
                takes=MISSIONS,
            ),
            Option("-o --output OUTPUT", "file to write (default: standard output)", output_file),
            FORCE,
            Option(
                "--palette",
                "write the models of all leaves for Groot 2, with the ports that FILE uses if it "
                "is given",
            ),
        ),
        EPILOG,
    )
}
