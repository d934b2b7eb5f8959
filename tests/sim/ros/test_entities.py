"""The standard services for what is in a simulation: found, looked at, spawned, deleted, moved."""

import math
from typing import Any

import pytest
from geometry_msgs.msg import Vector3
from simulation_interfaces import msg, srv
from simulation_interfaces.msg import EntityCategory

from sim.entities import Category
from sim.ros import entity_messages
from sim.ros.entity_services import INVALID_POSE, SpawnCode
from sim.ros.name_patterns import PatternError, matching
from sim.ros.requests import Code
from tests.sim.ros.conftest import result_of
from tests.support.simulated import two
from tests.support.thorough import sample

OK = (Code.OK, "")

CIRCLE = {"around": [0, 0], "period": 80}
WORLD: dict[str, Any] = {
    "size": [10, 10],
    "spawn": {"x": -1.0, "y": 0.5, "yaw": 90},
    "walls": [{"name": "the wall", "from": [-2, 3], "to": [2, 3], "thickness": 0.2}],
    "cylinders": [{"name": "circling", "x": 2, "y": 0, "radius": 0.15, "motion": CIRCLE}],
    "zones": [{"name": "dock", "x": 1.0, "y": -2.0, "radius": 0.3}],
}


def pose_message(x: float, y: float, yaw: float = 0.0, frame: str = "") -> msg.SpawnEntity:
    """A request's part that has a pose."""
    request = msg.SpawnEntity()
    request.initial_pose.header.frame_id = frame
    pose = request.initial_pose.pose
    pose.position.x, pose.position.y = float(x), float(y)
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return request


def spawn(sim, x=1.0, y=1.0, yaw=0.0, *, frame="", **fields):
    """Ask for a box, unless told otherwise; return the answer."""
    pose = pose_message(x, y, yaw, frame).initial_pose
    fields = {"uri": "box", "allow_renaming": True} | fields
    return sim.ask("SpawnEntity", initial_pose=pose, **fields)


def state_of(sim, name: str) -> tuple[float, ...]:
    """Where an entity is, and how it moves: x, y, yaw, vx, vy, turn."""
    answer = sim.ask("GetEntityState", entity=name)
    assert result_of(answer) == OK
    state = answer.state
    q, linear = state.pose.orientation, state.twist.linear
    yaw = math.remainder(2 * math.atan2(q.z, q.w), math.tau)
    place = state.pose.position
    return (place.x, place.y, yaw, linear.x, linear.y, state.twist.angular.z)


def new_state(x, y, yaw=0.0, *, frame="", linear=(0.0, 0.0, 0.0), turn=0.0) -> msg.EntityState:
    """A state to set."""
    state = msg.EntityState()
    state.header.frame_id = frame
    state.pose = pose_message(x, y, yaw).initial_pose.pose
    ahead = state.twist.linear
    ahead.x, ahead.y, ahead.z = map(float, linear)
    state.twist.angular.z = turn
    return state


def move(sim, name: str, state: msg.EntityState) -> tuple[int, str]:
    """Ask for another state of an entity, and return how that went."""
    return result_of(sim.ask("SetEntityState", entity=name, state=state))


def entities(sim, **filters) -> list[str]:
    """Names that pass filters."""
    answer = sim.ask("GetEntities", filters=msg.EntityFilters(**filters))
    assert answer.result.result == Code.OK
    return list(answer.entities)


@pytest.fixture
def sim(make_simulator):
    """A Waffle in a world with a wall, a moving pillar and a zone."""
    sim = make_simulator("scan", "collisions", world=WORLD)
    sim.wait(0.1)
    return sim


def test_codes_are_those_of_the_standard():
    """Of categories, bounds and spawning."""
    for member in Category:
        assert member.value == getattr(EntityCategory, f"CATEGORY_{member.name}")
    kinds = (entity_messages.EMPTY, entity_messages.BOX, entity_messages.SPHERE)
    bounds = msg.Bounds
    assert kinds == (bounds.TYPE_EMPTY, bounds.TYPE_BOX, bounds.TYPE_SPHERE)
    for code in list(SpawnCode)[:-1]:
        assert code.value == getattr(msg.SpawnResult, code.name)
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
    sim = make_simulator(robots=two(waffle))
    assert entities(sim) == ["one", "two"]
    assert state_of(sim, "two")[:2] == pytest.approx((1, 0), abs=1e-3)


