"""Whole scenarios: a world, a mission, a seed, and faults at their times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from textwrap import indent
from typing import Any

import yaml  # type: ignore[import-untyped]

from bt_mission.testing.generators.draws import Draws, number, one_of
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.run import Run
from bt_mission.testing.stages import Stages

MOST_FAULTS = 5
LATEST_S = 20.0
LONGEST_S = 3.0

TOPICS = ("scan", "odom", "cmd_vel", "tf")
ACTIONS = ("turn", "explore_forward", "move", "spin")
CORRUPTIONS = ("nan", "zeros", "empty", "old stamp", "wrong frame")


@dataclass(frozen=True)
class PlannedFault:
    """One of ``stage.faults``, to begin at a time.

    Args:
        time: S since the start.
        name: Of the method that makes it.
    """

    time: float
    name: str
    arguments: tuple[Any, ...]
    options: dict[str, Any] = field(default_factory=dict)

    def plan(self, stage: Stages, run: Run) -> None:
        """Have it begin at its time."""
        run.at(self.time, getattr(stage.faults, self.name)(*self.arguments, **self.options))

    def __repr__(self) -> str:
        given = [*map(repr, self.arguments), *(f"{k}={v!r}" for k, v in self.options.items())]
        return f"run.at({self.time!r}, stage.faults.{self.name}({', '.join(given)}))"


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


def drawn_scenario(draws: Draws) -> Scenario:
    """A scenario; it ends in bounded time."""
    mission, world = as_text(drawn_mission(draws)), as_text(drawn_world(draws))
    return Scenario(mission, world, draws.whole(0, 999), drawn_faults(draws))


def drawn_faults(draws: Draws) -> tuple[PlannedFault, ...]:
    """Some faults of topics and of action servers, each of which ends by itself."""
    return tuple(_fault(draws) for _ in range(draws.whole(0, MOST_FAULTS)))


def as_text(data: dict[str, Any]) -> str:
    """The file of this data."""
    return str(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=100))


def _fault(draws: Draws) -> PlannedFault:
    time = number(draws, 0.25, LATEST_S, 0.25)
    name, arguments, options = one_of(draws, _FAULTS)
    given = arguments(draws)
    named = {option: draw(draws) for option, draw in options.items()}
    named["lasting"] = number(draws, 0.25, LONGEST_S, 0.25)
    return PlannedFault(time, name, given, named)


Draw = Callable[[Draws], float]


def _delay(draws: Draws) -> tuple[str, float]:
    by = number(draws, 0.05, 0.5, 0.05)
    return one_of(draws, TOPICS), by


def _topic(draws: Draws) -> tuple[str]:
    return (one_of(draws, TOPICS),)


def _goals(draws: Draws) -> tuple[str, int]:
    return one_of(draws, ACTIONS), draws.whole(1, 3)


def _late(draws: Draws) -> tuple[str, float]:
    return one_of(draws, ACTIONS), number(draws, 0.1, 1.5, 0.1)


_FAULTS: tuple[tuple[str, Callable[[Draws], tuple[Any, ...]], dict[str, Draw]], ...] = (
    ("drop", _topic, {"share": lambda draws: number(draws, 0.25, 1, 0.25)}),
    ("delay", _delay, {"jitter": lambda draws: number(draws, 0, 0.1, 0.05)}),
    ("duplicate", _topic, {}),
    ("freeze", _topic, {}),
    ("corrupt", lambda draws: ("scan", one_of(draws, CORRUPTIONS)), {}),
    ("reject_goals", _goals, {}),
    ("delay_answers", _late, {}),
    ("delay_results", _late, {}),
    ("refuse_cancels", _goals, {}),
    ("slow_server", _late, {}),
    ("silence_feedback", lambda draws: (one_of(draws, ACTIONS),), {}),
)
