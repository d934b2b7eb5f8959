"""`bt-mission falsify`: what is found is in a folder, and fails until the mission is mended."""

from __future__ import annotations

import errno
import json
import re
import signal
from pathlib import Path
from typing import Any

import pytest

import bt_mission
from bt_mission.base.output import cannot_write
from bt_mission.base.yaml.document import read
from bt_mission.commands.falsify import result
from bt_mission.commands.falsify.simplify import simplify
from bt_mission.recording.verification import read_verified_run
from bt_mission.sessions.stage import Stage
from tests.support.command_line import CommandLine
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


SEARCH = "falsify careless.yaml --require safe.yaml --within ranges.yaml --workers 1"


@pytest.fixture
def search(cli: CommandLine) -> CommandLine:
    """A folder with a mission that keeps 0.2 m, where 0.3 m are required."""
    cli.write("careless.yaml", DEFECT)
    cli.write("safe.yaml", REQUIRED)
    cli.write("ranges.yaml", BOXES)
    return cli


def test_what_a_search_measures_is_not_in_the_trace(search: CommandLine) -> None:
    """The distance to a branch that is taken: the file, without it, has the same trace."""
    search.write("slow.yaml", "requirements: {slow: always speed < 0.1}")
    command = "falsify careless.yaml --require slow.yaml --budget 1 --workers 1 --nature none"
    (counterexample,) = search.json(command, 1)["found"]
    assert counterexample["what"] == "slow"
    assert counterexample["repeats"] is True


CAREFUL = DEFECT.replace("gap: 0.2", "gap: 0.5")


@pytest.mark.thorough
def test_a_counterexample_fails_until_the_mission_is_fixed(search: CommandLine) -> None:
    """A scenario that is a test, a recording, a report and a sentence; the run repeats."""
    result = search.json(f"{SEARCH} --budget 40 --simplify 40", 1)
    (results,) = result["found"]
    assert (results["kind"], results["what"]) == ("violated", "keeps its distance")
    sentence = r"requirement 'keeps its distance' is (violated by 0\.\d+ m at \d\.\d\d s) when a "
    matched = re.match(sentence + r"(box|cylinder) appears \S+ m ahead", results["sentence"])
    assert matched is not None
    outcome = matched.group(1)
    assert len(results["faults"]) == 1
    assert results["repeats"] is True
    assert result["runs"] <= 40
    assert results["scenario"] == "found/careless/keeps_its_distance.scenario.yaml"
    scenario = Path(results["scenario"])
    data = read(scenario).data
    assert data["mission"] == "../../careless.yaml"
    assert data["expect"] == {"outcome": "any"}
    assert read_verified_run(Path(results["recording"]))[0].summary is not None
    messages = data_of(Path(results["report"]))[""]["messages"]
    assert "keeps its distance" in json.dumps(messages)
    assert outcome in " ".join(scenario.read_text("utf-8").replace("#", "").split())
    assert f"keeps its distance: {outcome}" in search(f"verify {results['recording']}", 1)
    assert search.json(f"run {scenario}", 1)["trace_sha256"] == results["trace_sha256"]
    broken = bt_mission.run_scenario(scenario)
    assert not broken.passed
    assert f"requirement keeps its distance: {outcome}" in str(broken)
    search.write("careless.yaml", CAREFUL)
    assert bt_mission.run_scenario(scenario).passed
    search(f"run {scenario}")


@pytest.mark.thorough
def test_a_search_without_a_counterexample_writes_nothing(search: CommandLine) -> None:
    """It prints the smallest margin, and how many runs did not keep to an assumption."""
    search.write("careless.yaml", CAREFUL)
    out = search(f"{SEARCH} --budget 3")
    assert out.startswith("careless: nothing found (no violated requirement) in 3 runs")
    assert re.search(r"nearest to a violation: 'keeps its distance', \d+% of its usual margin", out)
    assert not Path("found").exists()
    search.write("careless.yaml", DEFECT)
    search.write("ranges.yaml", BOXES + "assume: [always scan_clearance > 0.6]\n")
    assert re.search(r"; \d violated the assumptions", search(f"{SEARCH} --budget 8"))


@pytest.mark.thorough
def test_what_breaks_the_reference_does_not_count(search: CommandLine) -> None:
    """A mission that keeps 0.5 m stands the boxes that one with 0.2 m does not."""
    search.write("good.yaml", CAREFUL)
    command = f"{SEARCH} --reference good.yaml --simplify 1"
    result = search.json(f"{command} --budget 40", 1)
    assert [each["what"] for each in result["found"]] == ["keeps its distance"]
    search.write("good.yaml", DEFECT)
    result = search.json(f"{command} --budget 5")
    assert result["found"] == []
    assert result["broke_the_reference"] > 0