def test_states_come_with_the_frame_and_the_time(sim):
    """In the map, at the time of /clock."""
    answer = sim.ask("GetEntitiesStates", filters=msg.EntityFilters(filter="waffle"))
    (state,) = answer.states
    assert list(answer.entities) == ["waffle"]
    assert (state.header.frame_id, state.header.stamp.sec) == ("map", 1)
    assert state.header.stamp.nanosec == 100_000_000


@pytest.mark.parametrize(
    ("filters", "names"),
    sample(
        [
            ({"filter": "^the"}, ["the wall"]),
            ({"filter": "fle$|ling"}, ["waffle", "circling"]),
            ({"categories": [EntityCategory(category=1)]}, ["waffle"]),
            (
                {"categories": [EntityCategory(category=c) for c in (4, 5)]},
                ["the wall", "circling"],
            ),
            ({"tags": msg.TagsFilter(tags=["moving", "robot"])}, ["waffle", "circling"]),
            ({"tags": msg.TagsFilter(tags=["moving", "world"], filter_mode=1)}, ["circling"]),
            ({"filter": "l", "tags": msg.TagsFilter(tags=["robot"])}, ["waffle"]),
            ({"filter": "nobody"}, []),
        ],
        3,
    ),
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
    sample(
        [
            ({"filter": "("}, 4, "filter: not a regular expression (POSIX Extended)"),
            ({"filter": "a" * 201}, 4, "a pattern of at most 200 characters"),
            ({"filter": "(a)\\1"}, 4, "without references back"),
            ({"filter": "((a{1,255}){1,255}){1,255}"}, 4, "its repetitions are too many"),
            (
                {"bounds": volume(2, (0, 0, 0), (1, 0, 0), (0, 1, 0))},
                0,
                "type 1 (box) or 3 (sphere)",
            ),
            ({"bounds": volume(1, (0, 0, 0))}, 4, "expected two points of finite numbers, got 1"),
            ({"bounds": volume(3, (0, math.nan, 0), (1, 0, 0))}, 4, "two points of finite numbers"),
            ({"bounds": volume(99)}, 0, "type 1 (box) or 3 (sphere)"),
        ],
        3,
    ),
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


NAMES = ["box_1", "box_22", "my box", "waffle"]


@pytest.mark.parametrize(
    ("pattern", "result"),
    [
        ("^box_[0-9]+$", ["box_1", "box_22"]),
        ("^box_[0-9]{2}$", ["box_22"]),
        ("(f+le|my )", ["my box", "waffle"]),
        ("^(b|o|x|_|1){5}$", ["box_1"]),
        ("([0-9])+$", ["box_1", "box_22"]),
    ],
)
def test_patterns_with_repetitions_match(pattern, result):
    """Of characters, of sets and of groups."""
    assert matching(pattern, NAMES) == result


REPEATED = ["a" + "+" * 14, "(" * 10 + "a" + "+)" * 10, "((a{1,20}\n?){1,20}\n?){1,20}"]


@pytest.mark.parametrize(
    "pattern", [*REPEATED, "a{1,999}", "(aaaaaaaaaa){1,40}", "a{0,255}{0,255}"]
)
def test_a_pattern_that_multiplies_its_repetitions_is_refused(pattern):
    """A repetition is compiled to copies: 31 of them, one after the other, take all memory."""
    with pytest.raises(PatternError, match="its repetitions are too many"):
        matching(pattern, NAMES)


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
    assert result_of(sim.ask("SetEntityInfo", entity="crate", info=info)) == OK
    assert sim.ask("GetEntityInfo", entity="crate").info == info
    assert entities(sim, tags=msg.TagsFilter(tags=["fragile"])) == ["crate"]
    sim.ask("DeleteEntity", entity="crate")
    spawn(sim, name="crate")
    assert sim.ask("GetEntityInfo", entity="crate").info.tags == ["spawned"]


OF_STATE_AND_INFO = [f"{what}Entity{of}" for what in ("Get", "Set") for of in ("State", "Info")]


@pytest.mark.parametrize("kind", ["DeleteEntity", "GetEntityBounds", *OF_STATE_AND_INFO])
@pytest.mark.parametrize(
    "name", sample(["<b>waffle</b>\x1b[31m", "", "nobody", "w" * 10_000], every=4)
)
def test_a_name_that_nobody_has_is_not_found(sim, kind, name):
    """The error lists those that there are, without control characters, and the nearest name."""
    result, text = result_of(sim.ask(kind, entity=name))
    assert result == Code.NOT_FOUND
    assert "there are waffle, the wall, circling" in text
    assert "\x1b" not in text
    assert len(text) < 300
    assert result_of(sim.ask(kind, entity="wafle"))[1].endswith("; did you mean 'waffle'?")


# ---- spawned -----------------------------------------------------------------------------


def test_what_is_spawned_is_there_for_the_lidar(sim):
    """One metre ahead of the robot, which looks along y."""
    answer = spawn(sim, -1.0, 1.5, uri="cylinder?radius=0.2", name="pillar")
    assert result_of(answer) == OK
    sim.wait(0.1)
    ahead = sim.stage.messages("scan")[-1].ranges[0]
    lidar_x = sim.node.robots[0].robot.lidar.x
    assert ahead == pytest.approx(1.0 - 0.2 - lidar_x, abs=0.05)
    assert result_of(sim.ask("DeleteEntity", entity="pillar")) == OK
    sim.wait(0.1)
    assert sim.stage.messages("scan")[-1].ranges[0] > 2.0
    assert entities(sim) == ["waffle", "the wall", "circling"]


def test_names_are_made_up_where_that_is_allowed(sim):
    """After what it is, or what was asked for."""
    names = [spawn(sim, x, -3.0).entity_name for x in (0.0, 1.0)]
    names.append(spawn(sim, 2.0, -3.0, name="waffle").entity_name)
    text = "{name: crate, size: [0.2, 0.2, 0.2], colour: red}"
    names.append(spawn(sim, 3.0, -3.0, uri="", resource_string=text).entity_name)
    assert names == ["box", "box_2", "waffle_2", "crate"]
    assert state_of(sim, "box_2")[:3] == (1.0, -3.0, 0.0)


def test_a_pose_may_be_relative_to_an_entity(sim):
    """One metre ahead of the robot, turned as the robot is and a little more."""
    assert result_of(spawn(sim, 1.0, 0.0, 0.1, frame="waffle", name="crate")) == OK
    assert state_of(sim, "crate")[:3] == pytest.approx((-1, 1.5, math.pi / 2 + 0.1), abs=1e-3)


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    sample(
        [
            ({"name": "", "allow_renaming": False}, 102, "no name is given"),
            ({"name": "waffle", "allow_renaming": False}, 101, "the name 'waffle' is taken"),
            ({"name": "a\x1b[31m"}, 102, "expected a name of 1 to 60 letters"),
            ({"name": "<b>"}, 102, "got '<b>'"),
            ({"name": "a" * 61}, 102, "expected a name of 1 to 60"),
            ({"uri": ""}, 104, "neither a URI nor a text"),
            ({"uri": "file:///etc/passwd"}, 103, "unknown entity 'file:///etc/passwd'"),
            ({"uri": "bx"}, 103, "colour=red; did you mean 'box'?"),
            ({"uri": "burger"}, 0, "robots cannot be added to a running simulation"),
            ({"uri": "box?size=[0.2,0.4]"}, 106, "'2' is missing"),
            ({"uri": "box?wings=2"}, 106, "wings"),
            ({"uri": "box?size=[0.2,0.4,nan]"}, 106, "expected a number, got string 'nan'"),
            ({"uri": "box?colour=plaid"}, 106, "plaid"),
            ({"uri": "box?radius=0.2"}, 4, "got both"),
            ({"uri": "", "resource_string": "<sdf version='1.9'/>"}, 103, "SDF, URDF and MJCF"),
            ({"uri": "", "resource_string": "a: &a [*a]"}, 106, "a"),
            ({"uri": "", "resource_string": "size: [1, 1, 1]" + " " * 5000}, 103, "at most 4000"),
            ({"entity_namespace": "not a namespace!"}, 105, "expected a namespace such as /shelf"),
            ({"x": 7.0}, 109, "(7, 1) is not on the floor of 10 m x 10 m"),
            ({"x": math.nan}, 109, "expected a pose of finite numbers"),
            ({"y": math.inf}, 109, "expected a pose of finite numbers"),
            ({"frame": "moon"}, 109, "no frame is known as 'moon'"),
            ({"x": -1.0, "y": 0.5}, 4, "it would be in the robot"),
            ({"x": 0.0, "y": 3.0}, 4, "it would be in 'the wall'"),
        ],
        4,
    ),
)
def test_what_cannot_be_spawned_is_refused(sim, fields, code, words):
    """With the standard's code and the reason; nothing is there then."""
    answer = spawn(sim, **fields)
    result, text = result_of(answer)
    assert (result, answer.entity_name) == (code, "")
    assert words in text
    assert "\x1b" not in text
    assert entities(sim) == ["waffle", "the wall", "circling"]


