"""`bt-mission falsify`: what is found is in a folder, and fails until the mission is mended."""

from __future__ import annotations

import json
import re
import runpy
import signal
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from bt_mission.core.yaml.document import read
from bt_mission.recording.verification import read_verified_run
from bt_mission.search.simplify import simplify
from bt_mission.sessions.stage import Stage
from tests.support.report_pages import data_of

DEFECT = """\
mission: careless
world: empty_arena
inputs: {gap: 0.2}
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: $gap}
      name: drive
      cancel_when: current_distance_travelled > 0.8
      on_cancel: success
      timeout: 15
"""
REQUIRED = "requirements:\n  keeps its distance: always clearance > 0.3\n"
BOXES = "obstacles: {most: 2, ahead: 0.9..1.1, left: -0.1..0.1}\nfaults: {most: 0}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Go to a folder with a mission that keeps 0.2 m, where 0.3 m are required."""
    (tmp_path / "careless.yaml").write_text(DEFECT)
    (tmp_path / "safe.yaml").write_text(REQUIRED)
    (tmp_path / "ranges.yaml").write_text(BOXES)
    (tmp_path / "unknown.yaml").write_text("requirements:\n  slow: always sped < 1\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


SEARCH = (
    "falsify",
    "careless.yaml",
    "--require",
    "safe.yaml",
    "--within",
    "ranges.yaml",
    "--workers",
    "1",
)


def test_what_is_found_fails_until_the_mission_is_mended(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A scenario, a test, a recording, a report and a sentence; the run repeats exactly."""
    assert main([*SEARCH, "--json", "--budget", "40", "--simplify", "40"]) == 1
    told = json.loads(capsys.readouterr().out)
    (found,) = told["found"]
    assert (found["kind"], found["what"]) == ("violated", "keeps its distance")
    told_so = r"requirement 'keeps its distance' is (violated by 0\.\d+ m at \d\.\d\d s) when a "
    matched = re.match(told_so + r"(box|cylinder) appears \S+ m ahead", found["sentence"])
    assert matched is not None
    outcome = matched.group(1)
    assert len(found["faults"]) == 1
    assert found["repeats"] is True
    assert told["runs"] <= 40
    scenario = folder / found["scenario"]
    assert scenario == folder / "found" / "careless" / "keeps_its_distance.scenario.yaml"
    data = read(scenario).data
    assert data["mission"] == "../../careless.yaml"
    assert data["expect"] == {"outcome": "any"}
    run = read_verified_run(folder / found["recording"])
    assert run.summary is not None
    shown = data_of(folder / found["report"])[""]["messages"]
    assert "keeps its distance" in json.dumps(shown)

    assert outcome in " ".join(scenario.read_text().replace("#", "").split())
    assert main(["verify", found["recording"]]) == 1
    assert f"keeps its distance: {outcome}" in capsys.readouterr().out

    assert main(["run", found["scenario"], "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["trace_sha256"] == found["trace_sha256"]

    test = runpy.run_path(found["test"])["test_keeps_its_distance"]
    with pytest.raises(AssertionError, match=f"requirement keeps its distance: {outcome}"):
        test()
    (folder / "careless.yaml").write_text(DEFECT.replace("gap: 0.2", "gap: 0.5"))
    test()
    assert main(["run", found["scenario"]]) == 0


def test_nothing_is_found(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The smallest margin is told, and nothing is written."""
    (folder / "careless.yaml").write_text(DEFECT.replace("gap: 0.2", "gap: 0.5"))
    assert main([*SEARCH, "--budget", "3"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("careless: nothing found (no violated requirement) in 3 runs")
    assert re.search(r"smallest margin \d+% of the usual one \('keeps its distance'\)", out)
    assert not (folder / "found").exists()


def test_what_breaks_the_reference_does_not_count(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mission that keeps 0.5 m stands the boxes that one with 0.2 m does not."""
    good = DEFECT.replace("gap: 0.2", "gap: 0.5")
    (folder / "good.yaml").write_text(good)
    words = [*SEARCH, "--reference", "good.yaml", "--simplify", "4", "--json", "--budget", "40"]
    assert main(words) == 1
    told = json.loads(capsys.readouterr().out)
    assert [one["what"] for one in told["found"]] == ["keeps its distance"]
    (folder / "good.yaml").write_text(DEFECT)
    assert main([*words, "--budget", "8"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["found"] == []
    assert told["broke_the_reference"] > 0


def test_a_search_that_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each cause is in a file of its own, the simplest first, with how often it was found."""
    (folder / "safe.yaml").write_text(REQUIRED + '  sees: always age("scan") < 0.8\n')
    boxes = BOXES.replace("{most: 0}", "{kinds: [lidar_dead], lasting: 1..2, times: 0.5..2}")
    (folder / "ranges.yaml").write_text(boxes)
    words = [*SEARCH, "--keep-going", "2", "--simplify", "10", "--budget", "30"]
    assert main([*words, "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert {one["what"] for one in told["found"]} == {"keeps its distance", "sees"}
    assert all(one["runs"] >= 1 and one["repeats"] for one in told["found"])
    sizes = [len(one["faults"]) for one in told["found"]]
    assert sizes == sorted(sizes)
    for one in told["found"]:
        assert main(["run", one["scenario"]]) == 1
    capsys.readouterr()
    assert main(words) == 1
    out = capsys.readouterr().out
    assert re.match(r"careless: 2 causes found after \d+ runs, minimized in \d+", out)
    assert re.search(r"^1\. requirement '.+' is violated .+ \(\d+ runs?\)$", out, re.MULTILINE)


def test_what_does_not_keep_to_an_assumption(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Is no find; it is told how many runs that were."""
    (folder / "ranges.yaml").write_text(BOXES + "assume: [always scan_clearance > 0.6]\n")
    assert main([*SEARCH, "--budget", "8"]) == 0
    assert re.search(r"; \d did not keep to the assumptions", capsys.readouterr().out)


def test_a_mission_that_breaks_as_it_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """There is nothing to search for; the folder is there all the same."""
    (folder / "safe.yaml").write_text("requirements:\n  is slow: always speed < 0.1\n")
    (folder / "found" / "careless").mkdir(parents=True)
    assert main(SEARCH) == 1
    out = capsys.readouterr().out
    assert "requirement 'is slow' is violated by 0.09999 m/s at 0.80 s" in out
    assert "with nothing going wrong" in out
    assert "it breaks as it is, with nothing varied: there is nothing to search for" in out
    assert (folder / "found" / "careless_2" / "test_is_slow.py").exists()


def test_a_mission_that_fails_as_it_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Is warned of where something else is searched for, and told at once where that is it."""
    (folder / "careless.yaml").write_text(DEFECT.replace("timeout: 15", "timeout: 1"))
    (folder / "safe.yaml").write_text("requirements:\n  is sane: always speed < 5\n")
    assert main([*SEARCH, "--budget", "2"]) == 0
    err = capsys.readouterr().err
    assert "as it is, with nothing varied, the mission ends in failure: 'drive' " in err
    assert main([*SEARCH, "--find", "failed", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["runs"], told["found"][0]["what"]) == (1, "drive")
    assert read(folder / told["found"][0]["scenario"]).data["expect"] == {"outcome": "success"}


def test_a_signal_ends_the_run_that_is_under_way(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run of a long mission takes minutes; those that have ended are told."""
    (folder / "careless.yaml").write_text(DEFECT.replace("gap: 0.2", "gap: 0.5"))
    step, runs = Stage.step, []

    def signalled(stage: Stage) -> None:
        if stage not in runs:
            runs.append(stage)
        step(stage)
        if len(runs) == 3 and stage.now_ns > 2_000_000_000:
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(Stage, "step", signalled)
    assert main([*SEARCH, "--budget", "40"]) == 130
    assert capsys.readouterr().out.startswith("careless: interrupted in 1 run\n")
    assert len(runs) == 3  # as it is, the probe of what is there, and this one
    assert runs[-1].now_ns < 2_100_000_000
    runs.clear()
    assert main(["falsify", "careless.yaml", "--cover", "--workers", "1"]) == 130
    assert "of the tree reached in 1 run\n" in capsys.readouterr().out


def test_what_is_found_by_a_signal_is_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As it was found, and without running it again for a recording."""

    async def simplified(*arguments: Any) -> None:
        signal.raise_signal(signal.SIGTERM)
        await simplify(*arguments)

    monkeypatch.setattr("bt_mission.search.session.simplify", simplified)
    monkeypatch.setattr(
        "bt_mission.search.result.record_scenario", lambda *_: pytest.fail("it is run again")
    )
    assert main([*SEARCH, "--budget", "40"]) == 130
    out = capsys.readouterr().out
    assert re.match("careless: requirement 'keeps its distance' is violated when a ", out)
    scenario = "found/careless/keeps_its_distance.scenario.yaml"
    assert f"  interrupted, so not run again: bt-mission run {scenario} --record FILE" in out
    assert {path.name for path in (folder / "found" / "careless").iterdir()} == {
        "keeps_its_distance.scenario.yaml",
        "test_keeps_its_distance.py",
    }
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    assert main(["run", scenario, "--json"]) == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--keep-going", "0"], "argument --keep-going: expected an integer from 1, got '0'"),
        (["--reference", "nothing.yaml"], "nothing.yaml"),
        (["--budget", "0"], "argument --budget: expected an integer from 1, got '0'"),
        (["--simplify", "-1"], "argument --simplify: expected an integer from 0, got '-1'"),
        (["--find", "bugs"], "invalid choice: 'bugs'"),
        (["--within", "nothing.yaml"], "nothing.yaml: error: no such file"),
        (["--world", "nowhere"], "no world 'nowhere'"),
        (["--require", "careless.yaml"], "expected a mapping 'requirements:'"),
        (["--require", "unknown.yaml"], "unknown.yaml:2:16: error: unknown signal 'sped'"),
        (["--fault", "at 5.0: drip scan"], "there is no fault 'drip'"),
        (["-o", "careless.yaml"], "careless.yaml: is a file; name a folder with -o"),
        (["-o", "."], ".: holds something already; name another folder with -o"),
    ],
)
def test_bad_input(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    """A line that says what is wrong; nothing runs."""
    code: Any
    try:
        code = main(["falsify", "careless.yaml", "--workers", "1", *words])
    except SystemExit as leaving:
        code = leaving.code
    assert code == 2
    err = capsys.readouterr().err
    assert message in err
    assert "Traceback" not in err
