"""The check of a text that is being written, of any kind of file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import FileKind
from bt_mission.core.robot.model import load_robot
from bt_mission.core.yaml.document import Document, read_text
from bt_mission.fleets.loader import FleetChanges, examine_fleet
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.permissions import Permissions
from bt_mission.language.requirements.written import RequirementsFile
from bt_mission.scenarios.loader import ScenarioChanges, examine_scenario
from bt_mission.sessions.check import examine
from sim.world.loader import load_world

PERMISSIONS = Permissions(python="name", hint="'bt-mission check --import-python' imports it")
"""A check runs no code of a mission."""


_MISSION = "\nmission: trees\ntree: {wait: 0}\n"
"""Behind a file of trees, which missions include: it is checked as a mission."""
_NEVER_USED = "BT-231"
"""A tree without a use: missions that include the file have them."""


def check_text(text: str, path: Path, kind: FileKind) -> tuple[Diagnostic, ...]:
    """Return every error and warning of the text of a file, which need not exist."""
    try:
        return _CHECKS[kind](read_text(text, str(path)))
    except InputError as error:
        return error.diagnostics
    except BtMissionError as error:
        return (Diagnostic(error.code, str(error), str(path)),)


def _mission(document: Document) -> tuple[Diagnostic, ...]:
    head = document.data if isinstance(document.data, Mapping) else {}
    if "trees" not in head or {"mission", "tree"} & head.keys():
        return examine(document, permissions=PERMISSIONS)[1]
    document = read_text("\n".join(document.lines) + _MISSION, document.file)
    diagnostics = examine(document, permissions=PERMISSIONS)[1]
    return tuple(each for each in diagnostics if each.code != _NEVER_USED)


def _scenario(document: Document) -> tuple[Diagnostic, ...]:
    return examine_scenario(document, ScenarioChanges(permissions=PERMISSIONS))[1]


def _fleet(document: Document) -> tuple[Diagnostic, ...]:
    return examine_fleet(document, FleetChanges(permissions=PERMISSIONS))[1]


def _world(document: Document) -> tuple[Diagnostic, ...]:
    load_world(document)
    return ()


def _robot(document: Document) -> tuple[Diagnostic, ...]:
    load_robot(document)
    return ()


def _requirements(document: Document) -> tuple[Diagnostic, ...]:
    reader = NodeReader(document)
    reader.written(RequirementsFile, (), document.data)
    return tuple(reader.diagnostics)


_CHECKS: Mapping[FileKind, Callable[[Document], tuple[Diagnostic, ...]]] = {
    "mission": _mission,
    "scenario": _scenario,
    "fleet": _fleet,
    "world": _world,
    "robot": _robot,
    "requirements": _requirements,
    "ranges": lambda _: (),
}
"""The check of each kind of file; of ranges it is only that they are YAML."""
