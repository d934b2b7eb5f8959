"""Sensors of what is near: bumpers, distances, cliffs, depths."""

import math
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.robots.model import load_robot
from sim.ros.sensor_topics import empty_message
from tests.support.simulated import alone
from tests.support.thorough import sample

WALL = {"name": "wall", "from": [1.0, -2.0], "to": [1.0, 2.0], "thickness": 0.1}


@pytest.fixture(scope="module")
def turtlebot4():
    """A robot with bumpers, cliff sensors and a depth camera."""
    return load_robot("turtlebot4")


@pytest.fixture(scope="module")
def rosbot():
    """A robot with four infrared sensors."""
    return load_robot("rosbot")


def sensors(robot):
    """The sensors of a robot by their topics."""
    return {sensor.topic: sensor for sensor in robot.sensors}


def pressed(robot):
    """The bumpers that are pressed."""
    return [
        topic
        for topic, sensor in sensors(robot).items()
        if topic.startswith("bumper") and sensor.is_pressed()
    ]


@pytest.mark.parametrize(("yaw", "zone"), [(0, "front_center"), (35, "front_right"), (-70, "left")])
def test_the_bumper_that_touches_is_pressed_until_the_base_backs_up(
    make_world, drive, turtlebot4, yaw, zone
):
    """The zone is where the wall is, seen from the robot; turning is enough to reach the others."""
    near = 0.95 - 0.1 - turtlebot4.body.radius
    world = make_world(walls=[WALL], spawn={"x": near, "yaw": 0})
    robot = alone(world, turtlebot4)
    drive(robot, 1.0, linear=0.2)
    assert pressed(robot) == ["bumper_front_center"]
    drive(robot, 1.0, linear=-0.2)
    assert pressed(robot) == []
    heading = math.radians(yaw)
    place = 0.95 - turtlebot4.body.radius + 0.0005
    robot.put((place - 0.01, 0.0, heading))
    robot._qpos[0] = place
    robot.physics.put_in_place()
    assert pressed(robot) == [f"bumper_{zone}"]


def test_a_bumper_is_published_at_its_rate(make_world, drive, turtlebot4):
    """Pressed or not: silence means that it has failed."""
    robot = alone(make_world(walls=[WALL], spawn={"x": 0.6}), turtlebot4)
    bumper = sensors(robot)["bumper_front_center"]
    message = empty_message(bumper, Time())
    assert [(bumper.fill(message, index), message.data) for index in range(2)] == [
        (True, False)
    ] * 2
    drive(robot, 2.0, linear=0.2)
    assert (bumper.fill(message, 2), message.data) == (True, True)


def test_an_infrared_sensor_measures_where_it_looks(make_world, rosbot):
    """12.5 degrees to the left: the distance to the wall along that ray, with 5 mm of noise."""
    robot = alone(make_world(walls=[WALL], spawn={"x": 0.3}), rosbot)
    sensor = sensors(robot)["range_front_left"]
    readings = np.array([sensor.numbers(index)[0] for index in range(200)])
    expected = (0.95 - 0.3 - 0.0926) / math.cos(math.radians(12.5))
    assert readings.mean() == pytest.approx(expected, abs=0.002)
    assert readings.std() == pytest.approx(0.005, rel=0.2)
    assert sensors(robot)["range_rear_left"].numbers(0) == (math.inf,)
    message = empty_message(sensor, Time())
    assert (message.radiation_type, message.max_range) == (1, pytest.approx(0.9))


def test_a_sonar_measures_the_nearest_thing_in_its_field_of_view(make_world, waffle):
    """Across 30 degrees: a pillar at 12 degrees is seen, at 20 degrees it is not."""
    sonar = {"kind": "sonar", "x": 0, "y": 0, "z": 0.1, "rate": 10, "field_of_view": 30}
    sonar |= {"min_range": 0.3, "max_range": 2.0}
    data = waffle.model_dump() | {"range_sensors": {"front": sonar}}
    model = type(waffle).model_validate(data)

    def seen(distance, degrees):
        at = math.radians(degrees)
        pillar = {"x": distance * math.cos(at), "y": distance * math.sin(at), "radius": 0.05}
        return sensors(alone(make_world(cylinders=[pillar]), model))["range_front"].numbers(0)[0]

    assert seen(1.0, 12) == pytest.approx(0.95, abs=0.01)
    assert (seen(1.0, 20), seen(2.2, 0), seen(0.32, 0)) == (math.inf, math.inf, -math.inf)


