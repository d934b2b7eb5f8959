"""The line that a recording gets for each control step: what has changed, and nothing else."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

from bt_mission.language.mission import Requirement
from bt_mission.recording.signal_samples import SignalSamples
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.syntax import SignalValue

NONE_OPEN = {"open_goals": 0, "accepted_goals": []}


class Mission:
    """A mission whose signals a test sets; takes the place of its runner, too."""

    def __init__(self, *formulas: str) -> None:
        self.lines: list[dict[str, Any]] = []
        self.values: dict[str, Any] = {}
        self.truths: dict[str, Any] = {}
        self.now_ns = 0
        self.scope = SimpleNamespace(values={})
        self.ledger = SimpleNamespace(open_goals=())
        self.executive = SimpleNamespace(started_ns=5, cycles=1)
        results = [Requirement(formula, formula) for formula in formulas]
        self.mission = SimpleNamespace(requirements=results)
        self.signals = self
        self.requirements = self
        self.samples = SignalSamples(self, self._take, lambda call: call)  # type: ignore[arg-type]

    def _take(self, line: str) -> None:
        self.lines.append(json.loads(line))

    def add_sampler(self, sample: Any) -> None:
        """Take what samples."""
        self._sample = sample

    def simulation(self) -> None:
        """There is none."""

    def truth(self) -> tuple[bytes, dict[str, Any]]:
        """Return the true values."""
        return b"", dict(self.truths)

    def reader(self, signal: SignalValue) -> Reader:
        """Return what reads a signal."""
        return lambda: self.values[signal.key]

    def step(self) -> Any:
        """Sample a control step; return the values in its line, None without any."""
        self.now_ns += 50
        self._sample()
        assert self.lines[-1]["t"] == self.now_ns
        return self.lines[-1].get("values")


def test_a_line_has_only_what_has_changed() -> None:
    """Of what is read at each step, of what is true, and of variables."""
    mission = Mission("always feedback('drive', 'speed') < 1", "never collisions > 0")
    speed = "feedback('drive', 'speed')"
    mission.values = {speed: 0.5, "collisions": 0}
    mission.truths = {"collisions": 0}
    mission.scope.values = {"count": 1}
    assert mission.step() == NONE_OPEN | {speed: 0.5, "collisions": 0, "$count": 1}
    first = mission.lines[0]
    assert (first["start"], first["cycle"]) == (5, 1)
    assert first["keys"] == [*NONE_OPEN, speed, "collisions"]
    assert mission.step() is None
    mission.values[speed] = None
    goal = SimpleNamespace(accepted=False, id=b"\1")
    mission.ledger.open_goals = (goal,)
    assert mission.step() == {"open_goals": 1, speed: None}
    goal.accepted = True
    assert mission.step() == {"accepted_goals": ["01"]}
    mission.values["collisions"] = mission.truths["collisions"] = 1
    assert mission.step() == {"collisions": 1}
    mission.scope.values["count"] = 2
    assert mission.step() == {"$count": 2}
    del mission.scope.values["count"]
    assert mission.step() == {"$count": None}
    assert mission.step() is None


def test_another_type_of_an_equal_value_is_a_change() -> None:
    """A requirement tells true from 1, and 1 from 1.0."""
    mission = Mission("always $one == 1")
    mission.values = {"$one": True}
    mission.scope.values = {"one": True, "other": 0}
    assert mission.step() == NONE_OPEN | {"$one": True, "$other": 0}
    mission.scope.values = {"one": 1, "other": 0}
    mission.values = {"$one": 1}
    changed = mission.step()
    assert changed == {"$one": 1}
    assert changed["$one"] is not True
    mission.scope.values = {"one": 1, "new": 0}
    assert mission.step() == {"$new": 0, "$other": None}
