"""What a stage is made of besides the mission: the files of world and robots, and its options."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bt_mission.core.files import find
from bt_mission.core.yaml.document import Document, read
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

DEFAULT_WORLD = "empty_arena"


@dataclass(frozen=True)
class StageFiles:
    """The files of the world, and of each robot."""

    world: Document
    robots: tuple[Document, ...]

    @classmethod
    def find(cls, members: Sequence[FleetRobot], options: StageOptions) -> StageFiles:
        """Read them, unless the options have their text. Raises InputError."""
        first = members[0].mission
        world = options.world or first.world or DEFAULT_WORLD
        if not isinstance(world, Document):
            world = read(find("worlds", world, first.file))
        robots = (
            options.robot or read(find("robots", one.mission.robot, one.mission.file))
            for one in members
        )
        return cls(world, tuple(robots))

    @property
    def texts(self) -> Mapping[str, str]:
        """Return what a recording keeps of them, by names without the folders of this machine."""
        parts = {f"worlds/{Path(self.world.file).name}": self.world.text}
        return parts | {f"robots/{Path(one.file).name}": one.text for one in self.robots}


def stage_facts(members: Sequence[FleetRobot], options: StageOptions) -> Mapping[str, str]:
    """Return what else of a stage a run depends on, as JSON, for those who run it again."""
    seed = members[0].mission.seed if options.seed is None else options.seed
    known = {
        "sensor_seed": seed,
        "props": options.props,
        "without": sorted(options.without),
        "has_tools": options.has_tools,
        "is_visible": options.visible,
        "robots": [one.name for one in members],
    }
    return {"stage": json.dumps(known)}