def test_a_cliff_is_the_edge_of_the_floor(make_world, drive, turtlebot4):
    """19.2 mm above the floor; beyond the edge, nothing."""
    robot = alone(make_world(size=[2, 20]), turtlebot4)
    front = sensors(robot)["range_cliff_front_left"]
    side = sensors(robot)["range_cliff_side_left"]
    assert front.numbers(0)[0] == pytest.approx(0.0192, abs=0.001)
    robot.put((0.88, 0.0, 0.0))
    assert front.numbers(0) == (math.inf,)
    assert side.numbers(0)[0] == pytest.approx(0.0192, abs=0.001)


def test_depths_are_measured_along_the_axis(make_world, turtlebot4):
    """A wall straight ahead has one depth across the image; the floor is nearer at the bottom."""
    robot = alone(make_world(walls=[WALL | {"height": 1.0}]), turtlebot4)
    topics = sensors(robot)
    camera, spec = topics["camera/depth/image_rect_raw"], turtlebot4.depth_camera
    depths = camera.measure(0).reshape(spec.height, spec.width)
    middle = depths[spec.height // 2]
    assert middle.mean() == pytest.approx(0.95 + 0.0596, abs=0.002)
    assert np.abs(middle - middle.mean()).max() < 0.06
    bottom = spec.z / ((spec.height - 1) / spec.width * math.tan(spec.hfov / 2))
    assert depths[-1].mean() == pytest.approx(bottom, abs=0.01)
    message = empty_message(camera, Time())
    camera.fill(message, 0)
    received = deserialize_message(serialize_message(message), type(message))
    sent = np.frombuffer(received.data, np.float32).reshape(spec.height, -1)
    assert (received.encoding, received.step) == ("32FC1", 4 * spec.width)
    assert sent == pytest.approx(depths, rel=1e-6)
    info = empty_message(topics["camera/depth/camera_info"], Time())
    assert info.k[0] == pytest.approx(80 / math.tan(1.25 / 2))


@pytest.mark.parametrize(
    ("key", "old", "new", "words"),
    [
        ("right:", "sector: [-90.0, -54.0]", "sector: [-54.0, -90.0]", "sector must reach from"),
        ("right:", "rate: 20.0}", "rate: 0}", "more than 0"),
        ("range_sensors:", "z: 0.0192", "z: 0.2", "cliff_side_left: a cliff sensor 0.2 m above"),
        ("depth_camera:", "max_range: 10.0", "max_range: 0.2", "min_range 0.3 m must be below"),
    ],
)
def test_figures_that_do_not_fit_are_refused_at_their_key(key, old, new, words):
    """With the line of the sensor, or of the section that has it."""
    text = Path("robots/turtlebot4.yaml").read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(InputError, match=words) as caught:
        load_robot(read_text(text.replace(old, new, 1), "mine.yaml"))
    line = 1 + text[: text.index(key)].count("\n")
    assert all(line <= each.line <= line + 12 for each in caught.value.diagnostics)


LOW = """\
mission: low
robot: turtlebot4
world: {world}
tree:
  explore_forward: {{fwd_velocity: 0.2, stopping_distance: 0.3}}
  name: drive
  timeout: 60
"""
STEP = """\
name: step
size: [4, 4]
boxes: [{name: step, x: 1.2, y: 0, size: [0.4, 1.0, 0.08]}]
"""


@pytest.mark.parametrize(
    ("world", "words", "farthest"),
    sample(
        [
            (STEP, "the bumper front_center is pressed", 1.0 - 0.17),
            ("name: edge\nsize: [2.4, 4]\n", "sees no floor", 1.2 - 0.1),
        ],
        2,
    ),
    ids=["a box lower than the lidar", "the edge of the floor"],
)
def test_the_governor_stops_what_the_lidar_does_not_see(stage, tmp_path, world, words, farthest):
    """The goal ends with the sensor that holds the base, which has not driven on."""
    (tmp_path / "low.yaml").write_text(world)
    run = stage.run(LOW.format(world=tmp_path / "low.yaml"), seed=1)
    run.until_done()
    assert not run.succeeded
    assert words in run.reason
    assert run.pose[0] < farthest + 0.02


@pytest.mark.parametrize("topic", ["bumper_front_left", "range_cliff_front_left"])
def test_a_silent_bumper_or_cliff_sensor_stops_the_base(stage, topic):
    """As a silent lidar does: the base stands after 0.6 s, and the goal ends after 1 s."""
    world = Path("worlds/wide_arena.yaml").resolve()
    run = stage.run(LOW.format(world=world), seed=1)
    run.at(1.0, stage.faults.drop(topic))
    run.until_done()
    assert f"no {topic} for 1 s: the last is 1." in run.reason
    assert "(code 902)" in run.reason
    assert run.check("whenever time >= 1.95: abs(speed) < 0.01")
