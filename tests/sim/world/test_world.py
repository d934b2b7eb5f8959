"""Worlds as written by hand: what they mean, and what is said of a mistake."""

import math
from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.robots.model import load_robot
from sim.world.loader import load_world, problems, unseen
from sim.world.shapes import rgba
from sim.world.world import World

GOOD = """\
name: room
size: [4, 4]
spawn: {x: -1, y: 0, yaw: 90}
walls:
  - {from: [-2, 1.9], to: [2, 1.9], thickness: 0.2, height: 0.3}
  - {name: middle, centre: [0, 0], length: 1, yaw: 90}
boxes:
  - {x: 1, y: -1, size: [0.4, 0.2, 0.3], yaw: 45}
cylinders:
  - {name: pillar, x: 1, y: 1, radius: 0.15, colour: red}
zones:
  - {name: A, x: -1, y: -1, radius: 0.4}
"""


@pytest.fixture
def write(tmp_path: Path):
    """Writes a world file with some lines replaced; gives its path."""

    def write(*changes: tuple[str, str]) -> Path:
        text = GOOD
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "room.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def refusal_of(path: Path) -> str:
    """All that is said about a world file, without the name of the file."""
    with pytest.raises(InputError) as caught:
        load_world(path)
    return str(caught.value).replace(str(path), "room.yaml")


def test_a_world_is_read_as_shapes(write):
    """Walls lie between their points, angles are degrees, and what has no name gets one."""
    wall, middle, box, pillar = load_world(write()).obstacles
    assert (wall.name, wall.x, wall.y, wall.yaw, wall.size) == ("wall 1", 0, 1.9, 0, (4, 0.2, 0.3))
    assert (middle.name, middle.yaw, middle.size) == ("middle", math.pi / 2, (1, 0.1, 0.5))
    assert (box.name, box.kind, box.yaw) == ("box 1", "box", math.pi / 4)
    assert (pillar.name, pillar.kind, pillar.radius) == ("pillar", "cylinder", 0.15)


def test_a_world_needs_no_more_than_a_name_and_a_size():
    """An empty floor, and a robot that starts in its middle."""
    world = World.model_validate({"name": "plain", "size": [2, 2]})
    assert world.obstacles == ()
    assert (world.spawn.x, world.spawn.y, world.spawn.yaw) == (0, 0, 0)


def test_a_wall_points_from_its_first_point_to_its_second():
    """Its direction is that of the two points, its centre lies between them."""
    walls = [{"from": [0, 0], "to": [1, 1]}]
    (wall,) = World.model_validate({"name": "w", "size": [9, 9], "walls": walls}).obstacles
    assert (wall.x, wall.y) == (0.5, 0.5)
    assert wall.yaw == pytest.approx(math.pi / 4)
    assert wall.size[0] == pytest.approx(math.sqrt(2))


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("size: [4, 4]", "size: [4, .nan]", "2:11", "expected a finite number, got"),
        ("size: [4, 4]", "size: [4]", "2:7", "'1' is missing"),
        ("size: [4, 4]", "size: [400, 4]", "2:8", "expected at most 100"),
        ("thickness: 0.2", "thickness: 0", "5:48", "expected at least 0.001, got the number 0"),
        ("thickness", "thicknes", "5:37", "unknown key 'thicknes'"),
        ("to: [2, ", "to: [-2, ", "5:5", "a wall from [-2, 1.9] to [-2, 1.9] has no length"),
        ("to: [2, 1.9], ", "", "5:5", "a wall is written with 'from' and 'to', or"),
        (
            "length: 1,",
            "length: 1, to: [1, 1],",
            "6:5",
            "a wall is written with 'from' and 'to', or",
        ),
        ("radius: 0.15", "radius: -1", "10:40", "expected at least 0.001, got the number -1"),
        ("x: 1, y: 1,", "x: one, y: 1,", "10:23", "expected a number, got string 'one'"),
        ("colour: red", "colour: rot", "10:54", "no such colour 'rot'"),
        ("yaw: 90}\nwalls", "yaw: 900}\nwalls", "3:27", "expected at most 360"),
        ("name: room\n", "", "1:1", "'name' is missing"),
        ("name: room", "name: 7", "1:7", "expected a string, got the number 7"),
        ("zones:", "zonen:", "11:1", "unknown key 'zonen'"),
    ],
)
def test_a_field_that_is_wrong_is_told_with_its_place(write, old, new, place, message):
    """Every mistake has file, line and column, and says what was expected."""
    words = refusal_of(write((old, new)))
    assert f"room.yaml:{place}: error: " in words
    assert message in words


def test_an_unknown_key_gets_the_nearest_and_the_valid_ones(write):
    """The keys are those a person writes: 'from', not the name it has inside."""
    words = refusal_of(write(("from:", "form:")))
    assert "unknown key 'form'" in words
    assert "did you mean 'from'?" in words
    assert "start" not in words


def test_all_faults_are_told_at_once(write):
    """One run tells two mistakes."""
    words = refusal_of(write(("radius: 0.15", "radius: big"), ("length: 1,", "length: -1,")))
    assert words.count("error:") == 2


def test_unknown_world_lists_those_there_are():
    """The message names the shipped worlds, and the nearest."""
    with pytest.raises(InputError, match=r"no such world .*nav_arena.* did you mean 'dqn_stage4'"):
        load_world("dqn_stage_4")


