"""``bt-mission sweep``: what it prints, keeps and exits with; refusals are in transcripts/."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from bt_mission.commands.sweep.store import ResultStore, SweepAbout
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.testing.live_graph import command
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S, read_until, started
from tests.support.rows import row

TURNS = """\
mission: turns
world: empty_arena
inputs: {angle: 30}
requirements:
  turns little: always abs(yaw) < 50 deg
tree:
  sequence:
    - turn: {angle: $angle}
    - check: angle < 80
      name: small
"""

POISON = """\
mission: poison
world: empty_arena
inputs: {bad: 0}
tree:
  sequence:
    - python: leaves.py:Poison
      inputs: {bad: $bad}
    - wait: 0.2
"""

LEAVES = """\
import os
import signal

import py_trees


class Poison(py_trees.behaviour.Behaviour):
    bad: float

    def update(self):
        print("it says much")
        if self.bad > 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return py_trees.common.Status.SUCCESS
"""


def sweep(folder: Path, *words: str) -> tuple[int, dict[str, Any], str]:
    """Run it in a folder; gives its exit code, its object and its standard error."""
    ended = subprocess.run(
        command("sweep", *words, "--workers", "2", "--json"),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return ended.returncode, json.loads(ended.stdout or "{}"), ended.stderr


@pytest.mark.thorough
@pytest.mark.process
def test_a_sweep_from_its_start_to_its_end(tmp_path: Path) -> None:
    """Counts, rows, recordings of the worst with their pages; again, nothing is left to do."""
    (tmp_path / "turns.yaml").write_text(TURNS)
    words = ("turns.yaml", "--vary", "angle=30,60,90", "--seeds", "2")
    code, reported, error = sweep(tmp_path, *words)
    assert code == 0, error
    keys = ("scenarios", "succeeded", "failed", "errors", "orphaned_goals", "collisions", "of")
    assert [reported[key] for key in keys] == [6, 2, 4, 0, 0, 0, 6]
    assert reported["success_rate"] == pytest.approx(1 / 3)
    assert reported["interval"] == pytest.approx([0.0968, 0.7], abs=1e-4)
    reasons = {failure["reason"]: failure["count"] for failure in reported["failures"]}
    assert reasons == {
        "requirement violated: turns little": 2,
        "'small' does not hold (angle = 90)": 2,
    }
    folder = tmp_path / "turns_sweep"
    with ResultStore.read(folder) as store:
        rows = list(store.rows())
    assert [row.number for row in rows] == list(range(6))
    assert {row.parameters["angle"]: row.passed for row in rows} == {30: True, 60: False, 90: False}
    failed = {row.id for row in rows if not row.passed}
    assert {path.stem for path in (folder / "recordings").glob("*.mcap")} == failed
    assert {path.stem for path in (folder / "recordings").glob("*.html")} == failed
    page = (folder / "sweep.html").read_text(encoding="utf-8")
    assert set(re.findall(r'href="recordings/(.*?)\.html"', page)) == failed
    lines = re.sub("<.*?>", "", page)
    assert "bt-mission run turns.yaml --seed 0 --set angle=60" in lines
    assert "bt-mission sweep turns.yaml --vary angle=30,60,90 --seeds 2" in lines
    code, again, error = sweep(tmp_path, *words, "--resume", "--fail-below", "0.2")
    assert code == 1
    assert again["failures"] == reported["failures"]
    assert "below 0.2 or too uncertain: its interval begins at 0.0968" in error


@pytest.mark.thorough
@pytest.mark.process
def test_a_scenario_that_kills_its_workers_does_not_stop_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is marked, the others come out as ever; what leaves print is not among the results."""
    (tmp_path / "poison.yaml").write_text(POISON)
    (tmp_path / "leaves.py").write_text(LEAVES)
    # A worker that has died stays away for longer than Dask would wait for it.
    monkeypatch.setenv("DASK_DISTRIBUTED__DEPLOY__LOST_WORKER_TIMEOUT", "0s")
    words = ("poison.yaml", "--vary", "bad=0,-1,-2,1", "--record-worst", "0")
    code, reported, error = sweep(tmp_path, *words)
    assert code == 1
    assert (reported["succeeded"], reported["errors"]) == (3, 1), error
    assert [failure["reason"] for failure in reported["failures"]] == [
        "it killed its worker 3 times while it ran alone"
    ]
    assert "1 scenario could not run" in error


@pytest.mark.thorough
@pytest.mark.process
def test_ctrl_c_ends_it_with_what_is_there(cli: CommandLine) -> None:
    """The same command continues."""
    cli.write("turns.yaml", TURNS)
    words = ("sweep", "turns.yaml", "--seeds", "400", "--workers", "1", "--record-worst", "0")
    with started(*words) as process:
        read_until(process, "/s ")  # there is a rate once there is a row
        process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=PATIENCE_S)[0]
        assert process.returncode == 130, rest
    assert "stopped by SIGINT" in rest
    assert "the same command with --resume continues" in rest
    assert "succeeded (" in rest
    with ResultStore.read(Path("turns_sweep")) as store:
        assert 0 < len(store.ids()) < 400


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
    assert "pip install 'bt-mission[sweep]'" in cli.refused(f"sweep {cli.write('m.yaml', TURNS)}")


def test_results_of_another_sweep_are_kept(cli: CommandLine) -> None:
    """The error says what differs."""
    cli.write("turns.yaml", TURNS)
    about = SweepAbout(mission="turns", seeds="0..4")
    with ResultStore.create(Path("turns_sweep"), about) as store:
        store.add(row(0))
    assert "add --resume to continue it" in cli.refused("sweep turns.yaml --seeds 3")
    error = cli.refused("sweep turns.yaml --seeds 3 --resume")
    assert 'seeds was "0..4", is "0..2"' in error


def test_another_simulator_is_code_that_can_be_refused(cli: CommandLine) -> None:
    """As for a run; its scenarios would have it."""
    cli.write("nap.yaml", "mission: nap\ntree: {wait: 1}\n")
    cli("sweep nap.yaml --simulator sim.ir_sim:IrSim --no-python", 2)
    assert "the Python node 'sim.ir_sim:IrSim' is refused [BT-216]" in cli.err
