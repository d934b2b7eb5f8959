"""The standard services for what is in a simulation: spawned, deleted and moved."""

import math

import pytest
from simulation_interfaces import msg

from sim.ros.entity_services import INVALID_POSE, SpawnCode
from sim.ros.requests import Code
from tests.sim.ros.conftest import result_of
from tests.support.entities import WORLD, entities, new_state, pose_message, spawn, state_of


@pytest.fixture
def sim(make_simulator):
    """A Waffle in a world with a wall, a moving pillar and a zone."""
    sim = make_simulator("scan", "collisions", world=WORLD)
    sim.wait(0.1)
    return sim


# ---- spawned -----------------------------------------------------------------------------


def test_what_is_spawned_is_there_for_the_lidar(sim):
    """One metre ahead of the robot, which looks along y."""
    assert result_of(spawn(sim, -1.0, 1.5, uri="cylinder?radius=0.2", name="pillar")) == (
        Code.OK,
        "",
    )
    sim.wait(0.1)
    ahead = sim.stage.messages("scan")[-1].ranges[0]
    lidar_x = sim.node.robots[0].robot.lidar.x
    assert ahead == pytest.approx(1.0 - 0.2 - lidar_x, abs=0.05)
    assert result_of(sim.ask("DeleteEntity", entity="pillar")) == (Code.OK, "")
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
    assert result_of(spawn(sim, 1.0, 0.0, 0.1, frame="waffle", name="crate")) == (Code.OK, "")
    assert state_of(sim, "crate")[:3] == pytest.approx((-1, 1.5, math.pi / 2 + 0.1), abs=1e-3)


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    [
        ({"name": "", "allow_renaming": False}, 102, "no name is given"),
        ({"name": "waffle", "allow_renaming": False}, 101, "the name 'waffle' is taken"),
        ({"name": "a\x1b[31m"}, 102, "expected a name of 1 to 60 letters"),
        ({"name": "<b>"}, 102, "got '<b>'"),
        ({"name": "a" * 61}, 102, "expected a name of 1 to 60"),
        ({"uri": ""}, 104, "neither a URI nor a text"),
        ({"uri": "file:///etc/passwd"}, 103, "unknown entity 'file:///etc/passwd'"),
        ({"uri": "bx"}, 103, "did you mean 'box'?"),
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
    fields = {"uri": "box", "allow_renaming": True, "initial_pose": request.initial_pose}
    for answer, code in (
        (sim.ask("SpawnEntity", **fields), SpawnCode.INVALID_POSE),
        (
            sim.ask("SetEntityState", entity="waffle", state=msg.EntityState(pose=pose)),
            INVALID_POSE,
        ),
    ):
        result, text = result_of(answer)
        assert result == code
        assert words in text


def test_no_more_than_there_is_room_for_is_spawned(sim):
    """Four at a time here; the fifth is told what to do."""
    for x in range(4):
        assert result_of(spawn(sim, float(x), -3.0)) == (Code.OK, "")
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
        assert result_of(spawn(sim, float(x), -3.0, uri=first.uri)) == (Code.OK, "")
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
    assert result_of(sim.ask("SetEntityState", entity="waffle", state=new_state(2, -2, 1.0))) == (
        1,
        "",
    )
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
    assert result_of(sim.ask("SetEntityState", entity="crate", state=state)) == (Code.OK, "")
    sim.wait(0.5)
    x, y, yaw, vx, vy, _ = state_of(sim, "crate")
    assert (x, y, yaw) == pytest.approx((-1, 1.7, math.pi / 2), abs=1e-3)
    assert (vx, vy) == pytest.approx((0, 0.4), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "state", "code", "words"),
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
)
def test_what_cannot_be_moved_stays(sim, name, state, code, words):
    """With the reason; nothing has changed then."""
    spawn(sim, name="crate")
    before = {entity: state_of(sim, entity) for entity in entities(sim)}
    result, text = result_of(sim.ask("SetEntityState", entity=name, state=state))
    assert result == code
    assert words in text
    assert {entity: state_of(sim, entity) for entity in entities(sim)} == before
