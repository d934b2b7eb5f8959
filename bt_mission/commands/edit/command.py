"""``bt-mission edit``: write, check, draw, run and prove missions in a browser."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import PARAMETERS, PLAIN, RUNS
from bt_mission.base.files import SUFFIXES
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.parser import Command, Option
from bt_mission.cli.web import announced, page_options, place_of, require_server

EDITS = "change the files of the folder and run missions with your permissions"

EPILOG = """\
examples:
  bt-mission edit missions/explore.yaml --open    one file
  bt-mission edit                                 all YAML files of this folder
  bt-mission edit tour.yaml                       a new file, written with the first save

exit codes: 0 after Ctrl-C, 2 bad input
"""


def edit(options: argparse.Namespace) -> int:
    """Serve the editor until Ctrl-C."""
    path: Path = options.file
    if path.suffix in SUFFIXES:
        if not path.parent.is_dir():
            raise BtMissionError(f"{path}: the folder {path.parent} does not exist", code="BT-101")
    elif not path.is_dir():
        what = ", ".join(SUFFIXES)
        message = f"{path}: expected a folder, or a file with the suffix {what}"
        raise BtMissionError(message, code="BT-101")
    import asyncio

    from bt_mission.base.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.commands.edit.vocabulary import kinds
    from bt_mission.commands.edit.web.server import EditServer
    from bt_mission.commands.edit.web.workspace import Workspace

    print("reading the types of all actions ...", file=sys.stderr)
    kinds()

    what = "read the files of the folder" if options.read_only else EDITS
    with InterruptSignals() as leaving:
        server = EditServer(Workspace(path), place_of(options), keeps_ready=True)
        with announced(options, server, what):
            asyncio.run(server.serve(lambda: leaving.count > 0))
    return SUCCESS


COMMANDS = {
    "edit": Command(
        edit,
        "Serves an editor for missions on a page of this machine: the text, the tree as a drawing, "
        "and runs on the stage. Every change in the drawing is a change of the text, and of no "
        "other line. Unsaved text is kept beside its file, as .NAME.PAGE.unsaved.",
        (
            Option(
                "file",
                "a YAML file, also a new one, or a folder (default: this folder)",
                type=Path,
                takes=(*RUNS, *PLAIN, *PARAMETERS, "site"),
                nargs="?",
                default=Path(),
                check=partial(require_server, "bt-mission edit"),
            ),
            *page_options("the page cannot save, run or prove"),
        ),
        EPILOG,
    )
}
