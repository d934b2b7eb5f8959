"""What can be wrong with a loaded mission on this machine: worlds, robots, and the ROS types.

Every goal is compared with the fields of its action's type, every condition with the feedback,
every output with the result, and services and topics in the same way. Where ROS is not installed
a warning says that this was not done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path

from bt_mission.core import files
from bt_mission.core.diagnostics import (
    MOST_FAULTS,
    Diagnostic,
    InputError,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.core.errors import BtMissionError
from bt_mission.core.robot.model import load_robot
from bt_mission.core.yaml.document import Document, read_text
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.checks.mission import python_leaf_faults, type_faults, warnings
from bt_mission.language.checks.types import FindShapes
from bt_mission.language.expressions.values import Plain
from bt_mission.language.loader import Draft, draft
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.composites import ParallelNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.trees import reached
from bt_mission.sessions.load import read_mission

NEEDS_A_CAMERA = frozenset(short.type for short in ACTION_NAMES.values() if short.needs_camera)
MOVES_THE_BASE = frozenset(short.type for short in ACTION_NAMES.values() if short.moves_base)


def check(mission: Mission, *, import_python: bool = False) -> tuple[Diagnostic, ...]:
    """Return every fault of a mission, errors and warnings, in the order of the file.

    The warnings that loading gave (`mission.warnings`) are not repeated. A Python leaf is code of
    its author's, which runs when it is imported.

    Args:
        mission: As `load` returns it.
        import_python: Import Python leaves, and check what they are given; without it each has a
            warning that names it.
    """
    hint = "check(mission, import_python=True) imports it, and checks what it is given"
    return in_order(
        _faults(mission, ANYTHING if import_python else Permissions(python="name", hint=hint))
    )


def examine(
    path: str | Path,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
    permissions: Permissions = ANYTHING,
) -> tuple[Mission | None, tuple[Diagnostic, ...]]:
    """Load and check a mission file; return it with all warnings, or None with all faults.

    What `load` refuses is checked as far as it goes, so that nothing hides behind something
    else. Nothing is raised.
    """
    return _examined(
        lambda: draft(read_mission(path), set, seed, world, robot, permissions), permissions
    )


def examine_text(
    text: str,
    file: str = "<text>",
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - as in examine
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
    permissions: Permissions = ANYTHING,
) -> tuple[Mission | None, tuple[Diagnostic, ...]]:
    """Load and check a mission in a text, as `examine` does a file."""
    return _examined(
        lambda: draft(read_text(text, file), set, seed, world, robot, permissions), permissions
    )


def _examined(
    read_draft: Callable[[], Draft], permissions: Permissions
) -> tuple[Mission | None, tuple[Diagnostic, ...]]:
    try:
        found = read_draft()
    except InputError as error:
        return None, error.faults
    if found.mission is None:
        return None, found.faults
    faults = [*found.faults, *_faults(found.mission, permissions)]
    if any(fault.severity == "error" for fault in faults):
        return None, in_order(faults)
    noted = tuple(warnings(found.mission))
    return replace(found.mission, warnings=noted), in_order([*noted, *faults])


def _faults(mission: Mission, permissions: Permissions) -> list[Diagnostic]:
    document = mission.document
    assert document is not None, "a mission to check comes from a file or a string"
    faults = [
        *python_leaf_faults(mission, permissions),
        *_place_faults(document, mission, permissions),
        *_base_faults(mission),
        *_camera_faults(mission, permissions),
    ]
    find: FindShapes | None = None
    try:
        from bt_mission.ros import interface_types  # noqa: PLC0415 - the rest works without ROS
    except ImportError as error:
        message = f"ROS 2 is not there ({error}), so types and fields were not checked"
        hint = "try 'bt-mission doctor'"
        faults.append(Diagnostic(message, mission.file, hint=hint, severity="warning"))
    else:
        find = interface_types.shapes
    types = type_faults(mission, find, permissions)
    return [*faults, *islice(types, MOST_FAULTS)]


def _place_faults(
    document: Document, mission: Mission, permissions: Permissions
) -> Iterator[Diagnostic]:
    """Yield a fault for a world or robot that is not there."""
    places: tuple[tuple[files.Kind, str, str | None], ...] = (
        ("worlds", "world", mission.world),
        ("robots", "robot", mission.robot),
    )
    for kind, key, wanted in places:
        if wanted is None or _is_there(kind, wanted, mission, permissions):
            continue
        known = files.names(kind)
        message = f"no {key} {quoted(wanted)} (known: {listed(known)})"
        hint = did_you_mean(wanted, known)
        written = document.data.get(key) == wanted
        yield (
            document.fault((key,), message, hint)
            if written
            else Diagnostic(message, f"--{key}", hint=hint)
        )


def _is_there(kind: files.Kind, wanted: str, mission: Mission, permissions: Permissions) -> bool:
    found = files.look_for(kind, wanted, mission.file)
    return found is not None and permissions.allows(found, kind)


def _base_faults(mission: Mission) -> Iterator[Diagnostic]:
    """Yield a warning for every parallel of which two children move the base."""
    for tree in mission.all_trees:
        for step in tree.body.walk():
            if not isinstance(step, ParallelNode):
                continue
            movers = [
                child
                for child in step.children
                if any(
                    isinstance(node, GoalNode) and node.type in MOVES_THE_BASE
                    for node in reached(child, mission)
                )
            ]
            if len(movers) > 1:
                what = "two branches of a parallel move the base"
                message = f"{what}; the later goal ends the earlier"
                yield tree.document.fault(movers[1].path, message, severity="warning")


def _camera_faults(mission: Mission, permissions: Permissions) -> Iterator[Diagnostic]:
    """Yield a fault for every goal that takes pictures with a robot that has no camera."""
    found = [
        (tree.document, step)
        for tree in mission.all_trees
        for step in tree.body.walk()
        if isinstance(step, GoalNode) and step.type in NEEDS_A_CAMERA
    ]
    if not found or not _is_there("robots", mission.robot, mission, permissions):
        return
    try:
        robot = load_robot(mission.robot, near=mission.file)
    except BtMissionError:
        return  # said elsewhere, or when it is used
    if robot.camera is None:
        for document, step in found:
            message = f"{step.ros_name} needs a camera; a {robot.name} has none"
            yield document.fault(step.path, message)
