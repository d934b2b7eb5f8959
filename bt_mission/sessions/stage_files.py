"""The parts of a stage besides the mission: the files of world and robots, and its options."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bt_mission.base.files import find
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.language.mission import Mission
from bt_mission.sessions.own_nodes import name_of
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions
from sim.physics.mjcf_text import look_through
from sim.world.loader import load_world
from sim.world.world import World

DEFAULT_WORLD = "empty_arena"


@dataclass(frozen=True)
class StageFiles:
    """The world and the files of all robots; the text of the world in the form of its file."""

    world: World
    world_text: Document
    robots: tuple[Document, ...]

    @classmethod
    def find(cls, members: Sequence[FleetRobot], options: StageOptions) -> StageFiles:
        """Read them, unless the options have their text. Raises InputError."""
        first = members[0].mission
        world = options.world or first.world or DEFAULT_WORLD
        if isinstance(world, World):
            text = read_text(
                world.model_dump_json(by_alias=True, exclude_unset=True), f"{world.name}.yaml"
            )
        else:
            if not isinstance(world, Document):
                world = read(find("worlds", world, first.file))
            text, world = world, load_world(world)
        robots = (
            member.model or read(find("robots", member.mission.robot, member.mission.file))
            for member in members
        )
        return cls(world, text, tuple(robots))

    @property
    def contents(self) -> Mapping[str, bytes]:
        """Return what a recording keeps of them, by names without the folders of this machine.

        The files of a MuJoCo model stand beside that of their robot.
        """
        parts = {f"worlds/{Path(self.world_text.file).name}": self.world_text.text.encode()}
        for robot in self.robots:
            path = Path(robot.file)
            parts[f"robots/{path.name}"] = robot.text.encode()
            if isinstance(robot.data, dict) and "model" in robot.data:
                folder = path.resolve().parent
                for each in look_through(folder / robot.data["model"]["file"]):
                    name = each.relative_to(folder).as_posix()
                    parts[f"robots/{name}"] = each.read_bytes()
        return parts


def stage_facts(
    members: Sequence[FleetRobot], options: StageOptions, natures: Sequence[Mapping[str, float]]
) -> Mapping[str, str]:
    """Return the other parameters of a stage on which a run depends, as JSON, to repeat the run."""
    seed = members[0].mission.seed if options.seed is None else options.seed
    known = {
        "sensor_seed": seed,
        "props": options.props,
        "without": sorted(options.without),
        "has_tools": options.has_tools,
        "is_visible": options.visible,
        "robots": [
            {
                "name": member.name,
                "start": (member.x, member.y, member.yaw) if member.name else options.start,
                "nature": nature,
            }
            for member, nature in zip(members, natures, strict=True)
        ],
        "nodes": [*_further_nodes(members[0].mission, options)],
    }
    if options.simulator is not None:
        known["simulator"] = name_of(options.simulator)
    return {"stage": json.dumps(known)}


def _further_nodes(mission: Mission, options: StageOptions) -> Iterator[tuple[str, str, str]]:
    """Yield file, target and name of the user's nodes that the mission's own file does not name.

    The file is empty for those that were given in Python.
    """
    for node in mission.nodes:
        if node.document is not mission.document:
            yield mission.portable_name(node.file), node.target, node.name
    for given in options.nodes:
        yield "", name_of(given), ""
