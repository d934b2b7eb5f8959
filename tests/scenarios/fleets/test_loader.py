"""Fleet files: what is read, and what is said of one that is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest

from bt_mission.base import files
from bt_mission.base.yaml.document import read
from bt_mission.scenarios.fleets.file import fleet_schema
from bt_mission.scenarios.fleets.loader import FleetChanges, examine_fleet, load_fleet

MISSION = """\
mission: turns
world: empty_arena
robot: waffle
inputs: {angle: 90}
tree:
  turn: {angle: $angle}
  name: turn
  timeout: 20
"""

Write = Callable[[str], Path]


@pytest.fixture
def fleet(tmp_path: Path) -> Write:
    """Write a fleet beside a mission: ``fleet(text)`` gives its path."""
    (tmp_path / "turns.yaml").write_text(MISSION, encoding="utf-8")

    def write(text: str) -> Path:
        path = tmp_path / "it.yaml"
        path.write_text(f"fleet: it\n{text}", encoding="utf-8")
        return path

    return write


def faults_of(path: Path) -> list[tuple[int, int, str]]:
    """Give line, column and message of everything that is wrong."""
    result, faults = examine_fleet(path)
    assert result is None
    return [(fault.line, fault.column, fault.headline) for fault in faults]


def test_a_fleet_has_what_its_file_says(fleet: Write) -> None:
    """Missions and models are looked for beside it; what is not said is the world's."""
    result = load_fleet(
        fleet(
            "world: dqn_stage1\n"
            "seed: 5\n"
            "robots:\n"
            "  one: {mission: turns.yaml, start: {x: 1, yaw: 90}, inputs: {angle: 45}}\n"
            "  two: {mission: turns.yaml, robot: burger, seed: 9}\n"
        )
    )
    assert (result.name, result.world.name, result.seed) == ("it", "dqn_stage1", 5)
    first, second = result.robots
    assert (first.name, first.x, first.y, first.yaw) == ("one", 1.0, 0.0, 90.0)
    assert (first.mission.robot, first.mission.inputs["angle"]) == ("waffle", 45)
    assert (second.name, second.x, second.mission.robot) == ("two", 0.0, "burger")


def test_seeds_of_missions_count_up_from_that_of_the_fleet(fleet: Write) -> None:
    """Two robots with one mission do not draw the same numbers; a robot may have its own seed."""
    path = fleet(
        "seed: 5\nrobots:\n"
        "  one: {mission: turns.yaml}\n"
        "  two: {mission: turns.yaml, start: {x: 1}, seed: 3}\n"
        "  three: {mission: turns.yaml, start: {x: -1}}\n"
    )
    assert [robot.mission.seed for robot in load_fleet(path).robots] == [5, 3, 7]
    changed = load_fleet(path, FleetChanges(seed=20))
    assert (changed.seed, [robot.mission.seed for robot in changed.robots]) == (20, [20, 21, 22])


def test_the_world_is_that_of_the_first_mission_unless_named(fleet: Write) -> None:
    """Or of the option."""
    path = fleet("robots: {one: {mission: turns.yaml}}\n")
    assert load_fleet(path).world.name == "empty_arena"
    assert load_fleet(path, FleetChanges(world="dqn_stage1")).world.name == "dqn_stage1"


def test_mission_and_world_can_stand_in_the_file(fleet: Write) -> None:
    """As mappings."""
    path = fleet(
        "world: {name: hall, size: [6, 3]}\n"
        "robots:\n  one:\n    mission: {mission: waits, tree: {wait: 1}}\n"
    )
    result = load_fleet(path)
    assert (result.world.name, result.robots[0].mission.name) == ("hall", "waits")


def test_everything_that_is_wrong_is_told_at_once_with_its_place(fleet: Write) -> None:
    """Names that are unknown have a suggestion."""
    faults = faults_of(
        fleet(
            "world: empty_aren\n"
            "robots:\n"
            "  one: {mission: squar}\n"
            "  Two: {mission: turns.yaml, inputs: {angl: 1}}\n"
            "  three: {mission: turns.yaml, robot: burgr}\n"
            "  four: {mission: it.yaml}\n"
        )
    )
    expected = [
        (2, 8, "did you mean 'empty_arena'?"),
        (4, 18, "did you mean 'square'?"),
        (5, 3, "expected a name of small letters, digits and '_'"),
        (5, 45, "unknown input 'angl'"),
        (6, 39, "no such robot: 'burgr'; did you mean 'burger'?"),
        (7, 19, "'it.yaml' is a fleet; expected a mission"),
    ]
    assert [fault[:2] for fault in faults] == [each[:2] for each in expected]
    for fault, each in zip(faults, expected, strict=True):
        assert each[2] in fault[2]


def test_an_error_of_a_mission_has_the_place_in_its_own_file(fleet: Write, tmp_path: Path) -> None:
    """As `check` of that file has it."""
    (tmp_path / "broken.yaml").write_text("mission: broken\ntree:\n  trn: 1\n", encoding="utf-8")
    _, faults = examine_fleet(fleet("robots: {one: {mission: broken.yaml}}\n"))
    assert [(Path(fault.file).name, fault.line) for fault in faults] == [("broken.yaml", 3)]


@pytest.mark.parametrize(
    ("robots", "place", "text"),
    [
        ("{}", (2, 9), "expected 1 to 16 robots, got 0"),
        ("[1]", (2, 9), "expected a mapping, got a list of 1"),
        # None of their missions is read: those of thousands would take minutes.
        (
            "{" + ", ".join(f"r{n}: {{mission: none}}" for n in range(17)) + "}",
            (2, 9),
            "expected 1 to 16 robots, got 17 [BT-707]",
        ),
        (
            "{one: {mission: turns.yaml}, one: {mission: turns.yaml}}",
            (2, 38),
            "duplicate key 'one'",
        ),
        ("{one: {mission: turns.yaml}, two: {mission: turns.yaml}}", (2, 15), "touches 'two'"),
        ("{one: {mission: turns.yaml, start: {x: 80}}}", (2, 44), "(80, 0) is outside the world"),
        (
            "{one: {mission: {mission: m, map: unknown, tree: {wait: 1}}}}",
            (2, 25),
            "draws its map",
        ),
        (
            "{one: {mission: turns.yaml, start: {x: 1.97}}}",
            (2, 44),
            "a waffle (one) does not fit at the spawn (1.97, 0, 0 deg): it touches 'east wall'",
        ),
    ],
)
def test_robots_that_cannot_be(
    fleet: Write, robots: str, place: tuple[int, int], text: str
) -> None:
    """None, too many, with one name, in one place, outside; the place in the file is told."""
    ((line, column, message),) = faults_of(fleet(f"robots: {robots}\n"))
    assert text in message
    assert (line, column) == place


def test_shipped_fleets_are_valid_and_fit_the_schema() -> None:
    """All that are shipped; the schema refuses what is no fleet."""
    schema = fleet_schema()
    results = files.fleets()
    assert results
    for name in results:
        path = files.find("missions", name)
        plan, faults = examine_fleet(path)
        assert (plan is not None, faults) == (True, ())
        jsonschema.validate(read(path).data, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"fleet": "x", "robots": {"one": {}}}, schema)


def test_the_kind_of_a_file_is_told_by_its_key(fleet: Write, tmp_path: Path) -> None:
    """Wherever that stands."""
    assert files.kind_of(fleet("robots: {}\n")) == "fleet"
    assert files.kind_of(tmp_path / "turns.yaml") == "mission"
