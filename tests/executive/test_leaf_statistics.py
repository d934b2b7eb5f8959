"""What each leaf of a run came to."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.behaviours import Dummy
from py_trees.common import Status
from py_trees.composites import Sequence

from bt_mission.cli import main
from bt_mission.events.events import EventStream, NodeChanged, NodeInfo, RunStarted
from bt_mission.events.mission_state import MissionState
from bt_mission.executive.leaf_statistics import LeafStatistics, LeafSummary

S = 1_000_000_000


class Counted:
    """A tally of a sequence with one leaf, whose events come while the robot drives."""

    def __init__(self, metres: float | None = 0.0) -> None:
        self.metres = metres
        self.events = EventStream()
        leaf, state = Dummy("leaf"), MissionState()
        nodes = (NodeInfo("all", "Sequence", "0", 0), NodeInfo("leaf", "Dummy", "0.1", 0))
        state.apply(RunStarted(S, "run", "all", nodes))
        self.events.subscribe(state.apply)
        executive: Any = SimpleNamespace(
            events=self.events,
            mission_state=state,
            nodes=(Sequence("all", memory=True, children=[leaf]), leaf),
        )
        self.tally = LeafStatistics(executive, lambda: self.metres)

    def change(self, time_s: float, status: Status, node: int = 1) -> None:
        """The leaf changes its status."""
        self.events.emit(NodeChanged(round(time_s * S), node, status, ""))

    @property
    def summary(self) -> LeafSummary:
        (summary,) = self.tally.summaries()
        return summary


def test_runs_are_added_up() -> None:
    """Times, metres and outcomes."""
    counted = Counted()
    counted.change(1.0, Status.RUNNING)
    counted.metres = 0.5
    counted.change(3.5, Status.SUCCESS)
    counted.metres = 2.0
    counted.change(4.0, Status.RUNNING)
    counted.metres = 2.25
    counted.change(5.0, Status.FAILURE)
    assert counted.summary == LeafSummary(
        "leaf", "0.1", 2, {"success": 1, "failure": 1}, running_s=3.5, distance_m=0.75
    )


def test_what_ends_within_a_tick_has_run() -> None:
    """For no time."""
    counted = Counted()
    counted.change(1.0, Status.SUCCESS)
    counted.change(2.0, Status.INVALID)
    counted.change(3.0, Status.SUCCESS)
    assert counted.summary == LeafSummary("leaf", "0.1", 2, {"success": 2}, 0.0, 0.0)


def test_a_leaf_may_be_halted() -> None:
    """One that does not run cannot be."""
    counted = Counted()
    counted.change(1.0, Status.RUNNING)
    counted.change(1.5, Status.INVALID)
    counted.change(1.5, Status.INVALID)
    assert counted.summary == LeafSummary("leaf", "0.1", 1, {"halted": 1}, 0.5, 0.0)


def test_where_distance_is_not_known_there_is_none() -> None:
    """As attached to a robot."""
    counted = Counted(None)
    counted.change(1.0, Status.RUNNING)
    counted.change(2.0, Status.SUCCESS)
    assert counted.summary.distance_m is None


def test_leaves_alone_are_counted() -> None:
    """Composites follow from them, and what still runs has come to nothing yet."""
    counted = Counted()
    counted.change(1.0, Status.SUCCESS, node=0)
    counted.change(1.0, Status.RUNNING)
    assert counted.tally.summaries() == ()


MISSION = """\
mission: m
world: empty_arena
tree:
  sequence:
    - turn: {angle: 20}
      name: look left
      timeout: 30
    - parallel:
        - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
          name: drive
          timeout: 60
        - wait: 2
      succeed_when: any
"""


def test_a_run_tells_of_its_leaves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In its JSON; goals by the outcomes of the mission language."""
    path = tmp_path / "m.yaml"
    path.write_text(MISSION, encoding="utf-8")
    assert main(["run", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    result: dict[str, Any] = {leaf["name"]: leaf for leaf in report["leaves"]}
    assert list(result) == ["look left", "drive", "wait"]
    assert result["look left"]["outcomes"] == {"succeeded": 1}
    assert result["look left"]["distance_m"] < 0.02
    assert result["drive"]["outcomes"] == {"canceled by halt": 1}
    assert result["drive"]["running_s"] == 2.0
    assert 0.2 < result["drive"]["distance_m"] < 0.4
    assert result["wait"]["outcomes"] == {"success": 1}
    assert result["wait"]["path"] == "0.1.1"


def test_a_pipe_gets_the_short_summary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A terminal gets the table, too."""
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ntree: {wait: 0.5}\n", encoding="utf-8")
    assert main(["run", str(path)]) == 0
    assert "leaf" not in capsys.readouterr().out
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert main(["run", str(path), "--plain"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "  leaf  runs    time  driven  outcomes",
        "  wait     1  0.50 s  0.00 m  succeeded",
    ]
