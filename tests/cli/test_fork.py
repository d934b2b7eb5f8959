"""Forks of recorded runs from the command line."""

from __future__ import annotations

import shutil
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from bt_mission.cli.fork import fork_shown
from bt_mission.executive.stored_trace import read_trace
from tests.support.forks import MISSION, WAYS, forked, record_mission, refused
from tests.support.recordings import recording


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A recorded run."""
    return str(record_mission(tmp_path_factory.mktemp("fork")))


def test_without_a_change_the_same_happens_again(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """From the recording alone: the files on the disk are others by now, or gone."""
    folder = Path(run).parent
    trace = folder / "again.jsonl"
    told = forked(capsys, run, "--at", "2", "--trace", str(trace))
    assert (told["is_identical"], told["first_difference"]) == (True, None)
    assert trace.read_bytes() == (folder / "run.jsonl").read_bytes()
    assert told["forked"]["requirements"] == told["recorded"]["requirements"]
    assert told["forked"]["trace_sha256"] == read_trace(folder / "run.jsonl").sha256


def test_a_variable_has_another_value_from_the_instant_on(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The drive that is under way keeps its speed, the next one is slower."""
    told = forked(capsys, run, "--at", "1", "--set", "speed=0.1")
    leaves = {one["path"]: one["running_s"] for one in told["forked"]["leaves"]}
    recorded = forked(capsys, run, "--at", "1")["forked"]
    before = {one["path"]: one["running_s"] for one in recorded["leaves"]}
    assert leaves["0.1.0"] == before["0.1.0"]
    assert leaves["0.3.0"] > 1.5 * before["0.3.0"]
    assert told["change"] == {
        "set": {"speed": 0.1},
        "mission": None,
        "from_start": False,
        "faults": [],
    }
    assert told["first_difference"]["time_s"] > 1


