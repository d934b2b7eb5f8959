"""The standard services for the world of a simulation."""

import math
from pathlib import Path

import pytest
from simulation_interfaces.msg import Bounds, TagsFilter

from bt_mission.core.files import find, names
from sim.ros.requests import Code
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
    result, text = result_of(sim.ask("GetNamedPoseBounds", name="nowhere"))
    assert (result, text) == (
        Code.NOT_FOUND,
        "no pose has the name 'nowhere'; there are spawn, dock",
    )
