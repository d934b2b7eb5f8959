"""The standard services for what is in a simulation: found and looked at."""

import math

import pytest
from geometry_msgs.msg import Vector3
from simulation_interfaces import msg, srv
from simulation_interfaces.msg import EntityCategory

from sim.entities import Category
from sim.physics.spawn import RobotSpawn
from sim.ros import entity_messages
from sim.ros.entity_services import INVALID_POSE, SpawnCode
from sim.ros.requests import Code
from sim.world.world import Spawn
from tests.sim.ros.conftest import result_of
from tests.support.entities import WORLD, entities, spawn, state_of
from tests.support.thorough import sample


@pytest.fixture
def sim(make_simulator):
    """A Waffle in a world with a wall, a moving pillar and a zone."""
    sim = make_simulator("scan", "collisions", world=WORLD)
    sim.wait(0.1)
    return sim


def test_codes_are_those_of_the_standard():
    """Of categories, bounds and spawning."""
    assert {member.name: member.value for member in Category} == {
        member.name: getattr(EntityCategory, f"CATEGORY_{member.name}") for member in Category
    }
    kinds = (entity_messages.EMPTY, entity_messages.BOX, entity_messages.SPHERE)
    bounds = msg.Bounds
    assert kinds == (bounds.TYPE_EMPTY, bounds.TYPE_BOX, bounds.TYPE_SPHERE)
    assert {
        member.name: member.value
        for member in SpawnCode
        if member is not SpawnCode.ENTITIES_SPAWN_FAILED
    } == {member.name: getattr(msg.SpawnResult, member.name) for member in list(SpawnCode)[:-1]}
    assert srv.SpawnEntities.Response.ENTITIES_SPAWN_FAILED == SpawnCode.ENTITIES_SPAWN_FAILED
    assert srv.SetEntityState.Response.INVALID_POSE == INVALID_POSE


def test_everything_with_a_name_is_an_entity(sim):
    """The robot, under the name of its model where it is alone, and the world's obstacles."""
    assert entities(sim) == ["waffle", "the wall", "circling"]
    assert state_of(sim, "waffle") == pytest.approx((-1, 0.5, math.pi / 2, 0, 0, 0), abs=1e-3)
    assert state_of(sim, "the wall")[:3] == (0, 3, 0)
    x, y, _, vx, vy, _ = state_of(sim, "circling")
    angle, speed = math.tau * 0.1 / 80, math.tau * 2 / 80
    assert (x, y) == pytest.approx((2 * math.cos(angle), 2 * math.sin(angle)))
    assert math.hypot(vx, vy) == pytest.approx(speed)


def test_robots_of_a_fleet_have_their_own_names(make_simulator, waffle):
    """Two Waffles, two entities."""
    both = [RobotSpawn(waffle, "one", Spawn(x=-1)), RobotSpawn(waffle, "two", Spawn(x=1))]
    sim = make_simulator(robots=both)
    assert entities(sim) == ["one", "two"]
    assert state_of(sim, "two")[:2] == pytest.approx((1, 0), abs=1e-3)


def test_states_come_with_the_frame_and_the_time(sim):
    """In the map, at the time of /clock."""
    filters = msg.EntityFilters(filter="waffle")
    answer = sim.ask("GetEntitiesStates", filters=filters)
    (state,) = answer.states
    assert list(answer.entities) == ["waffle"]
    assert (state.header.frame_id, state.header.stamp.sec) == ("map", 1)
    assert state.header.stamp.nanosec == 100_000_000


@pytest.mark.parametrize(
    ("filters", "names"),
    [
        ({"filter": "^the"}, ["the wall"]),
        ({"filter": "fle$|ling"}, ["waffle", "circling"]),
        ({"categories": [EntityCategory(category=1)]}, ["waffle"]),
        ({"categories": [EntityCategory(category=c) for c in (4, 5)]}, ["the wall", "circling"]),
        ({"tags": msg.TagsFilter(tags=["moving", "robot"])}, ["waffle", "circling"]),
        ({"tags": msg.TagsFilter(tags=["moving", "world"], filter_mode=1)}, ["circling"]),
        ({"filter": "l", "tags": msg.TagsFilter(tags=["robot"])}, ["waffle"]),
        ({"filter": "nobody"}, []),
    ],
)
def test_filters_apply_together(sim, filters, names):
    """Names by POSIX regular expressions, categories, tags."""
    assert entities(sim, **filters) == names


def volume(kind: int, *points: tuple[float, float, float]) -> msg.Bounds:
    """Bounds of a request."""
    return msg.Bounds(
        type=kind, points=[Vector3(x=float(x), y=float(y), z=float(z)) for x, y, z in points]
    )


