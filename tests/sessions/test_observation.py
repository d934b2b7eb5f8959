"""Time that goes on after a mission's end, for requirements about what follows."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.cli.main import main
from bt_mission.scenarios.fleets.run import run_fleet
from bt_mission.scenarios.run import run_scenario
from bt_mission.sessions.load import load
from bt_mission.testing.stages import Stages
from tests.support.robot_bag import verify

MISSION = """\
mission: drive on
world: empty_arena
requirements:
  stands then: >-
    whenever ends(running('drive on')):
    eventually within 2 s: historically for 1 s speed < 0.01
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
      name: drive
      cancel_when: current_distance_travelled > 0.1
      on_cancel: success
      timeout: 20
"""


def test_what_comes_after_the_end_is_open_without_an_observation(stage: Stages) -> None:
    """The robot might still do it."""
    run = stage.run(MISSION)
    run.until_done()
    assert run.requirements["stands then"].verdict == "open"


def test_an_observation_decides_what_comes_after_the_end(stage: Stages) -> None:
    """Time goes on for as long as that, with every goal ended; the end is that of the mission."""
    run = stage.run(MISSION, observe=3)
    moment = run.until(lambda _: run.status == "observing")
    end_s = moment.t
    assert run.stage.runner.ledger.open_goals == ()
    assert run.stage.executive.mission_state.explanation == "success; observing for 3 s"
    run.until_done()
    assert run.succeeded
    assert run.t == pytest.approx(end_s + 3)
    assert run.report.reason == ""
    assert run.stage.executive.ended_ns == run.stage.start_ns + round(end_s * 1e9)
    assert run.requirements["stands then"].verdict == "holds"
    assert [event["seconds"] for event in run.events("observing")] == [3]
    assert len(run.events("mission")) == 1


def test_an_interruption_ends_an_observation_at_once(stage: Stages) -> None:
    """The mission has ended before, and as it did; its reason says what was cut."""
    run = stage.run(MISSION, observe=3)
    run.until(lambda _: run.status == "observing")
    run.advance(0.5)
    run.stage.executive.interrupt("interrupted by Ctrl-C")
    assert run.is_done
    assert (run.status, run.reason) == (
        "success",
        "observed for 0.5 s of 3 s: interrupted by Ctrl-C",
    )
    assert run.requirements["stands then"].verdict == "open"


def test_an_interrupted_mission_is_not_observed(stage: Stages) -> None:
    """Whoever interrupts it wants it to end."""
    run = stage.run(MISSION, observe=3)
    run.advance(0.5)
    run.stage.executive.interrupt("interrupted by Ctrl-C")
    run.until_done()
    assert run.status == "interrupted"
    assert run.events("observing") == []


def test_a_failed_mission_is_observed_and_has_failed(stage: Stages) -> None:
    """With the reason of its failure."""
    run = stage.run(MISSION.replace("timeout: 20", "timeout: 0.2"), observe=2)
    run.until_done()
    assert run.failed
    assert run.reason.startswith("'drive' canceled by timeout")
    assert run.requirements["stands then"].verdict == "holds"


def test_a_scenario_is_observed_beyond_its_limit(tmp_path: Path) -> None:
    """The limit is for the mission."""
    (tmp_path / "it.yaml").write_text(MISSION)
    file = tmp_path / "it.scenario.yaml"
    file.write_text("scenario: it\nmission: it.yaml\nobserve: 3\nlimit: 2\n")
    result = run_scenario(file)
    assert result.passed
    assert [requirement.verdict for requirement in result.report.requirements] == ["holds"]
    assert result.report.virtual_s < 2


def test_each_mission_of_a_fleet_is_observed(tmp_path: Path) -> None:
    """One key of the fleet is for all of them."""
    (tmp_path / "it.yaml").write_text(MISSION)
    file = tmp_path / "it.fleet.yaml"
    robots = "".join(
        f"  {name}:\n    mission: it.yaml\n    start: {{x: {x}, y: 0}}\n"
        for name, x in (("a", -1), ("b", 1))
    )
    file.write_text(f"fleet: it\nworld: empty_arena\nobserve: 3\nrobots:\n{robots}")
    report = run_fleet(file)
    verdicts = [
        requirement.verdict for robot in report.robots for requirement in robot.mission.requirements
    ]
    assert verdicts == ["holds", "holds"]


def test_the_command_line_asks_for_it_and_a_recording_holds_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`verify` comes to what the run did."""
    file, recording = tmp_path / "it.yaml", tmp_path / "it.mcap"
    file.write_text(MISSION)
    assert main(["run", str(file), "--observe", "3", "--record", str(recording), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [requirement["verdict"] for requirement in data["requirements"]] == ["holds"]
    (result,) = verify(recording).results
    assert (result.verdict, result.margin) == ("holds", data["requirements"][0]["margin"])


def test_an_observation_stands_in_the_mission(tmp_path: Path) -> None:
    """In seconds, 0 or more."""
    file = tmp_path / "it.yaml"
    file.write_text(MISSION.replace("world:", "observe: 2.5\nworld:"))
    assert load(file).observe == 2.5
    with pytest.raises(InputError, match="seconds, 0 or more"):
        load(MISSION.replace("world:", "observe: -1\nworld:"))