@pytest.mark.parametrize(
    ("z", "quaternion", "words"),
    [
        (0.5, (0, 0, 0, 1), "expected z = 0, on the floor, got 0.5 m"),
        (0.0, (0, 0, 0, 2), "expected a quaternion of length 1, got one of 2"),
        (0.0, (0, 0, 1e300, 1), "expected a quaternion of length 1"),
        (0.0, (0, 0, math.nan, 1), "expected a pose of finite numbers"),
        (0.0, (1, 0, 0, 0), "about the vertical axis only"),
    ],
)
def test_a_pose_that_is_none_is_refused(sim, z, quaternion, words):
    """All stands upright on the floor; for spawning and for moving alike."""
    request = pose_message(1.0, 1.0)
    pose = request.initial_pose.pose
    pose.position.z = z
    q = pose.orientation
    q.x, q.y, q.z, q.w = map(float, quaternion)
    spawned = sim.ask("SpawnEntity", uri="box", name="it", initial_pose=request.initial_pose)
    for (result, text), code in (
        (result_of(spawned), SpawnCode.INVALID_POSE),
        (move(sim, "waffle", msg.EntityState(pose=pose)), INVALID_POSE),
    ):
        assert result == code
        assert words in text


def test_no_more_than_there_is_room_for_is_spawned(sim):
    """Four at a time here; the fifth is told what to do."""
    for x in range(4):
        assert result_of(spawn(sim, float(x), -3.0)) == OK
    result, text = result_of(spawn(sim, 4.0, -3.0))
    assert (result, len(entities(sim))) == (Code.OPERATION_FAILED, 7)
    assert "remove one" in text