def test_people_are_told_both_outcomes(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """And the control step, where the instant lies between two."""
    assert main(["fork", run, "--at", "1.01", "--set", "angle=-45"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("recorded: success at ")
    assert lines[1].startswith(
        "forked at 1.05 s (the control step after 1.01 s) with angle=-45: success at "
    )
    assert "requirement has power: holds by 79.9" in lines[3]
    assert "(recorded: holds by 79.9" in lines[3]
    assert "first difference (< recorded, > forked):" in lines[4]


def test_a_variable_that_is_no_input_is_set_too(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """As long as it holds a value of that type."""
    told = forked(capsys, run, "--at", "1", "--set", "way=0.1")
    assert told["forked"]["distance_travelled_m"] < 0.5
    assert "'way' is a number at that instant" in refused(
        capsys, run, "--at", "1", "--set", "way=far"
    )


def test_a_fork_is_recorded_as_one(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the change in its log; it says itself that it is no run that can be forked."""
    path = tmp_path / "fork.mcap"
    forked(capsys, run, "--at", "1", "--set", "speed=0.1", "--record", str(path))
    assert main(["replay", str(path), "--plain"]) == 0
    assert "forked here: speed=0.1" in capsys.readouterr().out
    error = refused(capsys, str(path), "--at", "1")
    assert "it is itself a fork, of the run in run.mcap: fork that one" in error


def test_the_same_run_again_can_be_forked(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recording of a fork without a change is as good as the first."""
    path = tmp_path / "again.mcap"
    forked(capsys, run, "--at", "1", "--record", str(path))
    assert forked(capsys, str(path), "--at", "3")["is_identical"]


def test_a_requirement_is_added(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is told of it is no difference; one that is violated decides the exit code."""
    path = tmp_path / "slow.yaml"
    path.write_text("requirements:\n  is slow: always speed < 0.15\n", encoding="utf-8")
    told = forked(capsys, run, "--at", "3", "--require", str(path))
    verdicts = {one["name"]: one["verdict"] for one in told["forked"]["requirements"]}
    assert verdicts == {"has power": "holds", "is slow": "violated"}
    assert told["is_identical"]
    words = ("--at", "3", "--set", "speed=0.1", "--require", str(path))
    assert forked(capsys, run, *words, code=1)["forked"]["status"] == "success"


def edit(folder: Path, old: str, new: str, ways: str = WAYS) -> str:
    """The recorded mission's file with something in it replaced."""
    assert old in MISSION
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "ways.yaml").write_text(ways, encoding="utf-8")
    path = folder / "edited.yaml"
    path.write_text(MISSION.replace(old, new), encoding="utf-8")
    return str(path)


def running_s(told: Any) -> dict[str, float]:
    """How long each leaf of a fork ran, by its name and place."""
    leaves = told["forked"]["leaves"]
    return {f"{one['name']} {one['path']}": one["running_s"] for one in leaves}


def test_an_edited_mission_goes_on_from_the_instant(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What runs there ends as it began; what begins later begins as edited, in all trees."""
    before = running_s(forked(capsys, run, "--at", "1"))
    slow = WAYS.replace("fwd_velocity: $speed", "fwd_velocity: 0.1")
    path = edit(tmp_path, "angle: $angle}", "angle: 45}", slow)
    told = forked(capsys, run, "--at", "1", "--mission", path)
    assert told["change"] == {"set": {}, "mission": path, "from_start": False, "faults": []}
    after = running_s(told)
    assert after["drive 0.1.0"] == before["drive 0.1.0"]
    assert after["turn away 0.2"] < 0.7 * before["turn away 0.2"]
    assert after["drive 0.3.0"] > 1.5 * before["drive 0.3.0"]


def test_an_edited_input_has_its_value_from_the_instant_on(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As with --set."""
    path = edit(tmp_path, "angle: 90}", "angle: 45}")
    told = forked(capsys, run, "--at", "1", "--mission", path)
    assert told["change"]["set"] == {"angle": 45}
    assert not forked(capsys, run, "--at", "1", "--set", "angle=45")["is_identical"]
    sha = {
        forked(capsys, run, "--at", "1", *words)["forked"]["distance_travelled_m"]
        for words in (["--mission", path], ["--set", "angle=45"])
    }
    assert len(sha) == 1


def test_a_mission_with_more_nodes_runs_from_the_start(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where it does the same up to the fork; else the first difference is told."""
    more = "    - wait: 1\n    - turn: {angle: $angle}"
    path = edit(tmp_path, "    - turn: {angle: $angle}", more)
    told = forked(capsys, run, "--at", "1", "--mission", path)
    assert told["change"]["from_start"]
    assert told["forked"]["virtual_s"] > told["recorded"]["virtual_s"] + 0.9
    error = refused(capsys, run, "--at", "4", "--mission", path)
    assert "it is not the same up to 4.00 s" in error
    assert f"the edited mission has another tree: {path}:12:7: " in error


def test_a_change_that_nothing_reads(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Is said to make no difference."""
    assert main(["fork", run, "--at", "4", "--set", "angle=10"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("  the change makes no difference: all ")


@pytest.mark.process
def test_a_shown_recording_is_forked_beside_it(
    run: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """By a command that is shown; a file that is there already is left alone."""
    monkeypatch.setattr("builtins.input", lambda _: "")
    first = Path(run).with_name("run_fork_1.mcap")
    first.touch()
    path = fork_shown(Path(run), 1.0, ["speed=0.1", "--fault", "at 2: drop scan"], nullcontext)
    assert path == Path(run).with_name("run_fork_2.mcap")
    said = capfd.readouterr().out
    assert "--at 1.000 --set speed=0.1 --fault 'at 2: drop scan' --record " in said
    assert "recorded: success at " in said
    assert fork_shown(Path(run), 1.0, ["sped=0.1"], nullcontext) is None
    assert first.stat().st_size == 0


def test_a_fault_begins_after_the_fork(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its recording holds the fault, so that it runs again by itself."""
    path = tmp_path / "fault.mcap"
    words = ("--at", "1", "--fault", "at 1.5: spawn_box ahead 0.45", "--record", str(path))
    told = forked(capsys, run, *words)
    assert told["forked"]["faults"][0]["began"] == 1.5
    assert told["first_difference"]["time_s"] >= 1.5
    again = forked(capsys, str(path), "--at", "2")
    assert again["is_identical"]
    assert again["forked"]["faults"] == told["forked"]["faults"]


def test_a_fault_before_the_fork_is_refused(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """By its time, or by the difference that it makes; one that cannot be read by its place."""
    error = refused(capsys, run, "--at", "2", "--fault", "at 1.5: drop scan")
    assert "--fault:1:4: error: it begins before the fork, whose control step is at 2.00" in error
    error = refused(capsys, run, "--at", "2", "--fault", "when speed > 0.1: drop scan")
    assert "it is not the same up to 2.00 s" in error
    assert "did you mean 'drop'?" in refused(capsys, run, "--at", "2", "--fault", "at 3: drp scan")


def test_a_mission_that_begins_otherwise_is_refused(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """World, robot, seed and map are settled by then; faults are told as in a check."""
    path = edit(tmp_path, "seed: 3", "seed: 4")
    error = refused(capsys, run, "--at", "1", "--mission", path)
    assert f"{path}:3:7: error: 'seed' is settled when a run begins: it was 3, and is 4" in error
    path = edit(tmp_path, "seed: 3", "sed: 3")
    assert "sed" in refused(capsys, run, "--at", "1", "--mission", path)


def test_an_edited_requirement_is_watched_from_the_start(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What was recorded of the first one is not compared."""
    path = edit(tmp_path, "always battery > 20", "always speed < 0.15")
    told = forked(capsys, run, "--at", "4", "--mission", path, code=1)
    assert told["forked"]["requirements"][0]["verdict"] == "violated"
    assert told["recorded"]["requirements"][0]["verdict"] == "holds"
    assert told["is_identical"]


def test_the_shipped_files_are_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A world and a robot of one's own are in the recording."""
    monkeypatch.chdir(tmp_path)
    source = Path(__file__).parents[2]
    for kind, name in (("worlds", "empty_arena"), ("robots", "waffle")):
        Path(kind).mkdir()
        shutil.copy(source / kind / f"{name}.yaml", f"{kind}/mine.yaml")
    Path("m.yaml").write_text("mission: m\nworld: mine\nrobot: mine\ntree: {turn: {angle: 9}}\n")
    assert main(["run", "m.yaml", "--json", "--record", "run.mcap"]) == 0
    shutil.rmtree("worlds")
    shutil.rmtree("robots")
    assert forked(capsys, "run.mcap", "--at", "0.5")["is_identical"]


def test_a_recording_of_another_place_fails_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Failures name the mission's file as on every machine, so the traces are the same."""
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ntree:\n  sequence: [{set: {a: 0}}, {wait: 1 / a}]\n")
    run = tmp_path / "run.mcap"
    assert main(["run", str(path), "--json", "--record", str(run)]) == 1
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    told = forked(capsys, str(run), "--at", "0")
    assert told["is_identical"]
    assert told["recorded"]["reason"].startswith("m.yaml:3:")


def test_the_recording_of_tests_can_be_forked(capsys: pytest.CaptureFixture[str]) -> None:
    """It is one like others."""
    assert forked(capsys, str(recording()), "--at", "2.5")["is_identical"]


def test_a_run_of_a_scenario_is_forked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With its place, its start, its faults and its requirements."""
    path = tmp_path / "s.scenario.yaml"
    path.write_text(
        "scenario: s\nmission: square\nworld: nav_arena\nseed: 5\n"
        "start: {x: 0.2, y: 0.1, yaw: 90}\ninputs: {side: 0.3}\n"
        "faults: ['at 2.0: drop odom lasting 0.5']\n"
        "requirements: {has power: always battery > 20}\n",
        encoding="utf-8",
    )
    run = tmp_path / "s.mcap"
    assert main(["run", str(path), "--json", "--record", str(run)]) == 0
    told = forked(capsys, str(run), "--at", "3")
    assert told["is_identical"]
    assert told["forked"]["faults"][0]["began"] == 2
    assert told["forked"]["requirements"] == told["recorded"]["requirements"]


def test_places_of_a_fork_are_those_of_the_recorded_world(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where the world stands in a scenario, and is in no file."""
    scenario, path = tmp_path / "z.yaml", tmp_path / "z.mcap"
    scenario.write_text(
        "scenario: z\nworld: {name: w, size: [4, 4], zones: [{name: Z, x: 0.3, y: 0}]}\n"
        "mission:\n  mission: m\n  world: nav_arena\n"
        "  tree: {navigate_to_pose: {pose: Z}, timeout: 60 s}\n",
        encoding="utf-8",
    )
    assert main(["run", str(scenario), "--record", str(path)]) == 0
    assert main(["fork", str(path), "--at", "1.0"]) == 0
    assert "identical" in capsys.readouterr().out
