"""What ``bt-mission sweep`` refuses, before a worker starts."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.sweeps.base import BaseChanges, load_base
from bt_mission.sweeps.store import ResultStore, SweepAbout
from bt_mission.sweeps.work import ScenarioWorker
from tests.sweeps.rows import row

MISSION = """\
mission: turns
world: empty_arena
inputs: {angle: 30, on: true}
tree:
  turn: {angle: $angle}
"""
PLANS = "plans:\n  lost: ['at 1.0: drop scan lasting 1']\n  odd: ['at 1.0: drip scan']\n"


@pytest.fixture
def mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A mission in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "turns.yaml").write_text(MISSION)
    (tmp_path / "plans.yaml").write_text(PLANS)
    (tmp_path / "nothing.yaml").write_text("plans: {}\n")
    (tmp_path / "topic.yaml").write_text("plans: {one: ['at 1.0: drop /nowhere lasting 1']}\n")
    (tmp_path / "wide.yaml").write_text("inputs: {angle: 1..9}\n")
    (tmp_path / "ends.yaml").write_text("inputs: {angle: [1, x]}\n")
    return "turns.yaml"


FAST = """\
mission: drives
inputs: {speed: 0.1}
tree:
  explore_forward: {fwd_velocity: $speed, stopping_distance: 0.5}
"""


@pytest.mark.parametrize("folder", ["", "mine/"])
@pytest.mark.parametrize(
    "words",
    [("sweep", "--vary", "speed=0.1,0.9"), ("falsify", "--within", "ranges.yaml")],
)
def test_an_error_in_a_varied_mission_names_its_file(
    mission: str, folder: str, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """Not the copy that a worker had."""
    path = Path(folder, "drives.yaml")
    path.parent.mkdir(exist_ok=True)
    path.write_text(FAST)
    Path("ranges.yaml").write_text("inputs: {speed: 0.1 .. 0.9}\n")
    command, *options = words
    assert main([command, str(path), *options]) == 2
    said = capsys.readouterr().err
    assert "max_linear_velocity" in said
    assert f", in {folder}drives.yaml:4:35" in said


def test_a_row_of_an_error_names_the_file_of_the_mission(mission: str) -> None:
    """A scenario between the ends of a parameter is loaded by a worker only."""
    Path("mine").mkdir()
    Path("mine/drives.yaml").write_text(FAST)
    base = load_base(Path("mine/drives.yaml"), BaseChanges())
    with ScenarioWorker(base.bundle) as worker:
        row = worker.carry_out(base.concrete({"speed": 0.9}))
    assert row.is_error
    assert row.reason.endswith(", in mine/drives.yaml:4:35")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--vary speed=0.1", "no input 'speed' (the mission's inputs: angle, on)"),
        ("--vary angl=1,2", "did you mean 'angle'?"),
        ("--vary angle=1,x", "input 'angle' expects a number, got string 'x'"),
        ("--vary angle=1..9", "draw some of them with --sample N"),
        ("--vary angle=", "'angle': expected values"),
        ("--vary angle=1 --vary angle=2", "'angle' is given twice"),
        ("--vary world=nowhere", "no such world"),
        ("--vary robot=crane", "no such robot"),
        ("--sample 3 --vary on=1..5", "on=1"),
        ("--fault-plan plans.yaml", "drip"),
        ("--fault-plan nothing.yaml", "expected plans"),
        ("--fault-plan turns.yaml", "unknown key 'mission'"),
        ("--within plans.yaml", "drip"),
        ("--within wide.yaml", "draw some of them with --sample N"),
        ("--within wide.yaml --vary angle=1,2", "'angle' is given twice"),
        ("--within ends.yaml", "ends.yaml:1:17: error: input 'angle' expects a number"),
        ("--fault-plan plans2.yaml", "no such file"),
        ("--fault-plan topic.yaml", "/nowhere"),
        ("--fault drop", "expected"),
        ("--require turns.yaml", "expected a mapping 'requirements:'"),
        ("--scheduler tcp://127.0.0.1:1", "no scheduler of Dask answers at tcp://127.0.0.1:1"),
        ("--scheduler nonsense://x", "no scheduler of Dask answers at nonsense://x"),
        ("--worker-memory much", "--worker-memory: expected an amount such as 2GiB"),
        ("--seeds 1000000000", "1,000,000,000 scenarios: say --yes if so many are meant"),
        ("-o turns.yaml", "cannot write turns.yaml"),
    ],
)
def test_bad_input_is_told_in_words(
    mission: str, capsys: pytest.CaptureFixture[str], words: str, message: str
) -> None:
    """With exit code 2 where the input is at fault; a scheduler may come later."""
    code = main(["sweep", mission, *words.split()])
    error = capsys.readouterr().err
    assert message in error
    assert code == (1 if "memory" in message or "answers" in message else 2)
    assert "Traceback" not in error


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--workers 0", "expected an integer from 1, got '0'"),
        ("--seeds 0", "'0' is no seed at all"),
        ("--seeds 3..1", "'3..1' is no seed at all"),
        ("--seeds 1,1", "a seed stands twice"),
        (f"--seeds {'9' * 400}", "a seed has at most 18 digits here"),
        ("--seeds many", "expected a number of seeds, A..B, or a list"),
        ("--sample 0", "expected an integer from 1"),
        ("--fail-below 95", "expected a share from 0 to 1, got '95'"),
        ("--dashboard 99999", "expected a port from 0 to 65535"),
        ("--record-worst -1", "expected an integer from 0"),
    ],
)
def test_options_that_are_none(
    mission: str, capsys: pytest.CaptureFixture[str], words: str, message: str
) -> None:
    """The parser says what it expects."""
    with pytest.raises(SystemExit) as left:
        main(["sweep", mission, *(f"{one}" for one in words.split())])
    assert left.value.code == 2
    assert message in capsys.readouterr().err


def test_what_is_to_be_installed(
    mission: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where there is no Dask."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["sweep", mission]) == 2
    assert "pip install 'bt-mission[sweep]'" in capsys.readouterr().err


def test_results_of_another_sweep_stay_as_they_are(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It says what differs."""
    about = SweepAbout(mission="turns", seeds="0..4")
    with ResultStore.create(tmp_path / "turns_sweep", about) as one:
        one.add(row(0))
    assert main(["sweep", mission, "--seeds", "3"]) == 2
    assert "add --resume to go on with it" in capsys.readouterr().err
    assert main(["sweep", mission, "--seeds", "3", "--resume"]) == 2
    assert 'seeds was "0..4", is "0..2"' in capsys.readouterr().err