def test_several_are_spawned_at_once_and_each_is_told_of(sim):
    """One that fails does not stop the others."""
    requests = [pose_message(x, -3.0) for x in (0.0, 9.0, 2.0)]
    for number, request in enumerate(requests):
        request.name, request.entity_resource.uri = f"box {number}", "box"
    answer = sim.ask("SpawnEntities", spawn_requests=requests)
    words = "1 of 3 were not spawned; see results"
    assert result_of(answer) == (SpawnCode.ENTITIES_SPAWN_FAILED, words)
    assert [result.result.result for result in answer.results] == [1, SpawnCode.INVALID_POSE, 1]
    assert [result.entity_name for result in answer.results] == ["box 0", "", "box 2"]
    too_many = sim.ask("SpawnEntities", spawn_requests=[msg.SpawnEntity()] * 65)
    assert result_of(too_many) == (Code.OPERATION_FAILED, "expected at most 64 requests, got 65")


def test_what_can_be_spawned_is_listed(sim):
    """Each can be asked for as it is; sources elsewhere are not looked at."""
    answer = sim.ask("GetSpawnables", sources=["http://shop"])
    assert result_of(answer) == (Code.OK, "not known as sources: 'http://shop'")
    for x, first in enumerate(answer.spawnables):
        assert result_of(spawn(sim, float(x), -3.0, uri=first.uri)) == OK
    assert entities(sim)[3:] == ["box", "cylinder"]