@pytest.mark.thorough
def test_a_search_that_continues(search: CommandLine) -> None:
    """Each cause is in its own file, the simplest first, with how often it was found."""
    search.write("safe.yaml", REQUIRED + '  sees: always age("scan") < 0.8\n')
    boxes = BOXES.replace("{most: 0}", "{kinds: [lidar_dead], lasting: 1..2, times: 0.5..2}")
    search.write("ranges.yaml", boxes)
    command = f"{SEARCH} --keep-going 2 --simplify 10 --budget 30"
    results = search.json(command, 1)["found"]
    assert {each["what"] for each in results} == {"keeps its distance", "sees"}
    assert all(each["runs"] >= 1 and each["repeats"] for each in results)
    sizes = [len(each["faults"]) for each in results]
    assert sizes == sorted(sizes)
    for each in results:
        search(f"run {each['scenario']}", 1)
    out = search(command, 1)
    assert re.match(r"careless: 2 causes found after \d+ runs, minimized in \d+", out)
    assert re.search(r"^1\. requirement '.+' is violated .+ \(\d+ runs?\)$", out, re.MULTILINE)


def test_a_mission_that_breaks_as_it_is(search: CommandLine) -> None:
    """There is nothing to search for; the folder is made all the same."""
    search.write("safe.yaml", "requirements:\n  is slow: always speed < 0.1\n")
    Path("found/careless").mkdir(parents=True)
    out = search(SEARCH, 1)
    assert "requirement 'is slow' is violated by 0.09999 m/s at 0.80 s" in out
    assert "without any fault" in out
    assert "it breaks without any change, so there was no search" in out
    assert Path("found/careless_2/is_slow.scenario.yaml").exists()


def test_what_is_found_is_said_where_it_cannot_be_written(
    search: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search may take hours; the disk may be full at its end."""

    def full(path: Path, _: str) -> None:
        raise cannot_write(path, OSError(errno.ENOSPC, "No space left on device"))

    monkeypatch.setattr(result, "write_file", full)
    search.write("safe.yaml", "requirements:\n  is slow: always speed < 0.1\n")
    search(SEARCH, 2)
    violation, error = search.err.splitlines()[-2:]
    assert violation == "found: requirement 'is slow' is violated without any fault"
    assert error.endswith("is_slow.scenario.yaml: No space left on device [BT-1103]")


@pytest.mark.thorough
def test_a_mission_that_fails_as_it_is(search: CommandLine) -> None:
    """A warning where something else is searched for, the result where failures are."""
    search.write("careless.yaml", DEFECT.replace("timeout: 15", "timeout: 1"))
    search.write("safe.yaml", "requirements:\n  is sane: always speed < 5\n")
    search(f"{SEARCH} --budget 2")
    assert "without any change, the mission ends in failure: 'drive' " in search.err
    result = search.json(f"{SEARCH} --find failed", 1)
    assert (result["runs"], result["found"][0]["what"]) == (1, "drive")
    assert read(Path(result["found"][0]["scenario"])).data["expect"] == {"outcome": "success"}


@pytest.mark.thorough
def test_a_signal_ends_the_current_run(
    search: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run of a long mission takes minutes; those that have ended are reported."""
    search.write("careless.yaml", CAREFUL)
    step, runs = Stage.step, []

    def signalled(stage: Stage) -> None:
        if stage not in runs:
            runs.append(stage)
        step(stage)
        if len(runs) == 3 and stage.now_ns > 2_000_000_000:
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(Stage, "step", signalled)
    assert search(f"{SEARCH} --budget 40", 130).startswith("careless: interrupted in 1 run\n")
    assert len(runs) == 3  # as it is, the probe of what is there, and this one
    assert runs[-1].now_ns < 2_100_000_000


def test_a_counterexample_before_a_signal_is_written(
    search: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As it was found, without a further run for a recording."""

    async def simplified(*arguments: Any) -> None:
        signal.raise_signal(signal.SIGTERM)
        await simplify(*arguments)

    monkeypatch.setattr("bt_mission.commands.falsify.session.simplify", simplified)
    monkeypatch.setattr(
        "bt_mission.commands.falsify.result.record_scenario",
        lambda *_: pytest.fail("it is run again"),
    )
    out = search(f"{SEARCH} --budget 40", 130)
    assert re.match("careless: requirement 'keeps its distance' is violated when a ", out)
    scenario = "found/careless/keeps_its_distance.scenario.yaml"
    assert f"not recorded, as the search was interrupted: bt-mission run {scenario} --record" in out
    assert [path.name for path in Path("found/careless").iterdir()] == [
        "keeps_its_distance.scenario.yaml"
    ]
    monkeypatch.undo()
    monkeypatch.chdir(search.folder)
    search.json(f"run {scenario}", 1)
