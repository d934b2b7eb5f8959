"""Candidates: drawn within the ranges, and equal for equal draws."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.space import SearchSpace
from bt_mission.commands.falsify.starts import FreeSpace
from bt_mission.commands.falsify.strategies import RandomStrategy
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario, load_base
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.faults.planned import AtTime, WhenTrue
from bt_mission.scenarios.faults.robot import ON_BODIES
from bt_mission.scenarios.faults.text import parse_fault
from bt_mission.scenarios.faults.world import OBSTACLES
from tests.commands.falsify.conftest import MISSION

RANGES = """\
seeds: 3..5
inputs: {speed: 0.1..0.2, rounds: [1, 2]}
start: {x: -1..1, y: -0.5..0.5}
obstacles: {most: 2, times: 1..4, ahead: 0.5..1, left: -0.2..0.2, size: 0.1..0.2, lasting: 1..2}
faults: {most: 2, kinds: [lidar_dead, slow_server], times: 0..9.5, lasting: 0.5..1}
"""


def space_of(base: BaseScenario, text: str) -> SearchSpace:
    """Return all that a file of ranges allows."""
    file = RangesFile(read_text(text))
    return SearchSpace(base, file.ranges, file.parameters, 10.0)


def test_everything_is_within_the_ranges(base: BaseScenario) -> None:
    """Also the actions of faults, which are those of the mission."""
    space = space_of(base, RANGES)
    drawn = RandomStrategy(space, 0).ask(200)
    assert {candidate.seed for candidate in drawn} == {3, 4, 5}
    assert {candidate.values["rounds"] for candidate in drawn} == {1, 2}
    assert all(0.1 <= candidate.values["speed"] <= 0.2 for candidate in drawn)
    assert all(abs(candidate.values["start.y"]) <= 0.5 for candidate in drawn)
    faults = [fault for candidate in drawn for fault in candidate.faults]
    names = {"lidar_dead", "slow_server", "move_box", *OBSTACLES}
    assert {planned.name for planned in faults} == names
    assert {planned.arguments.get("action") for planned in faults} == {None, "explore_forward"}
    assert all(isinstance(planned.begins, AtTime) for planned in faults)
    assert all(space.allows(candidate) for candidate in drawn)


TRUSTS = """\
mission: careful
world: empty_arena
follow:
  - {topic: /battery_state, type: sensor_msgs/msg/BatteryState, field: percentage, as: charge,
     timeout: 10, default: 0}
