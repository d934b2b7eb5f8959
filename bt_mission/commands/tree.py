"""``bt-mission tree``: a mission's tree as text or as a picture."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, MISSION, SET, mission_file, write_output
from bt_mission.cli.outputs import files_of, refuse_overwritten
from bt_mission.cli.parser import Command, Option

FORMATS = ("text", "dot", "svg", "png")

_RICH = {"FORCE_COLOR", "TTY_COMPATIBLE"}
"""Variables by which Rich takes a file for a terminal."""

EPILOG = """\
examples:
  bt-mission tree missions/explore.yaml
  bt-mission tree missions/explore.yaml -o explore.svg
  bt-mission tree missions/explore.yaml --format dot | dot -Tpdf > explore.pdf
"""


def tree(options: argparse.Namespace) -> int:
    """Show the tree."""
    from bt_mission.sessions.load import load
    from bt_mission.views.drawing.nodes import drawn, heading

    form = _format(options)
    mission = load(mission_file(options), set=dict(options.set))
    refuse_overwritten(options, files_of(mission))
    root, title = drawn(mission), heading(mission)
    if options.output is None and form == "text":
        _print(root, title)
    else:
        _write(_made(form, root, title), options.output)
    return SUCCESS


def _format(options: argparse.Namespace) -> str:
    """The format that is wanted.

    Raises:
        BtMissionError: When the output's suffix tells of none.
    """
    if options.format:
        return str(options.format)
    if options.output is None:
        return "text"
    suffix = options.output.suffix.removeprefix(".").replace("txt", "text")
    if suffix not in FORMATS:
        raise BtMissionError(
            f"{options.output}: unknown suffix; use .txt, .dot, .svg or .png, or choose a format "
            f"with --format",
            code="BT-1103",
        )
    return str(suffix)


def _made(form: str, root: Any, title: str) -> bytes:
    if form == "png":
        from bt_mission.views.drawing.png import png
        from bt_mission.views.drawing.scene import scene

        return png(scene(root, title))
    if form == "svg":
        from bt_mission.views.drawing.scene import scene
        from bt_mission.views.drawing.svg import svg

        return svg(scene(root, title)).encode()
    if form == "dot":
        from bt_mission.views.drawing.dot import dot

        return dot(root, title).encode()
    from bt_mission.views.drawing.nodes import legend, outline

    rows = [title, *map(str, outline(root)), "", legend(root)]
    return "".join(f"{row}\n" for row in rows).encode()


def _write(content: bytes, output: Path | None) -> None:
    if output is None:
        if content.startswith(b"\x89PNG") and sys.stdout.isatty():
            raise BtMissionError(
                "a terminal cannot show PNG; write it to a file with -o", code="BT-1103"
            )
        sys.stdout.flush()
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    write_output(output, content)


def _print(root: Any, title: str) -> None:
    """As text; on a terminal in colour, each node on one line."""
    from bt_mission.views.drawing.nodes import can_show, legend, outline

    ascii_only = not can_show(sys.stdout.encoding)
    rows, signs = [*outline(root, ascii_only=ascii_only)], legend(root, ascii_only=ascii_only)
    if sys.stdout.isatty() or not _RICH.isdisjoint(os.environ):
        _print_coloured(rows, title, signs)
    else:
        print("\n".join([title, *map(str, rows), "", signs]))


def _print_coloured(rows: Iterable[Any], title: str, signs: str) -> None:
    from rich.text import Text

    from bt_mission.views.drawing.scene import COLOURS
    from bt_mission.views.terminal.console import EscapingConsole

    lines = [Text(title, style="bold")]
    for row in rows:
        line = Text(row.branches, style="dim")
        line.append(f"{row.sign} ", style=f"bold {COLOURS[row.family][1]}")
        line.append(row.name, style="bold")
        line.append(f"  {row.details}" if row.details else "", style="dim")
        lines.append(line)
    lines += [Text(""), Text(signs, style="dim")]
    console = EscapingConsole(sys.stdout)
    for line in lines:
        if console.is_terminal:
            console.print(line, overflow="ellipsis", no_wrap=True)
        else:
            print(line.plain)


COMMANDS = {
    "tree": Command(
        tree,
        "Shows the tree of a mission with its subtrees expanded. Needs neither ROS nor Graphviz.",
        (
            MISSION.but(completes="missions"),
            SET,
            Option(
                "--format",
                "format (default: by the suffix of the output file, else text)",
                choices=FORMATS,
            ),
            Option("-o --output OUTPUT", "file to write (default: standard output)", output_file),
            FORCE,
        ),
        EPILOG,
    )
}
