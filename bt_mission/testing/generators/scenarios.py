"""Whole scenarios: a world, a mission, a seed, and faults at their times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml  # type: ignore[import-untyped]

from bt_mission.base.yaml.document import read_text
from bt_mission.scenarios.draws import Draws
from bt_mission.scenarios.faults import PlannedFault
from bt_mission.scenarios.faults.drawing import drawn_faults
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import Run
from bt_mission.testing.stages import Stages


@dataclass(frozen=True, repr=False)
class DrawnScenario:
    """Everything that a run follows from, as texts; it looks like the scenario file of that run."""

    mission: str
    world: str
    seed: int
    faults: tuple[PlannedFault, ...]

    def on(self, stage: Stages) -> Run:
        """Put it on a stage, ready for its first step."""
        run = stage.run(self.mission, world=self.world, seed=self.seed)
        stage.plan(run, *self.faults)
        return run

    @property
    def text(self) -> str:
        """The scenario as a file."""
        return as_text(
            {
                "scenario": "drawn",
                "mission": read_text(self.mission).data,
                "world": read_text(self.world).data,
                "seed": self.seed,
                "faults": [fault.text for fault in self.faults],
            }
        )

    def __repr__(self) -> str:
        return f"\n{self.text}"


def drawn_scenario(draws: Draws, faults: Sequence[str] = ()) -> DrawnScenario:
    """A scenario; it ends in bounded time."""
    mission, world = as_text(drawn_mission(draws)), as_text(drawn_world(draws))
    return DrawnScenario(mission, world, draws.whole(0, 999), drawn_faults(draws, faults))


def as_text(data: dict[str, Any]) -> str:
    """The file of this data."""
    return str(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100))
