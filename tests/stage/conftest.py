"""Whole missions on the stage, in virtual time."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from bt_mission.common.data import find
from bt_mission.mission import load, load_text
from bt_mission.mission.loaded import Mission
from bt_mission.stage import Stage

LIMIT_S = 600.0
"""Virtual seconds after which a mission under test counts as one that never ends."""


@dataclass
class Run:
    """A mission on the stage, with everything its trace says."""

    stage: Stage
    events: list[dict[str, Any]]
    said: list[str]

    @property
    def seconds(self) -> float:
        """Virtual time since the start."""
        return (self.stage.now_ns - self.stage.start_ns) / 1e9

    @property
    def status(self) -> str:
        return str(self.stage.executive.status)

    @property
    def reason(self) -> str:
        return self.stage.executive.reason

    @property
    def pose(self) -> tuple[float, float, float]:
        return self.stage.sim.simulation.pose

    def until(self, condition: Callable[[], bool]) -> None:
        """Step until a condition holds."""
        while not condition():
            assert not self.stage.is_done, f"ended as {self.status}: {self.reason}"
            self.stage.step()

    def until_done(self) -> None:
        """Step to the end."""
        while not self.stage.is_done:
            assert self.seconds < LIMIT_S, "the mission does not end"
            self.stage.step()

    def of(self, event: str) -> list[dict[str, Any]]:
        """The events of one kind, in order."""
        return [one for one in self.events if one.get("event") == event]

    def path_length(self, start_ns: int, end_ns: int) -> float:
        """Length of the true path between two times, from the pose of every tick, m."""
        poses = [p for p in self.of("pose") if start_ns <= p["t"] <= end_ns]
        return sum(math.hypot(b["x"] - a["x"], b["y"] - a["y"]) for a, b in pairwise(poses))


@pytest.fixture
def on_stage(tmp_path: Path) -> Iterator[Callable[..., Run]]:
    """Put a mission on a stage: ``on_stage("explore", seed=3)`` or ``on_stage(text=...)``.

    Two stages of one process would hear each other, so the one before is closed.
    """
    with ExitStack() as stages:

        def start(name: str = "", *, text: str = "", **overrides: Any) -> Run:
            mission: Mission = (
                load_text(text, **overrides) if text else load(find("missions", name), **overrides)
            )
            stages.close()
            said: list[str] = []
            stage = stages.enter_context(Stage(mission, image_folder=tmp_path, say=said.append))
            run = Run(stage, [], said)
            run.events += [json.loads(line) for line in stage.trace.newest]
            stage.trace.listeners.append(lambda line: run.events.append(json.loads(line)))
            return run

        yield start
