"""Another version of a recorded mission, as the change of a fork."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.language.checks.frames import frame_change
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission
from bt_mission.language.permissions import Permissions
from bt_mission.recording.forks.change import ForkChange
from bt_mission.recording.forks.source import ForkSource
from bt_mission.sessions.check import examine

FIXED = ("world", "robot", "seed", "map", "nodes")
"""What stands at the head of a mission, and is settled when a run begins."""


def edited(source: ForkSource, path: Path, permissions: Permissions) -> ForkChange:
    """Return the change to another version of the mission.

    An input whose value in the file is another one now takes that at the fork; the others keep
    the values of the recorded run.

    Raises:
        InputError: For a mission that is not sound, or whose world, robot or seed are others.
    """
    found = required(examine(path, permissions=permissions))
    if others := list(_other_heads(source.written, found)):
        raise InputError(others)
    recorded, written = source.mission, source.written.inputs
    kept = {name: value for name, value in recorded.inputs.items() if name in found.inputs}
    values = {
        name: value for name, value in found.inputs.items() if value != written.get(name, value)
    }
    names = {one.name for one in (*found.requirements, *source.written.requirements)}
    added = tuple(one for one in recorded.requirements if one.name not in names)
    edit = replace(
        found,
        world=recorded.world,
        robot=recorded.robot,
        seed=recorded.seed,
        observe=found.observe or recorded.observe,
        nodes=recorded.nodes,
        inputs={**found.inputs, **kept},
        requirements=(*found.requirements, *added),
    )
    new_tree = frame_change(recorded, found)
    if new_tree is None:
        values |= {name: found.inputs[name] for name in found.inputs.keys() - written.keys()}
    return ForkChange(values, edit, new_tree)


def _other_heads(before: Mission, after: Mission) -> Iterator[Diagnostic]:
    for name in FIXED:
        one, other = _head(before, name), _head(after, name)
        if one != other:
            message = f"'{name}' is settled when a run begins: it was {one}, and is {other} here"
            yield after.document.fault((name,), message)


def _head(mission: Mission, name: str) -> str:
    if name == "nodes":
        return ", ".join(one.target for one in mission.nodes) or "none"
    return str(getattr(mission, name))
