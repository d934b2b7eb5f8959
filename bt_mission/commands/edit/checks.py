"""The check of a text that is being written, of any kind of file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import FileKind
from bt_mission.base.yaml.document import Document, read_text
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.permissions import Permissions
from bt_mission.requirements.language.written import RequirementsFile
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.fleets.loader import FleetChanges, examine_fleet
from bt_mission.scenarios.loader import ScenarioChanges, examine_scenario
from bt_mission.sessions.check import examine
from sim.world.loader import load_world


def permissions(folder: Path) -> Permissions:
    """Return what the check of a text may read: the files of a folder. It runs no code."""
    hint = "'bt-mission check --import-python' imports it"
    return Permissions(folders=(folder,), python="name", hint=hint)


_MISSION = "\nmission: trees\ntree: {wait: 0}\n"
"""Behind a file of trees, which missions include: it is checked as a mission."""
_NEVER_USED = "BT-231"
"""A tree without a use: missions that include the file have them."""


def check_text(text: str, path: Path, kind: FileKind, folder: Path) -> tuple[Diagnostic, ...]:
    """Return every error and warning of the text of a file, which need not exist.

    Args:
        text: The text.
        path: Of its file.
        kind: Of its file.
        folder: Files that it names are read from there and below, and shipped ones.
    """
    try:
        return _CHECKS[kind](read_text(text, str(path)), permissions(folder))
    except InputError as error:
        return error.diagnostics
    except BtMissionError as error:
        return (Diagnostic(error.code, str(error), str(path)),)


def _mission(document: Document, allowed: Permissions) -> tuple[Diagnostic, ...]:
    head = document.data if isinstance(document.data, Mapping) else {}
    if "trees" not in head or {"mission", "tree"} & head.keys():
        return examine(document, permissions=allowed)[1]
    document = read_text("\n".join(document.lines) + _MISSION, document.file)
    diagnostics = examine(document, permissions=allowed)[1]
    return tuple(each for each in diagnostics if each.code != _NEVER_USED)


def _scenario(document: Document, allowed: Permissions) -> tuple[Diagnostic, ...]:
    return examine_scenario(document, ScenarioChanges(permissions=allowed))[1]


def _fleet(document: Document, allowed: Permissions) -> tuple[Diagnostic, ...]:
    return examine_fleet(document, FleetChanges(permissions=allowed))[1]


def _world(document: Document, _: Permissions) -> tuple[Diagnostic, ...]:
    load_world(document)
    return ()


def _robot(document: Document, _: Permissions) -> tuple[Diagnostic, ...]:
    load_robot(document)
    return ()


def _requirements(document: Document, _: Permissions) -> tuple[Diagnostic, ...]:
    reader = NodeReader(document)
    reader.written(RequirementsFile, (), document.data)
    return tuple(reader.diagnostics)


_CHECKS: Mapping[FileKind, Callable[[Document, Permissions], tuple[Diagnostic, ...]]] = {
    "mission": _mission,
    "scenario": _scenario,
    "fleet": _fleet,
    "world": _world,
    "robot": _robot,
    "requirements": _requirements,
    "ranges": lambda *_: (),
}
"""The check of each kind of file; of ranges it is only that they are YAML."""
