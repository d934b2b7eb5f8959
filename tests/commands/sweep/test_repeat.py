"""A row of a sweep is carried out again."""

from __future__ import annotations

import shlex
from dataclasses import replace

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.commands.sweep.repeat import (
    Repeater,
    RunOptions,
    SweepOrigin,
    find_row,
    origin_of,
    resume_command,
)
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.ranges import parse_parameter
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.scenario import TIME_IS_UP
from tests.commands.sweep.conftest import ABOUT, BUNDLE, origin, write_results
from tests.support.rows import row

MISSION = """\
mission: turn
world: empty_arena
inputs: {angle: 30.0}
tree:
  turn: {angle: $angle}
  timeout: 20
"""


@pytest.fixture
def repeater(results):
    """Of the results."""
    return Repeater(results)


def test_the_command_has_all_that_differs(repeater):
    """Values, world, seed and faults, as the user has named them."""
    repeated = row(1, seed=3, parameters={"speed": 0.1, "world": "mine/hall.yaml"}, plan="lost")
    assert shlex.split(repeater.command(repeated)) == [
        *("bt-mission", "run", "mine/go.yaml", "--seed", "3", "--set", "speed=0.1"),
        *("--world", "mine/hall.yaml", "--fault", "at 2.0: drop scan lasting 2"),
    ]


def test_what_held_for_all_is_in_the_command(tmp_path):
    """What was said with the sweep; a value that was varied replaces it."""
    options = RunOptions({"legs": "3", "speed": "9"}, ["at 1: a"], "w", "b")
    store = write_results(tmp_path / "r", [], origin(options=options))
    words = shlex.split(Repeater(store).command(row(0, parameters={"speed": True})))
    assert words[5:] == [
        *("--set", "legs=3", "--set", "speed=true"),
        *("--world", "w", "--robot", "b", "--fault", "at 1: a"),
    ]


def test_a_text_is_quoted_for_the_shell(repeater):
    """No value of a mission's runs as a command."""
    words = repeater.command(row(0, parameters={"name": "$(rm -rf ~); x"}))
    assert shlex.split(words)[-1] == "name=$(rm -rf ~); x"
    assert "'name=$(rm -rf ~); x'" in words


@pytest.mark.parametrize(
    ("changes", "failed_row"),
    [
        ({}, row(1, parameters={"start.x": 1.0})),
        ({}, row(1, reason=TIME_IS_UP)),
        ({"options": None}, row(1)),
    ],
)
def test_what_options_cannot_say_is_a_scenario_file(tmp_path, changes, failed_row):
    """The line writes the file, and runs it."""
    store = write_results(tmp_path / "r", [], origin(**changes))
    command = Repeater(store).command(failed_row)
    file = tmp_path / "r" / "scenarios" / "missions" / f"{failed_row.id}.scenario.yaml"
    writing = f"bt-mission sweep-report {tmp_path / 'r'} --scenario {failed_row.id}"
    assert command == f"{writing} && bt-mission run {file}"


def test_results_that_do_not_know_their_origin(tmp_path):
    """Give no file, and say so."""
    store = write_results(tmp_path / "r", [row(0)], None)
    with pytest.raises(BtMissionError, match="contains no files of its mission"):
        Repeater(store).write(row(0))


def test_a_row_that_was_not_made_from_these_files(repeater):
    """Its id does not follow from them."""
    with pytest.raises(BtMissionError, match="have changed"):
        repeater.write(row(0))


def test_a_name_with_a_line_end_stays_a_remark(tmp_path):
    """Text of a mission's does not get into the scenario through its remarks."""
    data = {**ABOUT.scenario, "inputs": {"name": "a\nlimit: 1"}, "seed": 0}
    made = ConcreteScenario(0, data, {"name": "a\nlimit: 1"}, "", BUNDLE.digest)
    repeated = replace(row(0, parameters=made.parameters), id=made.id)
    path = Repeater(write_results(tmp_path / "r", [repeated], origin())).write(repeated)
    assert read(path).data == data


@pytest.mark.parametrize("name", ["0000000000000007", "7", "000000000000000"])
def test_a_row_is_found_by_id_number_or_beginning(tmp_path, name):
    """What the page and the tables name."""
    store = write_results(tmp_path / "r", [row(7)], None)
    assert find_row(store, name).number == 7


@pytest.mark.parametrize(("name", "reported"), [("00", "several scenarios"), ("zz", "no scenario")])
def test_a_row_that_is_not_there(tmp_path, name, reported):
    """Or not the only one."""
    store = write_results(tmp_path / "r", [row(7), row(8)], None)
    with pytest.raises(BtMissionError, match=reported):
        find_row(store, name)


def test_the_file_of_a_row_makes_the_same_run(tmp_path):
    """To the last byte of its trace, from the results folder alone."""
    mission = tmp_path / "turn.yaml"
    mission.write_text(MISSION)
    parameters = (parse_parameter("angle=20.0,40.0"), parse_parameter("start.yaw=90,180"))
    plan = SweepPlan(load_base(mission, BaseChanges(), parameters), parameters, seeds=(5,))
    with (
        ScenarioWorker(plan.base.bundle) as worker,
        ResultStore.create(tmp_path / "r", plan.about) as store,
    ):
        origin_of(plan).save(store)
        store.add(worker.carry_out(plan.scenario(2)))
    mission.unlink()
    with ResultStore.read(tmp_path / "r") as store:
        known = find_row(store, "2")
        assert known.passed
        path = Repeater(store).write(known)
        assert run_scenario(path).report.trace_sha256 == known.trace_sha256


def test_the_origin_is_read_as_it_was_written(results):
    """With the files of the bundle, so that its digest is the same."""
    result = SweepOrigin.of(results)
    assert result == origin()
    assert result.bundle.digest == BUNDLE.digest


def test_a_shipped_mission_is_called_as_the_user_has(tmp_path):
    """The command is one that works in every folder."""
    mission = tmp_path / "turn.yaml"
    mission.write_text(MISSION)
    plan = SweepPlan(load_base(mission, BaseChanges()))
    assert origin_of(plan).path == str(mission)
    assert origin_of(plan, path="turn").path == "turn"


def test_the_line_that_goes_on_with_a_sweep():
    """It has --resume once."""
    assert resume_command("bt-mission sweep a") == "bt-mission sweep a --resume"
    assert resume_command("bt-mission sweep a --resume") == "bt-mission sweep a --resume"
    assert resume_command("") == ""
