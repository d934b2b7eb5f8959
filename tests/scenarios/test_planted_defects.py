"""Planted defects, each of which violates a requirement of a shipped scenario.

The table names the requirement. Without a defect the scenarios pass: pytest runs them as tests of
their own.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.scenarios.run import run_scenario
from tests.support.planted_defects import DEFECTS
from tests.support.planting import Defect
from tests.support.thorough import sample

SCENARIOS = Path("missions/scenarios")


@pytest.mark.parametrize("defect", sample(DEFECTS, every=24), ids=lambda planted: planted.what)
def test_a_defect_is_caught(defect: Defect, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the requirement that the table names."""
    defect.plant(monkeypatch)
    result = run_scenario(SCENARIOS / f"{defect.scenario}.scenario.yaml")
    assert defect.caught_by in result.violated, "\n".join(map(str, result.report.requirements))
