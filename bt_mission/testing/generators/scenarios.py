"""Whole scenarios: a world, a mission, a seed, and faults at their times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import indent
from typing import Any

import yaml  # type: ignore[import-untyped]

from bt_mission.testing.generators.draws import Draws
from bt_mission.testing.generators.faults import PlannedFault, drawn_faults
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import Run
from bt_mission.testing.stages import Stages


@dataclass(frozen=True)
class Scenario:
    """Everything that a run follows from; what it looks like is a test that repeats it."""

    mission: str
    world: str
    seed: int
    faults: tuple[PlannedFault, ...]

    def on(self, stage: Stages) -> Run:
        """Put it on a stage, ready for its first step."""
        run = stage.run(self.mission, world=self.world, seed=self.seed)
        for fault in self.faults:
            fault.plan(stage, run)
        return run

    def __repr__(self) -> str:
        faults = "".join(f"    {fault!r}\n" for fault in self.faults)
        return (
            "\ndef test_it(stage):\n"
            f'    mission = """\n{indent(self.mission, "    ")}    """\n'
            f'    world = """\n{indent(self.world, "    ")}    """\n'
            f"    run = stage.run(mission, world=world, seed={self.seed})\n"
            f"{faults}"
            "    run.until_done()\n"
        )


def drawn_scenario(draws: Draws, faults: Sequence[str] = ()) -> Scenario:
    """A scenario; it ends in bounded time."""
    mission, world = as_text(drawn_mission(draws)), as_text(drawn_world(draws))
    return Scenario(mission, world, draws.whole(0, 999), drawn_faults(draws, faults))


def as_text(data: dict[str, Any]) -> str:
    """The file of this data."""
    return str(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100))
