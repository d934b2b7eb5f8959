"""A search for what no run has reached."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncGenerator, Iterable
from dataclasses import replace
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.coverage.record import CoverageRecord
from bt_mission.search.session import CoverSession, SearchOptions
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.ranges import RangesFile
from bt_mission.sweeps.row import ScenarioRow
from tests.search.conftest import MISSION, row


class CoveringRunner:
    """Reaches the first place always, and of the others the one of each scenario's number."""

    def __init__(self, places: int, most: int) -> None:
        self._digits = -(-places // 4)
        self._most = most

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        for scenario in scenarios:
            bits = 1 | 1 << min(scenario.number, self._most)
            yield replace(row(scenario, 0.5), coverage=f"{bits:0{self._digits}x}")


def covered(base: BaseScenario, most: int, budget: int) -> CoverSession:
    """Search with a runner that reaches no place after so many."""
    options = SearchOptions(budget=budget, strategy="random")
    session = CoverSession(base, RangesFile(), options, lambda _: True)
    places = len(session.state.record.names)
    asyncio.run(session.run(CoveringRunner(places, most)))
    return session


def test_it_ends_when_everything_is_reached(base: BaseScenario) -> None:
    """And tells by which scenario each place was."""
    count = len(CoverageRecord.of(base.mission).names)
    state = covered(base, count - 1, 100).state
    assert state.record.missing == ()
    assert [new for _, _, new in state.first] == [(name,) for name in state.record.names]


def test_what_it_cannot_reach_is_listed(base: BaseScenario) -> None:
    """Once the budget is used up."""
    state = covered(base, 3, 20).state
    assert state.runs == 20
    assert state.record.missing == state.record.names[4:]
    assert not state.is_interrupted


def test_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Faults of servers reach ways to end that the mission alone does not."""
    (tmp_path / "short.yaml").write_text(MISSION.replace("0.4}", "1.4}"))
    (tmp_path / "ranges.yaml").write_text("faults: {kinds: [kill_server, abort_goal]}")
    monkeypatch.chdir(tmp_path)
    words = ["falsify", "short.yaml", "--cover", "--within", "ranges.yaml", "--workers", "1"]
    assert main([*words, "--budget", "20", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["runs"] == 20
    assert "0 drive: outcome succeeded" in data["reached"]
    assert {"0 drive: outcome aborted", "0 drive: outcome server lost"} <= set(data["reached"])
    assert "0 drive: outcome canceled by another client" in data["missing"]
    assert data["scenarios"][0]["faults"] == []
    assert len(data["reached"]) + len(data["missing"]) == data["places"]
