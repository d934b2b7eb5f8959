"""Checks and schemas of the files that hold no mission: worlds, robots and requirements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.text import counted
from bt_mission.base.yaml.document import read
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.schema import DIALECT
from bt_mission.requirements.language.written import RequirementsFile
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.sessions.stage_checks import (
    dragging_parts,
    model_problems,
    rate_problems,
    start_problem,
)
from sim.world.loader import load_world, unseen
from sim.world.world import Spawn, World

DEFAULT_ROBOT, DEFAULT_WORLD = "waffle", "empty_arena"


@dataclass(frozen=True)
class CheckedFile:
    """A file without errors: its name, and a short summary of its content."""

    file: str
    name: str
    summary: str


Checked: TypeAlias = tuple[CheckedFile, tuple[Diagnostic, ...]]


def check_world(path: Path, robot: str | None = None, _world: str | None = None) -> Checked:
    """Check a world, and that a robot can start at its spawn.

    Raises:
        InputError: With every error.
    """
    document = read(path)
    world, model = load_world(document), load_robot(robot or DEFAULT_ROBOT, near=path)
    problem = start_problem(world, model)
    if problem is not None:
        place = ("spawn",) if document.has("spawn") else ()
        raise InputError([document.diagnostic("BT-803", place, problem)])
    warnings = tuple(
        document.diagnostic("BT-805", (), text, severity="warning") for text in unseen(world, model)
    )
    summary = f"{counted(len(world.obstacles), 'obstacle')}, {counted(len(world.zones), 'zone')}"
    return CheckedFile(str(path), world.name, summary), warnings


def check_robot(path: Path, _robot: str | None = None, world: str | None = None) -> Checked:
    """Check a robot: its figures, the rates of its sensors, and that it can be simulated.

    Raises:
        InputError: With every error.
    """
    document = read(path)
    robot = load_robot(document)
    wrong = [document.diagnostic("BT-804", key, message) for key, message in rate_problems(robot)]
    unusable = [document.diagnostic("BT-813", *problem) for problem in model_problems(robot)]
    wrong += unusable
    nowhere = load_world(world or DEFAULT_WORLD)
    problem = None if unusable else start_problem(nowhere, robot, Spawn())
    if problem is not None:
        wrong.append(document.diagnostic("BT-803", (), problem))
    if wrong:
        raise InputError(wrong)
    optional = ("camera", "arm", "gripper")
    sensors = ["lidar", "imu", *(name for name in optional if getattr(robot, name) is not None)]
    place = ("drive",) if robot.model is None else ("model",)
    warnings = tuple(
        document.diagnostic("BT-814", place, text, severity="warning")
        for text in dragging_parts(robot)
    )
    return CheckedFile(str(path), robot.name, ", ".join(sensors)), warnings


def check_requirements(path: Path, _robot: str | None = None, _world: str | None = None) -> Checked:
    """Check the formulas of requirements; the names in them are those of a mission.

    Raises:
        InputError: With every error.
    """
    document = read(path)
    reader = NodeReader(document)
    written = reader.written(RequirementsFile, (), document.data)
    if written is None or reader.diagnostics:
        raise InputError(reader.diagnostics)
    return CheckedFile(str(path), path.stem, counted(len(written.requirements), "requirement")), ()


def world_schema() -> dict[str, Any]:
    """Return the JSON Schema of a world file."""
    return _schema(World, "world")


def robot_schema() -> dict[str, Any]:
    """Return the JSON Schema of a robot file."""
    return _schema(RobotModel, "robot")


def requirements_schema() -> dict[str, Any]:
    """Return the JSON Schema of a file of requirements."""
    return _schema(RequirementsFile, "requirements")


def _schema(model: Any, title: str) -> dict[str, Any]:
    return {"$schema": DIALECT, **model.model_json_schema(), "title": f"bt-mission {title}"}
