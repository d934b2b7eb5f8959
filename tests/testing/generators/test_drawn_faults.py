"""Faults can be drawn of every kind that the fixture has."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.core.draws import SeededDraws
from bt_mission.faults import FAULTS
from bt_mission.faults.drawing import drawn_faults
from bt_mission.testing.stages import Stages
from tests.support.thorough import sample

DRIVES = """\
mission: drives
world: empty_arena
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled > 0.6
      on_cancel: success
      timeout: 8
    - turn: {angle: 30}
      timeout: 8
"""


@pytest.mark.parametrize("name", sample(FAULTS, every=3))
def test_a_drawn_fault_can_begin(name: str, tmp_path: Path) -> None:
    """Whatever it breaks, the mission ends, and no goal is left that nobody names."""
    draws = SeededDraws(name)
    faults = next(result for _ in range(99) if (result := drawn_faults(draws, [name], ["drive"])))
    stages = Stages(tmp_path)
    try:
        run = stages.run(DRIVES)
        stages.plan(run, *faults[:2])
        try:
            run.until_done()
        except RuntimeError as error:
            assert str(error) == "made by a fault"  # noqa: PT017 - only some of them raise
        assert run.is_done or name == "raise_in_callback"
    finally:
        stages.close()