@pytest.mark.parametrize(
    ("bounds", "names"),
    [
        (volume(3, (2.0, 0.3, 0.1), (0.2, 0, 0)), ["circling"]),
        (volume(3, (2.0, 0.3, 0.1), (0.1, 0, 0)), []),
        (volume(3, (2.0, 0.0, 0.9), (0.3, 0, 0)), []),  # above it
        (volume(1, (0.1, 3.0, 1.0), (-3.0, 0.0, 0.0)), ["waffle", "the wall"]),
    ],
)
def test_entities_are_found_by_the_volume_that_they_are_in(sim, bounds, names):
    """A sphere or a box, against the box around each."""
    assert entities(sim, bounds=bounds) == names


@pytest.mark.parametrize(
    ("filters", "code", "words"),
    [
        ({"filter": "("}, 4, "filter: not a regular expression (POSIX Extended)"),
        ({"filter": "a" * 201}, 4, "a pattern of at most 200 characters"),
        ({"filter": "(a)\\1"}, 4, "without references back"),
        ({"filter": "((a{1,255}){1,255}){1,255}"}, 4, "its repetitions are too many"),
        ({"bounds": volume(2, (0, 0, 0), (1, 0, 0), (0, 1, 0))}, 0, "type 1 (box) or 3 (sphere)"),
        ({"bounds": volume(1, (0, 0, 0))}, 4, "expected two points of finite numbers, got 1"),
        ({"bounds": volume(3, (0, math.nan, 0), (1, 0, 0))}, 4, "two points of finite numbers"),
        ({"bounds": volume(99)}, 0, "type 1 (box) or 3 (sphere)"),
    ],
)
def test_filters_that_make_no_sense_are_refused(sim, filters, code, words):
    """At once, whatever they would cost."""
    result, text = result_of(sim.ask("GetEntities", filters=msg.EntityFilters(**filters)))
    assert result == code
    assert words in text


def test_a_pattern_that_is_badly_meant_takes_no_time(sim):
    """Python's own expressions would not end in this century."""
    spawn(sim, name="a" * 60)
    assert entities(sim, filter="^(a+)+(a+)+(a+)+$") == ["a" * 60]
    assert entities(sim, filter="^(a|a)*(a|a)*b$") == []


def test_bounds_are_boxes_in_the_frame_of_the_entity(sim, waffle):
    """Upper corner first, as the standard has it."""
    spawn(sim, name="crate", uri="box?size=[0.2,0.4,0.3]", yaw=1.0)
    bounds = sim.ask("GetEntityBounds", entity="crate").bounds
    assert bounds.type == msg.Bounds.TYPE_BOX
    corners = [(point.x, point.y, point.z) for point in bounds.points]
    assert corners == [(0.1, 0.2, 0.3), (-0.1, -0.2, 0.0)]
    upper, lower = sim.ask("GetEntityBounds", entity="waffle").bounds.points
    hull = waffle.hull
    assert (upper.x, lower.x, upper.y) == (hull.front, hull.rear, hull.half_width)


def test_what_is_known_of_an_entity_can_be_changed(sim):
    """Until it is deleted; filters go by it."""
    spawn(sim, name="crate")
    assert sim.ask("GetEntityInfo", entity="crate").info.tags == ["spawned"]
    info = msg.EntityInfo(description="a parcel", tags=["fragile"])
    info.category.category = 5
    assert result_of(sim.ask("SetEntityInfo", entity="crate", info=info)) == (Code.OK, "")
    assert sim.ask("GetEntityInfo", entity="crate").info == info
    assert entities(sim, tags=msg.TagsFilter(tags=["fragile"])) == ["crate"]
    sim.ask("DeleteEntity", entity="crate")
    spawn(sim, name="crate")
    assert sim.ask("GetEntityInfo", entity="crate").info.tags == ["spawned"]


@pytest.mark.parametrize(
    "kind",
    [
        "GetEntityState",
        "GetEntityInfo",
        "GetEntityBounds",
        "DeleteEntity",
        "SetEntityState",
        "SetEntityInfo",
    ],
)
@pytest.mark.parametrize(
    "name", sample(["<b>waffle</b>\x1b[31m", "", "nobody", "w" * 10_000], every=4)
)
def test_a_name_that_nobody_has_is_not_found(sim, kind, name):
    """Said with those that there are, and nothing that commands a terminal."""
    result, text = result_of(sim.ask(kind, entity=name))
    assert result == Code.NOT_FOUND
    assert "there are waffle, the wall, circling" in text
    assert "\x1b" not in text
    assert len(text) < 300


def test_a_slip_of_the_pen_is_recognised(sim):
    """The name that was meant is said."""
    assert "did you mean 'waffle'?" in result_of(sim.ask("GetEntityState", entity="wafle"))[1]
