"""Load a world, and check it beyond its types: names, places, space at the start.

Nothing here depends on the robot: whether one fits at the spawn is checked when it stands there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from bt_mission.base.diagnostics import InputError
from bt_mission.base.file_kinds import refuse_other_formats
from bt_mission.base.files import find
from bt_mission.base.yaml.document import Document, read_source, read_text
from bt_mission.base.yaml.models import validate
from bt_mission.robots.model import RobotModel
from sim.world.shapes import Obstacle
from sim.world.world import FloorMark, World


def load_world(name_or_path: str | Path | Document, near: str | Path | None = None) -> World:
    """Return a world, by its name or file, or of its text. Raises InputError with every mistake.

    `near` is a file beside which a world of that name is looked for first, such as a mission.
    """
    if isinstance(name_or_path, Document):
        return world_in(name_or_path)
    file = find("worlds", name_or_path, near)
    refuse_other_formats(file, ("world",))
    return _world_of_text(read_source(file), str(file))


@lru_cache(maxsize=16)
def _world_of_text(text: str, file: str) -> World:
    """Return the world in the text of a file; checks ask for the same one several times."""
    return world_in(read_text(text, file))


def world_in(document: Document, path: tuple[str | int, ...] = ()) -> World:
    """Return the world at a path of a document. Raises InputError with every mistake."""
    world = validate(document, World, path)
    found_problems = problems(world)
    if found_problems:
        raise InputError(
            document.diagnostic(problem.code, (*path, *problem.path), problem.message, problem.hint)
            for problem in found_problems
        )
    return world


@dataclass(frozen=True)
class WorldProblem:
    """A mistake in a world, and its path in the file."""

    code: str
    path: tuple[str | int, ...]
    message: str
    hint: str | None = None


def problems(world: World) -> list[WorldProblem]:
    """Return everything wrong with a world whose fields are well-formed."""
    return [*_names(world), *_places(world), *_spawn(world)]


def unseen(world: World, robot: RobotModel) -> list[str]:
    """Return a warning if obstacles are too low for the robot's lidar, in one sentence."""
    height = robot.base_height + robot.lidar.z
    low = [obstacle for obstacle in world.obstacles if obstacle.height <= height]
    if not low:
        return []
    names = ", ".join(f"'{obstacle.name}'" for obstacle in low[:3]) + (
        f" and {len(low) - 3} more" if len(low) > 3 else ""
    )
    return [
        (
            f"world {world.name}: the lidar of the {robot.name} looks {height:.3f} m above the"
            f" floor and over {names}: it will run into them unless it knows the map"
        )
    ]


def _names(world: World) -> Iterator[WorldProblem]:
    seen: dict[str, str] = {}
    for placed in world.placed:
        section, index = placed.path
        name = placed.obstacle.name
        if name in seen:
            yield WorldProblem(
                "BT-208",
                (section, index, "name"),
                f"the name '{name}' is taken by {seen[name]}",
                "give every obstacle a different name; collisions are reported by it",
            )
        seen.setdefault(name, f"item {index + 1} of {section}")
    sections: dict[str, Sequence[FloorMark]] = {"zones": world.zones, "objects": world.objects}
    for section, marks in sections.items():
        names: set[str] = set()
        for index, mark in enumerate(marks):
            if mark.name in names:
                yield WorldProblem(
                    "BT-208",
                    (section, index, "name"),
                    f"there are two {section} named '{mark.name}'",
                )
            names.add(mark.name)


def _places(world: World) -> Iterator[WorldProblem]:
    for placed in world.placed:
        obstacle = placed.obstacle
        if not world.has_floor_at(obstacle.x, obstacle.y):
            yield WorldProblem(
                "BT-801",
                placed.path,
                f"'{obstacle.name}' stands {_beside(world, obstacle.x, obstacle.y)}",
            )
        for x, y in obstacle.motion.reach if obstacle.motion else ():
            if not world.has_floor_at(x, y):
                where = f"'{obstacle.name}' moves to where it would stand {_beside(world, x, y)}"
                yield WorldProblem("BT-801", (*placed.path, "motion"), where)
                break
    lying: dict[str, Sequence[FloorMark]] = {"slippery": world.slippery, "objects": world.objects}
    for section, index, mark in (
        (section, index, mark)
        for section, marks in lying.items()
        for index, mark in enumerate(marks)
    ):
        if not world.has_floor_at(mark.x, mark.y):
            where = f"'{mark.name}' lies {_beside(world, mark.x, mark.y)}"
            yield WorldProblem("BT-801", (section, index), where)
    for index, zone in enumerate(world.zones):
        path = ("zones", index)
        if not world.has_floor_at(zone.x, zone.y):
            yield WorldProblem(
                "BT-801", path, f"zone '{zone.name}' lies {_beside(world, zone.x, zone.y)}"
            )
        elif inside := _obstacle_at(world, zone.x, zone.y):
            yield WorldProblem(
                "BT-802", path, f"the centre of zone '{zone.name}' lies inside '{inside.name}'"
            )


def _spawn(world: World) -> Iterator[WorldProblem]:
    spawn = world.spawn
    if not world.has_floor_at(spawn.x, spawn.y):
        yield WorldProblem(
            "BT-801", ("spawn",), f"the spawn lies {_beside(world, spawn.x, spawn.y)}"
        )
    elif inside := _obstacle_at(world, spawn.x, spawn.y):
        yield WorldProblem(
            "BT-802",
            ("spawn",),
            f"the spawn ({spawn.x:g}, {spawn.y:g}) lies inside '{inside.name}'",
            "move it to where the robot has room",
        )


def _obstacle_at(world: World, x: float, y: float) -> Obstacle | None:
    return next((o for o in world.obstacles if o.distance(x, y) <= 0), None)


def _beside(world: World, x: float, y: float) -> str:
    return f"at ({x:g}, {y:g}), outside of {world.floor}"