tree: {guard: charge > 20, do: {turn: {angle: 90}, timeout: 30}}
"""


@pytest.mark.parametrize("seed", range(8))
def test_a_topic_that_the_mission_trusts_falls_silent_early(tmp_path: Path, seed: int) -> None:
    """For longer than its limit, within the first 30 candidates."""
    path = tmp_path / "m.yaml"
    path.write_text(TRUSTS)
    space = SearchSpace(load_base(path, BaseChanges()), RangesFile().ranges, (), 40.0)
    drawn = RandomStrategy(space, seed).ask(30)
    silences = [
        fault
        for candidate in drawn
        for fault in candidate.faults
        if fault.name in ("drop", "freeze") and fault.arguments["topic"] == "battery_state"
    ]
    assert any(fault.lasting is not None and fault.lasting > 10 for fault in silences)


def test_what_moves_is_there(base: BaseScenario) -> None:
    """One obstacle in three goes somewhere, from the instant at which it appears."""
    drawn = RandomStrategy(space_of(base, "faults: {most: 0}"), 0).ask(100)
    moved = [
        (candidate, fault)
        for candidate in drawn
        for fault in candidate.faults
        if fault.name == "move_box"
    ]
    assert len(moved) > 20
    for first, fault in moved:
        (spawned,) = (
            other for other in first.faults if other.arguments.get("name") == fault.arguments["box"]
        )
        assert spawned.begins == fault.begins
        assert 0.1 <= fault.arguments["speed"] <= 0.5  # type: ignore[operator]
    still = RandomStrategy(space_of(base, "obstacles: {speed: 0}"), 0).ask(50)
    assert not any(fault.name == "move_box" for candidate in still for fault in candidate.faults)


def test_faults_begin_with_events_too(base: BaseScenario) -> None:
    """Where no times are given."""
    drawn = RandomStrategy(space_of(base, "obstacles: {most: 0}"), 0).ask(200)
    begins = [fault.begins for candidate in drawn for fault in candidate.faults]
    texts = {beginning.condition.text for beginning in begins if isinstance(beginning, WhenTrue)}
    assert texts == {f'{word}("drive")' for word in ("running", "succeeded", "failed")}
    assert sum(isinstance(beginning, AtTime) for beginning in begins) > len(begins) / 3


def test_there_are_no_more_obstacles_than_a_simulation_has(tmp_path: Path) -> None:
    """Those of the base count."""
    path = tmp_path / "it.scenario.yaml"
    (tmp_path / "short.yaml").write_text(MISSION)
    path.write_text(
        "scenario: it\nmission: short.yaml\nobstacles: [{at: [1, 1]}, {at: [1, -1]}]\n"
        "faults: ['at 2.0: spawn_box 1.0']\n"
    )
    space = space_of(load_base(path, BaseChanges()), "{}")
    drawn = RandomStrategy(space, 0).ask(50)
    assert max(sum(f.name in OBSTACLES for f in candidate.faults) for candidate in drawn) == 1


def test_what_is_drawn_can_run(base: BaseScenario) -> None:
    """Every fault of every kind is one that a scenario may have."""
    kinds = "[network, hardware, camera, messages, servers, code, battery, clock]"
    space = space_of(base, f"faults: {{most: 10, kinds: {kinds}}}")
    with ScenarioWorker(base.bundle) as worker:
        for number, first in enumerate(RandomStrategy(space, 0).ask(30)):
            worker.load(first.concrete(base, number))


@pytest.mark.parametrize(
    "fault",
    [
        "at 5.0: spawn_box 0.7 0.0",
        "at 2.0: spawn_box 1.2 0.0",
        "at 2.0: spawn_box 0.7 0.3",
        "at 2.0: spawn_box 0.7 0.0 size (0.4, 0.4, 0.3)",
        "at 9.75: lidar_dead lasting 1",
        "at 2: lidar_dead lasting 2",
    ],
)
def test_what_lies_outside_of_the_ranges(base: BaseScenario, fault: str) -> None:
    """A time, a place, a size, or how long it lasts."""
    space = space_of(base, RANGES)
    assert space.allows(Candidate(faults=(parse_fault("at 2.0: spawn_box 0.7 0.1"),)))
    assert not space.allows(Candidate(faults=(parse_fault(fault),)))
    assert not space.allows(Candidate(values={"speed": 0.3}))


def test_the_base_stands_in_what_is_not_varied(base: BaseScenario) -> None:
    """A candidate without a word of its own is the mission as it is."""
    data = Candidate().concrete(base, 0).data
    assert data["seed"] == 5
    assert "faults" not in data
    assert "limit" not in data
    assert Candidate(limit=9.0).concrete(base, 0).data["limit"] == 9.0


def test_starts_are_where_the_robot_has_room(base: BaseScenario) -> None:
    """A place in a wall, or behind it, is moved to the nearest free one."""
    free = FreeSpace(base)
    assert free.nearest(None, 0.3, 0.4) == (0.3, 0.4)
    x, y = free.nearest(None, 5.0, 0.0)
    assert 1.5 < x < 2.0
    assert y == pytest.approx(0.0, abs=0.06)


def test_any_place_of_a_world_with_pillars(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The worlds' own place is one; no place lies in a pillar."""
    path = tmp_path_factory.mktemp("mission") / "short.yaml"
    path.write_text("mission: short\nworld: turtlebot3_world\ntree: {wait: 1}\n")
    base = load_base(path, BaseChanges())
    space = space_of(base, "start: anywhere")
    for candidate in RandomStrategy(space, 0).ask(50):
        x, y = candidate.values["start.x"], candidate.values["start.y"]
        assert min(math.dist((x, y), (a, b)) for a in PILLARS for b in PILLARS) > 0.3


PILLARS = (-1.1, 0.0, 1.1)


def test_nothing_that_acts_on_bodies_is_drawn_with_another_simulator(base: BaseScenario) -> None:
    """It refuses pushes, faults of wheels and obstacles; other faults are drawn as ever."""
    text = "obstacles: {most: 2}\nfaults: {most: 2, kinds: [hardware]}\n"
    other = replace(base, data={**base.data, "simulator": "sim.ir_sim:IrSim"})
    for each, acts in ((base, True), (other, False)):
        drawn = RandomStrategy(space_of(each, text), 0).ask(200)
        names = {fault.name for candidate in drawn for fault in candidate.faults}
        assert bool(names & ON_BODIES) is acts
        assert "lidar_frozen" in names
