"""What can be wrong with a loaded mission on this machine: worlds, robots, and the ROS types.

Every goal is compared with the fields of its action's type, every condition with the feedback,
every output with the result, and services and topics in the same way. Where ROS is not installed
a warning says that this was not done.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path

from bt_mission.common import data
from bt_mission.common.errors import BtMissionError
from bt_mission.common.faults import (
    MOST_FAULTS,
    Fault,
    InputError,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.common.located import Document, read
from bt_mission.common.robot import load_robot
from bt_mission.mission.check_types import type_faults
from bt_mission.mission.expressions import Plain
from bt_mission.mission.load import draft
from bt_mission.mission.review import warnings
from bt_mission.mission.short_names import SHORT_NAMES
from bt_mission.mission.steps import Action, Mission, Parallel, Step

NEEDS_A_CAMERA = frozenset(short.type for short in SHORT_NAMES.values() if short.needs_camera)
MOVES_THE_BASE = frozenset(short.type for short in SHORT_NAMES.values() if short.moves_base)


def check(mission: Mission) -> tuple[Fault, ...]:
    """Return every fault of a mission, errors and warnings, in the order of the file.

    The warnings that loading gave (`mission.warnings`) are not repeated.
    """
    document = mission.document
    assert document is not None, "a mission to check comes from a file or a text"
    return in_order(_faults(document, mission, frozenset()))


def examine(
    path: str | Path,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> tuple[Mission | None, tuple[Fault, ...]]:
    """Load and check a mission file; return it with all warnings, or None with all faults.

    What `load` refuses is checked as far as it goes, so that nothing hides behind something
    else. Nothing is raised.
    """
    try:
        found = draft(read(path), set, seed, world, robot)
    except InputError as error:
        return None, error.faults
    if found.mission is None:
        return None, found.faults
    faults = [*found.faults, *_faults(found.document, found.mission, found.lost)]
    if any(fault.severity == "error" for fault in faults):
        return None, in_order(faults)
    noted = tuple(warnings(found.document, found.mission))
    return replace(found.mission, warnings=noted), in_order([*noted, *faults])


def _faults(document: Document, mission: Mission, lost: frozenset[str]) -> list[Fault]:
    faults = [*_place_faults(document, mission), *_base_faults(document, mission)]
    faults += _camera_faults(document, mission)
    try:
        from bt_mission import ros_types  # noqa: PLC0415 - the rest works without ROS
    except ImportError as error:
        message = f"ROS 2 is not there ({error}), so types and fields were not checked"
        hint = "try 'bt-mission doctor'"
        faults.append(Fault(message, mission.file, hint=hint, severity="warning"))
    else:
        found = type_faults(document, mission, ros_types.shapes, lost)
        faults += islice(found, MOST_FAULTS)
    return faults


def _place_faults(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield a fault for a world or robot that is not there."""
    places: tuple[tuple[data.Kind, str, str | None], ...] = (
        ("worlds", "world", mission.world),
        ("robots", "robot", mission.robot),
    )
    for kind, key, wanted in places:
        if wanted is None or data.look_for(kind, wanted, mission.file) is not None:
            continue
        known = data.names(kind)
        message = f"no {key} {quoted(wanted)} (known: {listed(known)})"
        hint = did_you_mean(wanted, known)
        written = document.data.get(key) == wanted
        yield (
            document.fault((key,), message, hint)
            if written
            else Fault(message, f"--{key}", hint=hint)
        )


def _base_faults(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield a warning for every parallel of which two children move the base."""
    for step in mission.tree.walk():
        if not isinstance(step, Parallel):
            continue
        movers = [child for child in step.children if any(_moves(part) for part in child.walk())]
        if len(movers) > 1:
            message = "two branches of a parallel move the base; the later goal ends the earlier"
            yield document.fault(movers[1].path, message, severity="warning")


def _camera_faults(document: Document, mission: Mission) -> Iterator[Fault]:
    """Yield a fault for every goal that takes pictures with a robot that has no camera."""
    try:
        robot = load_robot(mission.robot, near=mission.file)
    except BtMissionError:
        return  # said elsewhere, or when it is used
    for step in mission.tree.walk():
        if robot.camera is None and isinstance(step, Action) and step.type in NEEDS_A_CAMERA:
            yield document.fault(
                step.path, f"{step.action} needs a camera; a {robot.name} has none"
            )


def _moves(step: Step) -> bool:
    return isinstance(step, Action) and step.type in MOVES_THE_BASE
