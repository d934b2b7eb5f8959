"""Errors of `bt-mission sweep`; most of its refusals are in transcripts/sweeps.txt."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bt_mission.sweeps.base import BaseChanges, load_base
from bt_mission.sweeps.store import ResultStore, SweepAbout
from bt_mission.sweeps.work import ScenarioWorker
from tests.support.command_line import CommandLine
from tests.sweeps.rows import row

MISSION = "mission: turns\nworld: empty_arena\ninputs: {angle: 30}\ntree: {turn: {angle: $angle}}\n"
FAST = """\
mission: drives
inputs: {speed: 0.1}
tree:
  explore_forward: {fwd_velocity: $speed, stopping_distance: 0.5}
"""


def test_a_row_of_an_error_names_the_file_of_the_mission(cli: CommandLine) -> None:
    """Only a worker loads a scenario between the ends of a parameter, and it has a copy."""
    base = load_base(Path(cli.write("mine/drives.yaml", FAST)), BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        result = worker.carry_out(base.concrete({"speed": 0.9}))
    assert result.is_error
    assert result.reason.endswith(", in mine/drives.yaml:4:35")


def test_without_dask_it_says_what_to_install(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dask is an extra."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'bt-mission[sweep]'" in cli.refused(f"sweep {cli.write('m.yaml', MISSION)}")


def test_results_of_another_sweep_are_kept(cli: CommandLine) -> None:
    """The error says what differs."""
    cli.write("turns.yaml", MISSION)
    with ResultStore.create(
        Path("turns_sweep"), SweepAbout(mission="turns", seeds="0..4")
    ) as store:
        store.add(row(0))
    assert "add --resume to continue it" in cli.refused("sweep turns.yaml --seeds 3")
    error = cli.refused("sweep turns.yaml --seeds 3 --resume")
    assert 'seeds was "0..4", is "0..2"' in error
