"""Load a world: `worlds/NAME.yaml`, or a file of one's own."""

from __future__ import annotations

from pathlib import Path

from bt_mission.core.diagnostics import InputError
from bt_mission.core.files import find
from bt_mission.core.yaml.document import read
from bt_mission.core.yaml.models import validate
from sim.world.checks import problems
from sim.world.world import World


def load_world(name_or_path: str | Path, near: str | Path | None = None) -> World:
    """Return a world. Raises InputError with every fault and its place.

    `near` is a file beside which a world of that name is looked for first, such as a mission.
    """
    document = read(find("worlds", name_or_path, near))
    world = validate(document, World)
    found = problems(world)
    if found:
        raise InputError(
            document.fault(problem.path, problem.message, problem.hint) for problem in found
        )
    return world
