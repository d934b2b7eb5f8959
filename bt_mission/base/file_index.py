"""The list of missions, worlds and robots, each with a description, and the files of one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, listed
from bt_mission.base.files import (
    SUFFIXES,
    Kind,
    contents_of,
    folders,
    is_file,
    kind_of,
    look_for,
    shipped_folders,
    text_to_look_at,
)
from bt_mission.base.user_files import files_beside
from bt_mission.base.yaml.document import read

LISTED: tuple[Kind, ...] = ("missions", "worlds", "robots")
"""The kinds of which there are lists."""

_MARKS = {
    "missions": re.compile(r"^(mission|scenario|fleet)[ ]*:", re.MULTILINE),
    "worlds": re.compile(r"^spawn[ ]*:", re.MULTILINE),
    "robots": re.compile(r"^max_linear_velocity[ ]*:", re.MULTILINE),
}
"""Text that a file of a kind has; the trees of an included file are not a mission."""
_PYTHON_LEAF = re.compile(r"([\w./-]+\.py):\w+")
_FILE_KEYS = ("include", "mission", "world", "robot")


@dataclass(frozen=True)
class ListedFile:
    """A mission, scenario, fleet, world or robot.

    Attributes:
        name: As commands take it in this folder.
        what: Its kind, as a word.
        description: Its description, else the first sentence of the comment at its head; one line.
        path: Its file.
        is_shipped: Whether it is shipped with bt-mission, and not in the working folder.
    """

    name: str
    what: Literal["mission", "scenario", "fleet", "world", "robot"]
    description: str
    path: Path
    is_shipped: bool


def list_files(kind: Kind) -> list[ListedFile]:
    """List the files of a kind: those of the working folder, then the shipped ones.

    A name of several files is listed once, for the one that commands take.
    """
    listed: dict[str, ListedFile] = {}
    shipped = shipped_folders(kind)
    for folder in (Path(), *folders(kind)):
        for path in _files_in(folder, kind):
            name = _name(path, folder)
            if name not in listed:
                listed[name] = _listed(name, path, kind, is_shipped=folder in shipped)
    return list(listed.values())


def find_listed(kind: Kind, name: str) -> ListedFile:
    """Return a file of a kind by its name in the list, the last part of it, or its path.

    Raises:
        InputError: With the known names.
    """
    known = list_files(kind)
    named = [entry for entry in known if name in (entry.name, Path(entry.name).name.split(".")[0])]
    if named:
        return named[0]
    path = look_for(kind, name)
    if path is not None:
        return _listed(name, path, kind, is_shipped=False)
    names = [entry.name for entry in known]
    near = did_you_mean(name, [*names, *(Path(text).name.split(".")[0] for text in names)])
    plain = [text for text in names if "/" not in text]
    message = f"no such {kind.removesuffix('s')} (known: {listed(plain)})"
    raise InputError([Diagnostic("BT-110", message, name, hint=near)])


def files_of(path: Path) -> list[Path]:
    """List a file and those that it names by their paths from its folder, and so on.

    They are included trees, the missions, world and robots of a scenario or fleet, Python leaves,
    and the MuJoCo model of a robot with its meshes and textures. A file that is named without a
    path is not listed: it is looked up by its name.

    Raises:
        InputError: A file is not YAML.
    """
    files = {path.resolve(): path}
    waiting = [(path, path.parent, ("",))]
    while waiting:
        file, folder, below = waiting.pop()
        if is_model := file.suffix == ".xml":
            # MuJoCo looks from the folder of the first file, also for what an included file names.
            text = contents_of(file).decode("utf-8", "replace")
            below = (*below, *_MODEL_FOLDER.findall(text))
            names = [str(Path(each, name)) for name in _MODEL_FILE.findall(text) for each in below]
        else:
            names = list(_named_files(read(file).data)) if file.suffix in SUFFIXES else []
            if file.suffix == ".py":
                names = [
                    str(other.relative_to(folder)) for other in files_beside(folder / file.name)
                ]
        for name in names:
            beside = folder / name
            if is_file(beside) and beside.resolve() not in files:
                files[beside.resolve()] = beside
                of_model = (folder, below) if is_model else (beside.parent, ("",))
                waiting.append((beside, *of_model))
    return list(files.values())


def _files_in(folder: Path, kind: Kind) -> list[Path]:
    """List the files of a kind in a folder and, if it is that of the kind, one level below."""
    patterns = ("*", "*/*") if folder.name == kind else ("*",)
    try:
        paths = [path for pattern in patterns for path in sorted(folder.glob(pattern))]
    except OSError:  # a folder that may not be read
        return []
    return [
        path
        for path in paths
        if path.suffix in SUFFIXES and _MARKS[kind].search(text_to_look_at(path)) is not None
    ]


def _name(path: Path, folder: Path) -> str:
    """Name a file as commands take it: a name for what lies in the folder of its kind."""
    inside = path.relative_to(folder)
    is_named = len(inside.parts) == 1 and folder != Path() and "." not in inside.stem
    return inside.stem if is_named else inside.as_posix()


def _listed(name: str, path: Path, kind: Kind, *, is_shipped: bool) -> ListedFile:
    text = text_to_look_at(path)
    what: Any = kind.removesuffix("s")
    try:
        data = read(path).data
    except InputError as error:
        first = error.diagnostics[0]
        description = f"cannot be read: line {first.line}: {first.message}"
    else:
        data = data if isinstance(data, dict) else {}
        what = kind_of(path) if kind == "missions" else what
        description = str(data.get("description") or "") or _head_comment(text)
    return ListedFile(name, what, " ".join(description.split()), path, is_shipped)


def _head_comment(text: str) -> str:
    """Return the first sentence of the comment with which a file begins."""
    lines = (line for line in text.split("\n", 2)[:2] if "yaml-language-server" not in line)
    first = next(lines, "")
    if not first.startswith("#"):
        return ""
    return first_sentence(first.lstrip("# "))


def first_sentence(text: str) -> str:
    """Return a text up to the end of its first sentence."""
    end = re.search(r"\.\s", text)
    return text[: end.start() + 1] if end else text


_MODEL_FILE = re.compile(r"""\bfile\w*\s*=\s*["']([^"'<>]+)["']""")
_MODEL_FOLDER = re.compile(r"""\b(?:mesh|texture|asset)dir\s*=\s*["']([^"'<>]+)["']""")


def _named_files(data: Any) -> Iterator[str]:
    """Yield the values of a file that may name others; a fleet has them for each robot."""
    model = data.get("model") if isinstance(data, dict) else None
    if isinstance(model, dict) and isinstance(model.get("file"), str):
        yield model["file"]
    waiting = [data]
    while waiting:
        part = waiting.pop()
        if isinstance(part, dict):
            for key in _FILE_KEYS:
                names = part.get(key)
                for name in names if isinstance(names, list) else [names]:
                    if isinstance(name, str) and Path(name).suffix in SUFFIXES:
                        yield name
            waiting += part.values()
        elif isinstance(part, list):
            waiting += part
        elif isinstance(part, str) and (leaf := _PYTHON_LEAF.fullmatch(part)):
            yield leaf[1]
