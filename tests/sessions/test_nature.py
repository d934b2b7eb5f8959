"""Nature on the stage: what was drawn takes effect, and the same draw gives the same run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.nature import Nature
from bt_mission.scenarios.run import run_scenario
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions
from sim.world.world import World
from tests.support.thorough import sample

MISSION = """
mission: goes
world: empty_arena
tree:
  sequence:
    - turn: {angle: 40}
    - wait: 0.2
"""


def ran(tmp_path: Path, nature: Nature | None, seed: int = 1, text: str = MISSION, **options):
    """Run a mission to its end; returns the stage as it was then."""
    mission = load(text, seed=seed)
    made = StageOptions(nature=nature, **options)
    with Stage(mission, image_folder=tmp_path, say=lambda _: None, options=made) as stage:
        while not stage.is_done:
            stage.step()
    return stage


@pytest.mark.thorough
def test_the_same_draw_gives_the_same_run(tmp_path):
    """The seed alone decides; another seed or profile gives another run."""
    usual = Nature("usual")
    first = ran(tmp_path, usual)
    assert ran(tmp_path, usual).trace.sha256 == first.trace.sha256
    others = [ran(tmp_path, usual, seed=2), ran(tmp_path, Nature("mild")), ran(tmp_path, None)]
    seedless = {run.trace.seedless_sha256 for run in (first, *others)}
    assert len(seedless) == 4


def test_what_was_drawn_repeats_the_run_as_numbers(tmp_path):
    """As a recording and the scenario of a failed test hold it."""
    first = ran(tmp_path, Nature("usual"))
    assert json.loads(first.facts["stage"])["robots"][0]["nature"] == first.runs[0].nature
    assert ran(tmp_path, Nature("none", first.runs[0].nature)).trace.sha256 == first.trace.sha256


def test_nothing_drawn_changes_nothing(tmp_path):
    """Neither the profile `none` nor neutral numbers."""
    plain = ran(tmp_path, None).trace.sha256
    assert ran(tmp_path, Nature("none")).trace.sha256 == plain
    assert ran(tmp_path, Nature("none", {"start_x": 0.0})).trace.sha256 == plain


@pytest.mark.parametrize(
    ("name", "value"),
    sample(
        [
            ("start_yaw", 20.0),
            ("wheel_radius", 10.0),
            ("topic_latency", 0.1),
            ("server_latency", 0.2),
        ],
        2,
    ),
)
def test_a_quantity_takes_effect(tmp_path, name, value):
    """Each alone changes the run."""
    plain = ran(tmp_path, None)
    changed = ran(tmp_path, Nature("none", {name: value}))
    assert changed.trace.seedless_sha256 != plain.trace.seedless_sha256


def started(tmp_path: Path, nature: Nature, **options):
    """Return the pose at the start, and what nature has drawn."""
    made = StageOptions(nature=nature, **options)
    with Stage(load(MISSION), image_folder=tmp_path, options=made) as stage:
        return stage.sim.robots[0].pose, stage.runs[0].nature


def test_the_start_is_moved(tmp_path):
    """From where the world or the options say."""
    nature = Nature("none", {"start_x": 0.1, "start_y": -0.2, "start_yaw": 30})
    pose, _ = started(tmp_path, nature, start=(0.5, 0.5, 170.0))
    assert pose == pytest.approx((0.6, 0.3, -2.7925), abs=1e-3)


def test_where_there_is_no_room_the_offset_is_reduced(tmp_path):
    """The report has what is left of it."""
    world = World.model_validate_json(
        '{"name": "narrow", "size": [4, 4], "boxes": [{"x": 0.6, "y": 0, "size": [0.2, 1, 0.5]}]}'
    )
    pose, nature = started(tmp_path, Nature("none", {"start_x": 0.8}), world=world)
    assert nature["start_x"] == 0.4
    assert pose[0] == pytest.approx(0.4, abs=1e-3)


def test_scenario_mission_and_world_say_it_in_this_order(tmp_path):
    """The first that has it counts; a default only where none has it."""
    world = {"name": "flat", "size": [4, 4], "nature": {"lidar_noise": 0.3}}
    scenario: dict[str, Any] = {
        "scenario": "s",
        "mission": {"mission": "m", "tree": {"wait": 0.1}},
        "world": world,
    }
    path = tmp_path / "s.scenario.yaml"

    def noise() -> float:
        path.write_text(json.dumps(scenario))
        return run_scenario(path).report.nature["lidar_noise"]

    assert noise() == 0.3
    scenario["mission"]["nature"] = {"lidar_noise": 0.2}
    assert noise() == 0.2
    scenario["nature"] = {"lidar_noise": "10 cm"}
    assert noise() == 0.1


def test_each_robot_of_a_fleet_has_its_own(tmp_path):
    """Draws and starts differ."""
    robots = [FleetRobot(name, load(MISSION), x=x) for name, x in (("one", -1.0), ("two", 1.0))]
    options = StageOptions(nature=Nature("usual"))
    with Stage(robots=robots, image_folder=tmp_path, options=options) as stage:
        first, second = stage.runs
        assert first.nature["start_x"] != second.nature["start_x"]
        assert first.robot.pose[0] == pytest.approx(-1 + first.nature["start_x"], abs=1e-3)
        assert second.robot.pose[0] == pytest.approx(1 + second.nature["start_x"], abs=1e-3)


def test_a_fault_replaces_a_figure_while_it_lasts(tmp_path):
    """Then the usual one is back."""
    mission = load(MISSION)
    options = StageOptions(nature=Nature("none", {"lidar_noise": 0.02}))
    with Stage(mission, image_folder=tmp_path, options=options) as stage:
        faults = stage.sim.robots[0].faults
        assert faults["lidar"].noise == 0.02
        assert faults.present == {}
        faults.set("lidar", noise=0.5)
        assert faults["lidar"].noise == 0.5
        faults.clear()
        assert faults["lidar"].noise == 0.02
