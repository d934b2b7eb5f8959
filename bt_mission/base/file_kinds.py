"""The kind of a file, by its name and its beginning, and the command that takes it."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path

from bt_mission.base.commands import (
    ROWS,
    CommandRow,
    FileFormat,
    all_rows,
    brought_kinds,
    page,
    rows,
    ways,
)
from bt_mission.base.diagnostics import Diagnostic, InputError, quoted
from bt_mission.base.files import (
    SUFFIXES,
    is_file,
    known_kind_of_text,
    open_file,
    text_to_look_at,
    top_keys,
)

_WORLD = f"a world has walls and boxes: see {page('files#worlds')}"
_MODEL = f"see {page('arms')}"
_CHECKS = "bt_mission.sessions.file_checks"
_RANGES = "bt_mission.scenarios.concrete.ranges"


def _checked(noun: str, check: str, schema: str) -> FileFormat:
    return FileFormat(noun, check=check, schema=schema)


FORMATS = {
    "mission": FileFormat("a mission", schema="bt_mission.requirements.schema:mission_schema"),
    "scenario": FileFormat("a scenario", schema="bt_mission.scenarios.schema:scenario_schema"),
    "fleet": FileFormat("a fleet", schema="bt_mission.scenarios.fleets.file:fleet_schema"),
    "world": _checked("a world", f"{_CHECKS}:check_world", f"{_CHECKS}:world_schema"),
    "robot": _checked("a robot", f"{_CHECKS}:check_robot", f"{_CHECKS}:robot_schema"),
    "requirements": _checked(
        "a file of requirements", f"{_CHECKS}:check_requirements", f"{_CHECKS}:requirements_schema"
    ),
    "ranges": _checked("a file of ranges", f"{_RANGES}:check_ranges", f"{_RANGES}:ranges_schema"),
    "tree": FileFormat("a tree of BehaviorTree.CPP"),
    "parameters": FileFormat("a ROS parameter file"),
    "foreign parameters": FileFormat(
        "a ROS parameter file of other nodes",
        f"the limits of goals are in a robot file: see {page('files#robots')}",
    ),
    "recording": FileFormat("a recording"),
    "foreign recording": FileFormat("a recording (MCAP) of another program"),
    "bag folder": FileFormat("the folder of a bag"),
    "sqlite bag": FileFormat(
        "a bag in SQLite",
        "convert it: write 'output_bags: [{uri: converted, storage_id: mcap, all_topics: true, "
        "all_services: true}]' to out.yaml, run `ros2 bag convert -i {} -o out.yaml`, and use the "
        "folder 'converted'",
    ),
    "bag metadata": FileFormat("the description of a bag", "name its folder"),
    "trace": FileFormat("a trace"),
    "journal": FileFormat("a journal"),
    "sweep folder": FileFormat("the folder of a sweep"),
    "sweep results": FileFormat("the database of a sweep", "name its folder"),
    "map": FileFormat("a map of map_server", _WORLD),
    "map image": FileFormat("an image", _WORLD),
    "urdf": FileFormat("a URDF", f"a robot file takes an MJCF model: {_MODEL}"),
    "sdf": FileFormat("an SDF", _WORLD),
    "mjcf": FileFormat("a MuJoCo model (MJCF)", f"name it in a robot file: {_MODEL}"),
    "python": FileFormat(
        "a Python file",
        "name its class in a mission, as {}:CLASS: see " + page("python"),
    ),
    "interface": FileFormat("a ROS interface", "a mission names its type: PACKAGE/action/NAME"),
    "page": FileFormat("an HTML page", "open it in a browser"),
    "launch file": FileFormat("a launch file", "use `ros2 launch {}`"),
}
"""Every kind that is recognized, but for those that commands bring."""


def format_named(kind: str) -> FileFormat:
    """Return a kind of file by its name. Raises KeyError."""
    return FORMATS.get(kind) or brought_kinds(all_rows())[kind]


def way_with(kind: str, path: str) -> str:
    """Return what to do with a file of a kind, such as "use `bt-mission run FILE`"; or nothing."""
    commands = ways(kind)
    way = format_named(kind).way or (commands and f"use {commands}")
    return way.replace("{}", path)


MISSIONS = (
    "mission",
    *(kind for row in ROWS if row.missions and row.is_there for kind in row.missions),
)
RUNS = (*MISSIONS, "scenario", "fleet")
"""What `run` takes."""
PLAIN = ("world", "robot", "requirements", "ranges")
"""Those of YAML that hold no mission."""
RECORDINGS = ("recording", "foreign recording")
PARAMETERS = ("parameters", "foreign parameters")

_MCAP, _GZIP, _ZSTANDARD = b"\x89MCAP0\r\n", b"\x1f\x8b", b"\x28\xb5\x2f\xfd"
_SQLITE = b"SQLite format 3\0"
_TABLES = {
    b"CREATE TABLE topics": "sqlite bag",
    b"CREATE TABLE state": "journal",
    b"CREATE TABLE scenarios": "sweep results",
}
"""Of databases, in their first page."""
_TRACE = '"trace_version"'
_IMAGES = (b"P2", b"P5", b"\x89PNG", b"BM", b"\xff\xd8\xff")
_OURS = b"bt-mission"
"""Names the writer in the header of a recording."""
_ROOT = re.compile(r"<(?![?!])\s*([\w:]+)")
_ROOTS = {"root": "tree", "robot": "urdf", "sdf": "sdf", "mujoco": "mjcf", "launch": "launch file"}
_BY_SUFFIX = {
    ".py": "python",
    ".db3": "sqlite bag",
    ".pgm": "map image",
    ".jsonl": "trace",
    ".html": "page",
    ".urdf": "urdf",
    ".xacro": "urdf",
    ".sdf": "sdf",
    ".world": "sdf",
    **dict.fromkeys((".action", ".msg", ".srv"), "interface"),
}
_OUR_NODES = re.compile(r"^[ ]*['\"]?(/?\*|[\w/*]*bt_mission)", re.MULTILINE)
_FOREIGN_YAML = {
    "map": re.compile(r"^(image|resolution|occupied_thresh)[ ]*:", re.MULTILINE),
    "bag metadata": re.compile(r"^rosbag2_bagfile_information[ ]*:", re.MULTILINE),
    "parameters": re.compile(r"^[ ]+ros__parameters[ ]*:", re.MULTILINE),
}
_RARE = ("tree", "foreign recording", "bag folder", "foreign parameters")
_BEGINNING = 4096


def format_of(path: Path) -> str | None:
    """Return what a file or folder is, as a key of `FORMATS`; None where it is not recognized."""
    if path.is_dir():
        return _folder(path)
    if not is_file(path):
        return None
    try:
        with open_file(path) as stream:
            beginning = stream.read(_BEGINNING)
    except OSError:
        return None
    return _by_content(path, beginning) or _by_name(path)


def _folder(path: Path) -> str | None:
    if (path / "metadata.yaml").is_file():
        return "bag folder"
    return "sweep folder" if (path / "results.sqlite").is_file() else None


def _by_content(path: Path, beginning: bytes) -> str | None:
    if beginning.startswith(_MCAP):
        return "recording" if _OURS in beginning[:200] else "foreign recording"
    if beginning.startswith((_GZIP, _ZSTANDARD)) and ".mcap" in path.suffixes:
        return "foreign recording"
    if beginning.startswith(_SQLITE):
        return next((name for mark, name in _TABLES.items() if mark in beginning), None)
    if beginning.startswith(_IMAGES) and path.suffix not in SUFFIXES:
        return "map image"
    text = beginning.decode(errors="replace").lstrip("\ufeff \t\r\n")
    if text.startswith("<"):
        root = next(iter(_ROOT.findall(text)), "")
        return "page" if text[:9].lower() == "<!doctype" else _ROOTS.get(root)
    if path.suffix in SUFFIXES:
        return _yaml(text_to_look_at(path))
    return "trace" if text.startswith("{") and _TRACE in text.partition("\n")[0] else None


def _yaml(text: str) -> str | None:
    known = known_kind_of_text(text)
    if known in (*RUNS, "world", "robot"):
        return known
    kind = next((name for name, key in _FOREIGN_YAML.items() if key.search(text)), None)
    kind = kind or _brought(text, rows()) or known or _brought(text, all_rows())
    is_foreign = kind == "parameters" and not _OUR_NODES.search(text)
    return "foreign parameters" if is_foreign else kind


def _brought(text: str, known: Mapping[str, CommandRow]) -> str | None:
    """Return the kind of a text that one of the rows brings."""
    keys = top_keys(text)
    kinds = brought_kinds(known)
    return next((name for name, kind in kinds.items() if keys & kind.keys), None)


def _by_name(path: Path) -> str | None:
    if path.name.endswith((".launch.py", ".launch.xml")):
        return "launch file"
    return _BY_SUFFIX.get(path.suffix.lower())


def refuse_other_formats(path: Path, wanted: Collection[str]) -> None:
    """Refuse a file that is recognized as another kind than those that are wanted.

    Raises:
        InputError: With what it is, and the command that takes it.
    """
    kind = format_of(path)
    if kind is None or kind in wanted:
        return
    parts = (f"is {format_named(kind).noun}", f"expected {expected(wanted)}")
    message = "; ".join(filter(None, (*parts, way_with(kind, str(path)))))
    raise InputError([Diagnostic("BT-111", message, str(path))])


def expected(wanted: Collection[str]) -> str:
    """Return the kinds that are wanted, as words, without those that are rare."""
    nouns = [format_named(kind).noun for kind in wanted if kind not in _RARE]
    return " or ".join(filter(None, (", ".join(nouns[:-1]), nouns[-1])))


def recording_of(folder: Path) -> Path:
    """Return the MCAP file of a bag's folder.

    Raises:
        InputError: It has none, or several.
    """
    files = sorted(path for path in folder.iterdir() if ".mcap" in path.suffixes and path.is_file())
    if len(files) == 1:
        return files[0]
    if files:
        names = ", ".join(path.name for path in files)
        message = f"the bag has {len(files)} recordings ({names}); name one of them"
        raise InputError([Diagnostic("BT-111", message, str(folder))])
    way = way_with("sqlite bag", str(folder))
    message = f"the bag has no MCAP file; {way}"
    raise InputError([Diagnostic("BT-111", message, quoted(str(folder)))])
