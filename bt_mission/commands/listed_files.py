"""``bt-mission missions``, ``worlds`` and ``robots``: what there is, and copies of it to edit."""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import RUNS
from bt_mission.base.files import SUFFIXES, Kind, contents_of
from bt_mission.base.text import columns
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, JSON, write_output
from bt_mission.cli.outputs import refuse_existing
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.base.file_index import ListedFile

EPILOG = """\
examples:
  bt-mission {kind}                       local and shipped files
  bt-mission {kind} copy {name:17}./{kind}/{name}.yaml, to edit
  bt-mission {kind} copy {name} mine.yaml

A file in ./{kind} replaces the shipped one of the same name.
"""
_TAKES = {"missions": RUNS, "worlds": ("world",), "robots": ("robot",)}
EXAMPLES = {"missions": "explore", "worlds": "empty_arena", "robots": "waffle"}


def print_list(kind: Kind, options: argparse.Namespace) -> int:
    """Print what there is of a kind: a table, or a list of objects."""
    from bt_mission.base.file_index import list_files

    listed_files = list_files(kind)
    if options.json:
        print(json.dumps([_as_object(listed_file) for listed_file in listed_files]))
        return SUCCESS
    if not listed_files:
        print(f"no {kind} here, and the shipped ones are missing: is the installation complete?")
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for line in (
        columns(_as_row(listed_file) for listed_file in listed_files) if listed_files else []
    ):
        print(line if width is None or len(line) <= width else f"{line[: width - 3].rstrip()}...")
    return SUCCESS


def _as_row(listed_file: ListedFile) -> Sequence[str]:
    from bt_mission.base.file_index import first_sentence

    return (
        listed_file.name,
        "shipped" if listed_file.is_shipped else "here",
        first_sentence(listed_file.description),
    )


def _as_object(listed_file: ListedFile) -> Mapping[str, object]:
    return {
        "name": listed_file.name,
        "kind": listed_file.what,
        "description": listed_file.description,
        "shipped": listed_file.is_shipped,
        "path": str(listed_file.path.absolute()),
    }


def copy_file(kind: Kind, options: argparse.Namespace) -> int:
    """Copy a file, with those that it names; nothing is written where one of them exists."""
    from bt_mission.base.file_index import files_of, find_listed

    chosen = find_listed(kind, options.name)
    wanted = Path(kind) if options.to is None else Path(options.to)
    copies = _copies(chosen.path, files_of(chosen.path), wanted)
    for source, target in copies.items():
        if target.exists() and target.samefile(source):
            raise BtMissionError(
                f"{target} is the same file; give another name or folder", code="BT-1103"
            )
    if not options.force:
        refuse_existing(copies.values())
    contents = {target: _read(source) for source, target in copies.items()}
    for target, content in contents.items():
        _make_folder(target.parent)
        write_output(target, content)
    return SUCCESS


def _copies(main: Path, sources: Sequence[Path], wanted: Path) -> Mapping[Path, Path]:
    """Map each file to its copy: they lie to each other as they did.

    Raises:
        BtMissionError: For a place that is neither a folder nor a YAML file, or too narrow.
    """
    # Links are kept: a file lies where it is named, wherever its text is.
    absolute = {source: Path(os.path.abspath(source)) for source in sources}  # noqa: PTH100 - no links followed
    if wanted.is_dir() or not wanted.suffix:
        root = Path(os.path.commonpath([source_path.parent for source_path in absolute.values()]))
        return {source: wanted / path.relative_to(root) for source, path in absolute.items()}
    if wanted.suffix not in SUFFIXES:
        raise BtMissionError(
            f"{wanted}: expected a folder, or a file that ends with .yaml", code="BT-1103"
        )
    root = absolute[main].parent
    outside = [source for source, path in absolute.items() if not path.is_relative_to(root)]
    if outside:
        raise BtMissionError(
            f"{main.name} names {outside[0].name} in another folder, which is also copied: give "
            f"a folder instead of a file",
            code="BT-1103",
        )
    inside = {source: wanted.parent / path.relative_to(root) for source, path in absolute.items()}
    copies = inside | {main: wanted}
    same = next((copied for copied in copies if copied != main and copies[copied] == wanted), None)
    if same is not None:
        raise BtMissionError(
            f"{main.name} names {same.name}, which is also copied: give another file or a folder",
            code="BT-1103",
        )
    return copies


def _read(path: Path) -> bytes:
    try:
        return contents_of(path)
    except OSError as error:
        raise BtMissionError(
            f"cannot read {path}: {error.strerror or error}", code="BT-101"
        ) from error


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BtMissionError(
            f"cannot create {path}: {error.strerror or error}", code="BT-1103"
        ) from error


def _command(kind: Kind, completes: str) -> Command:
    json_list = JSON.but(help="print a JSON list of objects")
    copying = Command(
        partial(copy_file, kind),
        f"Copies one of the {kind} for editing, with the files that it refers to: included "
        f"trees, the mission of a scenario, Python leaves.",
        (
            Option(
                "name",
                f"its name, as listed by `bt-mission {kind}`, or its path",
                completes=completes,
                takes=_TAKES[kind],
            ),
            Option("to", f"folder, or file to write (default: ./{kind})", Path, nargs="?"),
            FORCE,
        ),
        help="copy one, with the files that it refers to",
    )
    listing = Command(
        partial(print_list, kind),
        options=(json_list.but(default=argparse.SUPPRESS),),
        help="list them (the default)",
    )
    return Command(
        partial(print_list, kind),
        f"Lists the {kind} in the working folder and the shipped ones, or copies one.",
        (json_list,),
        EPILOG.format(kind=kind, name=EXAMPLES[kind]),
        commands={"list": listing, "copy": copying},
    )


COMMANDS = {
    "missions": _command("missions", "listed"),
    "worlds": _command("worlds", "worlds"),
    "robots": _command("robots", "robots"),
}
