"""The rule for files that a command writes, whatever its options are called.

An option declares its file by a :class:`~bt_mission.cli.argument_types.FileType`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import FileType

if TYPE_CHECKING:
    from bt_mission.base.files import Kind
    from bt_mission.language.mission import Mission

OUTPUTS = ("output", "unchecked output")
STANDARD_OUTPUT = "-"


def refuse_outputs(options: argparse.Namespace) -> None:
    """Refuse files that a command is to write and cannot, or must not, before anything runs.

    A name with another suffix than the option's is refused, two outputs in one file, and an output
    that is an input; so is a file that exists, unless the command has no ``--force``, or it is
    given. A device or a pipe takes anything.

    Raises:
        BtMissionError: With the option, and what to do.
    """
    taken: dict[object, str] = {}
    for name, path in _files(options, "output"):
        _refuse_place(name, path)
    for name, path in _files(options, *OUTPUTS):
        other = taken.setdefault(_identity(path), name)
        if other != name:
            raise BtMissionError(
                f"{other} and {name} name the same file, {path}; use two files", code="BT-1103"
            )
    for name, kind, path in _given(options):
        _refuse_suffix(name, kind, path)
    for name, path in _files(options, "input"):
        _refuse_input(taken, path, f"is the file that {name} names")
    if not getattr(options, "force", True):
        refuse_existing(path for _, path in _files(options, "output"))


def refuse_overwritten(options: argparse.Namespace, inputs: Iterable[Path]) -> None:
    """Refuse to write over a file that is read, although no option names it.

    Raises:
        BtMissionError: With the option.
    """
    taken = {_identity(path): name for name, path in _files(options, *OUTPUTS)}
    for path in inputs if taken else ():
        _refuse_input(taken, path, "is read for this run")


def files_of(mission: Mission) -> Iterator[Path]:
    """Yield the files of a mission, with those of its world, its robot and its Python code."""
    from bt_mission.base.files import look_for
    from bt_mission.scenarios.concrete.bundle import python_files

    yield from (Path(document.file) for document in mission.documents)
    yield from (path for path, _ in python_files(mission))
    named: dict[Kind, str | None] = {"worlds": mission.world, "robots": mission.robot}
    for kind, name in named.items():
        named_file = look_for(kind, name, mission.file) if name else None
        if named_file is not None:
            yield named_file


def refuse_existing(paths: Iterable[Path]) -> None:
    """Refuse to overwrite files; devices are no files.

    Raises:
        BtMissionError: When one of them exists.
    """
    for path in paths:
        if path.is_file():
            raise BtMissionError(
                f"{path} exists; give another name, or --force to overwrite it", code="BT-1103"
            )


def refuse_used_folder(folder: Path, *, is_forced: bool = False) -> None:
    """Refuse a folder for results that holds something already; if forced, only a file.

    Raises:
        BtMissionError: It is a file, or not empty.
    """
    if folder.exists() and not folder.is_dir():
        raise BtMissionError(f"{folder}: is a file; name a folder with -o", code="BT-1103")
    if not is_forced and folder.is_dir() and any(folder.iterdir()):
        raise BtMissionError(
            f"{folder}: the folder is not empty; name another with -o", code="BT-1103"
        )


def file_of_robot(path: Path, robot: str) -> Path:
    """Return the file of one robot of several: ``two.jsonl`` is ``two.robot1.jsonl``."""
    return path.with_name(f"{path.stem}.{robot}{path.suffix}")


def _given(options: argparse.Namespace) -> Iterator[tuple[str, FileType, Path]]:
    """Yield the files that are given, each with the name of its option and its type."""
    for option in options.parser.options:
        if isinstance(option.type, FileType):
            given = getattr(options, option.attribute, None)
            for path in given if isinstance(given, list) else filter(None, [given]):
                yield option.name, option.type, path


def _files(options: argparse.Namespace, *roles: str) -> Iterator[tuple[str, Path]]:
    """Yield the files of these roles that are given, without devices and pipes."""
    for name, kind, path in _given(options):
        if kind.role in roles and not _is_special(path):
            yield name, path


def _refuse_suffix(name: str, kind: FileType, path: Path) -> None:
    if path.is_dir() or (kind.takes_devices and _is_special(path)):
        return
    if kind.suffixes and path.suffix.lower() not in kind.suffixes:
        raise BtMissionError(
            f"{name}: {kind.what}, call it {path.stem}{kind.suffixes[0]}", code="BT-1103"
        )


def _is_special(path: Path) -> bool:
    """Is it no file, and no place for one: the standard output, a device, a pipe?"""
    return str(path) == STANDARD_OUTPUT or (path.exists() and not (path.is_file() or path.is_dir()))


def _identity(path: Path) -> object:
    """What two names of one file have in common, links included."""
    try:
        about = path.stat()
    except OSError:
        return path.resolve()
    return about.st_dev, about.st_ino


def _refuse_place(name: str, path: Path) -> None:
    """Refuse a folder, and a file whose folder takes none."""
    folder = path.resolve().parent
    if path.is_dir():
        raise BtMissionError(f"{name} {path}: is a folder; give a file", code="BT-1103")
    if not folder.is_dir():
        raise BtMissionError(
            f"{name} {path}: the folder {path.parent} does not exist", code="BT-1103"
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise BtMissionError(f"{name} {path}: the folder {folder} is not writable", code="BT-1103")


def _refuse_input(taken: dict[object, str], path: Path, why: str) -> None:
    output = taken.get(_identity(path))
    if output is not None:
        raise BtMissionError(f"{output} {path}: {why}; choose another file", code="BT-1103")