@pytest.mark.parametrize(
    ("name", "words"), [("waffle", "is a robot"), ("the wall", "is a part of the world")]
)
def test_only_what_was_spawned_is_deleted(sim, name, words):
    """Robots and the world stay."""
    result, text = result_of(sim.ask("DeleteEntity", entity=name))
    assert (result, name in entities(sim)) == (Code.FEATURE_UNSUPPORTED, True)
    assert words in text


# ---- moved -------------------------------------------------------------------------------


def test_a_robot_is_put_elsewhere(sim):
    """At once; neither its odometry nor its distance notices, as when somebody carries it."""
    robot = sim.node.robots[0]
    sim.stage.command(0.2)
    sim.wait(0.05)
    way, odometry = robot.distance_travelled, robot.read_odometry().x
    assert move(sim, "waffle", new_state(2, -2, 1.0)) == OK
    assert state_of(sim, "waffle") == pytest.approx((2, -2, 1, 0, 0, 0), abs=1e-9)
    assert robot.distance_travelled == pytest.approx(way)
    assert robot.read_odometry().x == pytest.approx(odometry)
    sim.wait(0.5)
    assert state_of(sim, "waffle")[:3] == pytest.approx((2, -2, 1), abs=0.06)
    assert sim.stage.messages("collisions") == []


def test_what_was_spawned_is_put_elsewhere_and_moves_on(sim):
    """In the frame of the robot, which looks along y: ahead is along y."""
    spawn(sim, name="crate")
    state = new_state(1, 0, frame="waffle", linear=(0.4, 0.0, 0.0))
    assert move(sim, "crate", state) == OK
    sim.wait(0.5)
    x, y, yaw, vx, vy, _ = state_of(sim, "crate")
    assert (x, y, yaw) == pytest.approx((-1, 1.7, math.pi / 2), abs=1e-3)
    assert (vx, vy) == pytest.approx((0, 0.4), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "state", "code", "words"),
    sample(
        [
            ("the wall", new_state(0, 0), 0, "is a part of the world"),
            ("circling", new_state(0, 0), 0, "is a part of the world"),
            ("crate", new_state(0, 3), 4, "it would be in 'the wall'"),
            ("crate", new_state(-1, 0.5), 4, "it would be in the robot"),
            ("waffle", new_state(1, 1), 4, "it would be in 'crate'"),
            ("waffle", new_state(50, 1), INVALID_POSE, "is not on the floor"),
            ("crate", new_state(math.nan, 1), INVALID_POSE, "finite numbers"),
            ("crate", new_state(2, 2, linear=(9, 0, 0)), 4, "expected at most 4 m/s"),
            ("crate", new_state(2, 2, linear=(0, 0, 1)), INVALID_POSE, "along the floor"),
            ("crate", new_state(2, 2, turn=1.0), 4, "'crate' cannot keep turning"),
            ("crate", new_state(2, 2, linear=(math.inf, 0, 0)), INVALID_POSE, "finite numbers"),
            ("crate", new_state(2, 2, frame="moon"), INVALID_POSE, "no frame is known as 'moon'"),
        ],
        3,
    ),
)
def test_what_cannot_be_moved_stays(sim, name, state, code, words):
    """With the reason; nothing has changed then."""
    spawn(sim, name="crate")
    before = {entity: state_of(sim, entity) for entity in entities(sim)}
    result, text = move(sim, name, state)
    assert result == code
    assert words in text
    assert {entity: state_of(sim, entity) for entity in entities(sim)} == before
