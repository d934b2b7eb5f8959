"""The world of a simulation: the standard services for it, and its zones as markers."""

import math
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from simulation_interfaces.msg import Bounds, TagsFilter
from visualization_msgs.msg import Marker

from bt_mission.base.files import find, names
from sim.ros.node import zone_markers
from sim.ros.requests import Code
from sim.world.loader import load_world
from sim.world.world import World
from tests.sim.ros.conftest import result_of

WORLD = {
    "name": "hall",
    "description": "A hall with a dock.",
    "spawn": {"x": -1.0, "y": 0.5, "yaw": 90},
    "zones": [{"name": "dock", "x": 1.0, "y": -2.0, "radius": 0.3}],
}


@pytest.fixture
def sim(make_simulator):
    """A Waffle in a world with a zone."""
    return make_simulator(world=WORLD)


def test_the_world_is_told(sim):
    """With the file that it is from."""
    answer = sim.ask("GetCurrentWorld")
    assert result_of(answer) == (Code.OK, "")
    assert (answer.world.name, answer.world.description) == ("hall", "A hall with a dock.")
    assert answer.world.world_resource.uri == find("worlds", "empty_arena").resolve().as_uri()


def test_the_worlds_that_are_shipped_are_listed(sim):
    """What is to be searched besides is said to be left out; tags there are none."""
    answer = sim.ask("GetAvailableWorlds", additional_sources=["http://shop"])
    assert result_of(answer) == (Code.OK, "not searched: 'http://shop'")
    worlds = [Path(world.world_resource.uri).stem for world in answer.worlds]
    assert worlds == names("worlds")
    tagged = sim.ask("GetAvailableWorlds", filter=TagsFilter(tags=["indoor"]))
    assert result_of(tagged)[0] == Code.FEATURE_UNSUPPORTED


@pytest.mark.parametrize("kind", ["LoadWorld", "UnloadWorld"])
def test_the_world_stays(sim, kind):
    """Said with the way to another."""
    text = "a world is chosen at the start: bt-mission sim --world NAME"
    assert result_of(sim.ask(kind)) == (Code.FEATURE_UNSUPPORTED, text)


@pytest.mark.parametrize(
    ("tags", "result"), [([], ["spawn", "dock"]), (["zone"], ["dock"]), (["spawn"], ["spawn"])]
)
def test_places_with_a_name(sim, tags, result):
    """The start and the zones, by their tags."""
    answer = sim.ask("GetNamedPoses", tags=TagsFilter(tags=tags))
    assert [pose.name for pose in answer.poses] == result
    for pose in answer.poses:
        if pose.name == "spawn":
            place, q = pose.pose.position, pose.pose.orientation
            assert (place.x, place.y) == (-1.0, 0.5)
            assert 2 * math.atan2(q.z, q.w) == pytest.approx(math.pi / 2)


def test_room_at_a_place(sim):
    """A zone is round; the start has no bounds; others are not there."""
    zone = sim.ask("GetNamedPoseBounds", name="dock").bounds
    assert (zone.type, zone.points[1].x) == (Bounds.TYPE_SPHERE, 0.3)
    assert sim.ask("GetNamedPoseBounds", name="spawn").bounds.type == Bounds.TYPE_EMPTY
    text = "no pose has the name 'nowhere'; there are spawn, dock"
    answer = sim.ask("GetNamedPoseBounds", name="nowhere")
    assert result_of(answer) == (Code.NOT_FOUND, text)


def test_a_zone_is_a_disc_with_a_name():
    """On the map, of its size."""
    zone = {"name": "A", "x": 1.0, "y": 2.0, "radius": 0.3, "colour": "green"}
    world = World.model_validate({"name": "test", "size": [8, 8], "zones": [zone]})
    disc, name = zone_markers(world, Time(sec=1)).markers
    assert (disc.type, disc.header.frame_id, disc.scale.x) == (Marker.CYLINDER, "map", 0.6)
    assert (disc.pose.position.x, disc.pose.position.y) == (1.0, 2.0)
    assert disc.color.g > disc.color.r
    assert (name.type, name.text) == (Marker.TEXT_VIEW_FACING, "A")


def test_places_are_marked_beside_zones():
    """With a smaller disc; each marker has another namespace or number."""
    every = zone_markers(load_world("nav_arena"), Time(), {"dock": (0.5, 1.0)}).markers
    disc, name = every[-2:]
    assert (name.text, disc.pose.position.x, disc.pose.position.y) == ("dock", 0.5, 1.0)
    assert disc.scale.x < every[0].scale.x
    assert len({(marker.ns, marker.id) for marker in every}) == len(every) == 10
