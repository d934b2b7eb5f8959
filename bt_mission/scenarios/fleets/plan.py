"""What a fleet file says: robots in one world, each with its mission."""

from __future__ import annotations

from dataclasses import dataclass, field

from bt_mission.base.text import counted, escape_control
from bt_mission.base.yaml.document import Document
from bt_mission.language.mission import NodeFactory
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions
from sim.world.world import World


@dataclass(frozen=True)
class FleetPlan:
    """Several robots, and where they are.

    Attributes:
        seed: Of all sensor noise.
        robots: In the order of the file.
        nodes: The user's nodes that all robots share.
    """

    name: str
    world: World
    seed: int
    robots: tuple[FleetRobot, ...]
    description: str = ""
    nodes: tuple[NodeFactory, ...] = ()
    document: Document = field(repr=False, compare=False, kw_only=True)

    @property
    def file(self) -> str:
        """Where it is written."""
        return self.document.file

    @property
    def title(self) -> str:
        """Name, world and number of robots, for people."""
        robots = counted(len(self.robots), "robot")
        return escape_control(f"{self.name} in {self.world.name} ({robots}, seed {self.seed})")

    @property
    def stage_options(self) -> StageOptions:
        """How its stage is set up."""
        return StageOptions(world=self.world, seed=self.seed, nodes=self.nodes)
