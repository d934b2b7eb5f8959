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
from bt_mission.executive.events.events import EventStream, NodeChanged, NodeInfo, RunStarted
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.leaf_statistics import LeafStatistics, LeafSummary

S = 1_000_000_000


@pytest.mark.parametrize(
    ("changes", "summary"),
    [
        (
            [
                (1.0, 0.0, Status.RUNNING),
                (3.5, 0.5, Status.SUCCESS),
                (4.0, 2.0, Status.RUNNING),
                (5.0, 2.25, Status.FAILURE),
            ],
            (2, {"success": 1, "failure": 1}, 3.5, 0.75),
        ),
        (
            [(1.0, 0.0, Status.SUCCESS), (2.0, 0.0, Status.INVALID), (3.0, 0.0, Status.SUCCESS)],
            (2, {"success": 2}, 0.0, 0.0),
        ),
        (
            [(1.0, 0.0, Status.RUNNING), (1.5, 0.0, Status.INVALID), (1.5, 0.0, Status.INVALID)],
            (1, {"halted": 1}, 0.5, 0.0),
        ),
        (
            [(1.0, None, Status.RUNNING), (2.0, None, Status.SUCCESS)],
            (1, {"success": 1}, 1.0, None),
        ),
        ([(1.0, 0.0, Status.RUNNING)], None),
    ],
    ids=[
        "runs are added up",
        "what ends within a tick has run, and one that does not run cannot be halted",
        "a leaf may be halted",
        "attached to a robot no distance is known",
        "what still runs has come to nothing yet",
    ],
)
def test_a_leaf_is_counted(changes: Any, summary: Any) -> None:
    """Changes are at a time, s, and after some metres; composites follow from their leaves."""
    events, state = EventStream(), MissionState()
    leaf = Dummy("leaf")
    nodes = (NodeInfo("all", "Sequence", "0", 0), NodeInfo("leaf", "Dummy", "0.1", 0))
    state.apply(RunStarted(S, "run", "all", nodes))
    events.subscribe(state.apply)
    executive: Any = SimpleNamespace(
        events=events,
        mission_state=state,
        nodes=(Sequence("all", memory=True, children=[leaf]), leaf),
    )
    metres: list[float | None] = [0.0]
    tally = LeafStatistics(executive, lambda: metres[-1])
    events.emit(NodeChanged(S, 0, Status.SUCCESS, ""))
    for time_s, driven_m, status in changes:
        metres.append(driven_m)
        events.emit(NodeChanged(round(time_s * S), 1, status, ""))
    assert tally.summaries() == ((LeafSummary("leaf", "0.1", *summary),) if summary else ())


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