def test_a_world_is_looked_for_beside_the_mission(write):
    """A name is enough where the file lies next to the mission."""
    path = write()
    assert load_world("room", near=path.parent / "mission.yaml").name == "room"


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ("{around: [0, 0]}", "a motion is written with 'around' and 'period' (s), or"),
        ("{around: [0, 0], period: 9, speed: 1}", "a motion is written with"),
        ("{around: [0, 0], period: 0.5}", "expected a period of 1 s or longer, got 0.5 s"),
        ("{around: [0, 0], period: 2}", "at most 2 m/s fast, this one 4.44 m/s"),
        ("{through: [[1, 1]], speed: 0.1}", "goes through points that differ"),
        ("{through: [[0, 1]], speed: 3}", "expected at most 2"),
        ("{through: [], speed: 1}", "at least 1"),
        ("{trough: [[0, 1]], speed: 1}", "did you mean 'through'?"),
        ("{through: [[0, 7]], speed: 1}", "would stand at (0, 7), outside of the floor"),
    ],
)
def test_a_motion_that_cannot_be_is_told(write, motion, message):
    """Both ways of writing, their limits, and the edge of the floor."""
    words = refusal_of(write(("radius: 0.15", f"radius: 0.15, motion: {motion}")))
    assert message in words
    assert "room.yaml:10:" in words


def test_what_moves_is_an_obstacle_with_a_motion(write):
    """It starts at its place."""
    motion = "motion: {around: [0, 0], period: 60}"
    world = load_world(write(("radius: 0.15", f"radius: 0.15, {motion}")))
    (pillar,) = world.moving
    assert pillar is world.obstacles[-1]
    assert pillar.motion is not None
    assert pillar.motion.at(0.0)[:2] == pytest.approx((1, 1))


# ---- what holds between its parts --------------------------------------------------------


PILLAR = {"name": "pillar", "x": 1, "y": 1, "radius": 0.2}
ZONE = {"name": "A", "x": -1, "y": -1, "radius": 0.3}
WALLS = [{"name": "wall 2", "from": [-1, 1], "to": [1, 1]}, {"from": [-1, -1], "to": [1, -1]}]
OUTSIDE = "outside of the floor of 4 m x 4 m around (0, 0)"


@pytest.mark.parametrize(
    ("fields", "path", "message"),
    [
        (
            {"cylinders": [PILLAR, {**PILLAR, "x": -1}]},
            ("cylinders", 1, "name"),
            "the name 'pillar' is taken by item 1 of cylinders",
        ),
        ({"walls": WALLS}, ("walls", 1, "name"), "the name 'wall 2' is taken by item 1 of walls"),
        (
            {"zones": [ZONE, {**ZONE, "x": 0}]},
            ("zones", 1, "name"),
            "there are two zones named 'A'",
        ),
        (
            {"cylinders": [PILLAR], "spawn": {"x": 1.1, "y": 1}},
            ("spawn",),
            "the spawn (1.1, 1) lies inside 'pillar'",
        ),
        (
            {"cylinders": [PILLAR], "zones": [{**ZONE, "x": 1, "y": 1}]},
            ("zones", 0),
            "the centre of zone 'A' lies inside 'pillar'",
        ),
        ({"spawn": {"x": 3, "y": 0}}, ("spawn",), f"the spawn lies at (3, 0), {OUTSIDE}"),
        (
            {"cylinders": [{**PILLAR, "y": -2.5}]},
            ("cylinders", 0),
            f"'pillar' stands at (1, -2.5), {OUTSIDE}",
        ),
        (
            {"slippery": [{**ZONE, "name": "ice", "x": 9}]},
            ("slippery", 0),
            f"'ice' lies at (9, -1), {OUTSIDE}",
        ),
        ({"zones": [{**ZONE, "x": 9}]}, ("zones", 0), f"zone 'A' lies at (9, -1), {OUTSIDE}"),
    ],
)
def test_parts_that_do_not_go_together_are_refused(fields, path, message):
    """A name belongs to one obstacle (also a made-up one) or zone; all have room on the floor."""
    world = World.model_validate({"name": "room", "size": [4, 4], **fields})
    assert [(problem.path, problem.message) for problem in problems(world)] == [(path, message)]


def test_a_problem_has_its_place_and_what_to_do(write):
    """In a file, line and column, as any other."""
    with pytest.raises(InputError) as caught:
        load_world(write(("x: -1, y: 0, yaw: 90", "x: 1, y: 1")))
    (fault,) = caught.value.diagnostics
    assert (fault.line, fault.column) == (3, 8)
    assert fault.source == "spawn: {x: 1, y: 1}"
    assert fault.hint == "move it to where the robot has room"


def test_what_is_lower_than_the_lidar_is_warned_of():
    """Once for a robot, with its height and some names; a Waffle looks below 0.15 m."""
    low = [{**PILLAR, "height": 0.15, "name": f"low {n}"} for n in range(5)]
    world = World.model_validate({"name": "room", "size": [4, 4], "cylinders": low})
    assert unseen(world, load_robot("waffle")) == []
    (warning,) = unseen(world, load_robot("burger"))
    assert warning == (
        "world room: the lidar of the burger looks 0.182 m above the floor and over"
        " 'low 0', 'low 1', 'low 2' and 2 more: it will run into them unless it knows the map"
    )


# ---- colours -----------------------------------------------------------------------------


def test_a_colour_in_hexadecimal_has_parts_of_one():
    """Each pair of digits is a part of 255; alpha is 1."""
    assert rgba("#ff0033") == (1.0, 0.0, 0.2, 1.0)


@pytest.mark.parametrize("colour", ["gren", "#12345", "#12345g", "", "# 1 2 3"])
def test_unknown_colour_lists_the_known_ones(colour):
    """A colour that is neither gets the list."""
    with pytest.raises(ValueError, match=r"no such colour .* black, blue, .* or '#rrggbb'"):
        rgba(colour)
