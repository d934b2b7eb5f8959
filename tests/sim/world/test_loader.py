"""What holds between the parts of a world: names, places, room to start."""

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.robot.model import load_robot
from sim.world.loader import load_world, problems, unseen
from sim.world.world import World

PILLAR = {"name": "pillar", "x": 1, "y": 1, "radius": 0.2}
ZONE = {"name": "A", "x": -1, "y": -1, "radius": 0.3}


def problems_of(**fields: object) -> list[tuple[tuple[str | int, ...], str]]:
    """Paths and messages of what is wrong with a world of 4 m x 4 m."""
    world = World.model_validate({"name": "room", "size": [4, 4], **fields})
    return [(problem.path, problem.message) for problem in problems(world)]


def test_a_sound_world_has_no_problems():
    """A pillar and a zone, each with room, are fine."""
    assert problems_of(cylinders=[PILLAR], zones=[ZONE]) == []


def test_two_obstacles_of_one_name_are_told_apart_by_place():
    """Collisions are reported by name, so a name belongs to one obstacle."""
    assert problems_of(cylinders=[PILLAR, {**PILLAR, "x": -1}]) == [
        (("cylinders", 1, "name"), "the name 'pillar' is taken by item 1 of cylinders")
    ]


def test_a_given_name_may_not_be_one_that_is_made_up():
    """'wall 2' is what the second wall is called when it has no name."""
    walls = [
        {"name": "wall 2", "from": [-1, 1], "to": [1, 1]},
        {"from": [-1, -1], "to": [1, -1]},
    ]
    assert problems_of(walls=walls) == [
        (("walls", 1, "name"), "the name 'wall 2' is taken by item 1 of walls")
    ]


def test_two_zones_of_one_name_are_refused():
    """A mission names the zone it goes to."""
    assert problems_of(zones=[ZONE, {**ZONE, "x": 0}]) == [
        (("zones", 1, "name"), "there are two zones named 'A'")
    ]


def test_spawn_inside_an_obstacle_is_refused():
    """The robot cannot start in a pillar."""
    assert problems_of(cylinders=[PILLAR], spawn={"x": 1.1, "y": 1}) == [
        (("spawn",), "the spawn (1.1, 1) lies inside 'pillar'")
    ]


@pytest.mark.parametrize(
    ("fields", "path", "what"),
    [
        ({"spawn": {"x": 3, "y": 0}}, ("spawn",), "the spawn lies at (3, 0)"),
        (
            {"cylinders": [{**PILLAR, "y": -2.5}]},
            ("cylinders", 0),
            "'pillar' stands at (1, -2.5)",
        ),
        (
            {"slippery": [{**ZONE, "name": "ice", "x": 9}]},
            ("slippery", 0),
            "'ice' lies at (9, -1)",
        ),
        ({"zones": [{**ZONE, "x": 9}]}, ("zones", 0), "zone 'A' lies at (9, -1)"),
    ],
)
def test_what_lies_beside_the_floor_is_refused(fields, path, what):
    """Spawn, obstacles and zones lie on the floor; the message gives its size."""
    assert problems_of(**fields) == [
        (path, f"{what}, outside of the floor of 4 m x 4 m around (0, 0)")
    ]


def test_a_zone_nobody_can_reach_is_refused():
    """The centre of a zone lies in no obstacle."""
    assert problems_of(cylinders=[PILLAR], zones=[{**ZONE, "x": 1, "y": 1}]) == [
        (("zones", 0), "the centre of zone 'A' lies inside 'pillar'")
    ]


def test_a_problem_is_told_with_its_place(tmp_path):
    """In a file, it has line and column, as any other fault."""
    path = tmp_path / "room.yaml"
    path.write_text(
        "name: room\nsize: [4, 4]\nspawn: {x: 1, y: 1}\n"
        "cylinders:\n  - {name: pillar, x: 1, y: 1, radius: 0.2}\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError) as caught:
        load_world(path)
    (fault,) = caught.value.diagnostics
    assert (fault.line, fault.column) == (3, 8)
    assert fault.source == "spawn: {x: 1, y: 1}"
    assert fault.hint == "move it to where the robot has room"


LOW = {"name": "low", "x": 1, "y": 1, "radius": 0.1, "height": 0.15}


def test_what_is_lower_than_the_lidar_is_warned_of():
    """Once for a robot, with its height and some names; a Waffle looks below 0.15 m."""
    world = World.model_validate(
        {
            "name": "room",
            "size": [4, 4],
            "cylinders": [{**LOW, "name": f"low {n}"} for n in range(5)],
        }
    )
    assert unseen(world, load_robot("waffle")) == []
    (warning,) = unseen(world, load_robot("burger"))
    assert warning == (
        "world room: the lidar of the burger looks 0.182 m above the floor and over"
        " 'low 0', 'low 1', 'low 2' and 2 more: it will run into them unless it knows the map"
    )
