"""The node: topics, types, QoS and frames of a TurtleBot3, on virtual time."""

import hashlib
import math
from dataclasses import astuple
from itertools import pairwise

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from lifecycle_msgs.srv import GetState
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from action_servers.robot_io.messages import pose_of, transform_of
from bt_mission.base.geometry import composed
from sim.physics.spawn import RobotSpawn
from sim.robot.localization import Localization, LocalizationError
from sim.ros.node import SimNode, SimOptions
from sim.ros.schedule import RateError, period_of
from sim.sensors.canvas import NoCameraError
from sim.world.loader import load_world
from sim.world.occupancy import rasterise
from sim.world.world import World
from tests.support.simulated import alone

S, MS = 1_000_000_000, 1_000_000
TYPES = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "map": "nav_msgs/msg/OccupancyGrid",
    "tf_static": "tf2_msgs/msg/TFMessage",
    "collisions": "bt_mission_interfaces/msg/Collision",
    "joint_states": "sensor_msgs/msg/JointState",
    "odom": "nav_msgs/msg/Odometry",
    "tf": "tf2_msgs/msg/TFMessage",
    "ground_truth/odom": "nav_msgs/msg/Odometry",
    "imu": "sensor_msgs/msg/Imu",
    "scan": "sensor_msgs/msg/LaserScan",
    "battery_state": "sensor_msgs/msg/BatteryState",
    "motors_on": "std_msgs/msg/Bool",
    "camera/image_raw": "sensor_msgs/msg/Image",
    "camera/camera_info": "sensor_msgs/msg/CameraInfo",
}
QUIET = [topic for topic in TYPES if not topic.startswith("camera")]
WALLED = World.model_validate(
    {
        "name": "walled",
        "size": [4, 4],
        "spawn": {"x": -0.5, "y": 0.25, "yaw": 90},
        "walls": [{"name": "the wall", "from": [-1, 1], "to": [1, 1], "thickness": 0.1}],
    }
)


@pytest.fixture
def stage(make_stage):
    """Makes stages in the walled world, unless told otherwise."""
    return lambda *topics, world=WALLED, **options: make_stage(world, *topics, **options)


def stamp_ns(stamp):
    """A stamp in nanoseconds."""
    return stamp.sec * S + stamp.nanosec


@pytest.mark.parametrize(("topic", "kind"), TYPES.items())
def test_topics_have_the_types_and_qos_of_a_turtlebot3(stage, topic, kind):
    """Best effort for the scan, latched for map and fixed frames, reliable for the rest."""
    (info,) = stage().sim.get_publishers_info_by_topic(topic)
    assert info.topic_type == kind
    best_effort = info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    latched = info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert best_effort == (topic == "scan")
    assert latched == (topic in {"map", "tf_static", "motors_on"})


@pytest.mark.parametrize(
    ("command_type", "kind"), [("stamped", "TwistStamped"), ("plain", "Twist")]
)
def test_commands_are_stamped_or_plain_twists(stage, command_type, kind):
    """As `enable_stamped_cmd_vel` has it on Jazzy, true or false: the wheels turn."""
    here = stage(command_type=command_type)
    (info,) = here.sim.get_subscriptions_info_by_topic("cmd_vel")
    assert info.topic_type == f"geometry_msgs/msg/{kind}"
    assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    for time_ms in range(0, 500, 50):
        here.run(S + time_ms * MS)
        here.command(0.1)
    assert here.sim.robots[0].velocity[0] == pytest.approx(0.1, abs=0.01)


def test_programs_for_nav2_find_the_robot_localised(stage):
    """They ask AMCL for its state, and wait for a pose of its."""
    here = stage(lean=False)
    asked = here.ear.create_client(GetState, "amcl/get_state").call_async(GetState.Request())
    poses: list[PoseWithCovarianceStamped] = []
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    here.ear.create_subscription(PoseWithCovarianceStamped, "amcl_pose", poses.append, qos)
    here.run(1 * S + 100 * MS)
    assert asked.result().current_state.label == "active"
    place = poses[0].pose.pose
    assert (place.position.x, place.position.y) == pytest.approx((-0.5, 0.25), abs=0.01)
    assert place.orientation.z == pytest.approx(math.sqrt(0.5), abs=0.01)


def test_amcl_pose_is_the_pose_of_tf(stage):
    """With the error of localization, not the true one."""
    here = stage("tf", lean=False)
    poses: list[PoseWithCovarianceStamped] = []
    here.ear.create_subscription(PoseWithCovarianceStamped, "amcl_pose", poses.append, 10)
    (robot,) = here.sim.robots
    robot.localization = Localization(LocalizationError(place=0.2, yaw=0.1), 1, "")
    for time_ms in range(0, 4000, 50):
        here.run(1 * S + time_ms * MS)
        here.command(0.15, 0.1)
    transforms = {
        (stamp_ns(each.header.stamp), each.child_frame_id): each.transform
        for message in here.messages("tf")
        for each in message.transforms
    }
    assert len(poses) == 8
    for pose in poses:
        stamp = stamp_ns(pose.header.stamp)
        odom, base = (transform_of(transforms[stamp, name]) for name in ("odom", "base_footprint"))
        assert odom is not None
        assert base is not None
        expected, reported = composed(odom, base), pose_of(pose.pose.pose)
        assert reported is not None
        assert astuple(reported) == pytest.approx(astuple(expected), abs=1e-9)
    x, y, _ = robot.pose
    assert math.dist((pose.pose.pose.position.x, pose.pose.pose.position.y), (x, y)) > 0.05


def test_map_and_the_way_to_it_are_left_to_others(stage):
    """Two publishers of a transform would have the robot jump between them; so would two AMCLs."""
    here = stage("tf", with_map=False, localises=False, lean=False)
    here.run(1 * S + 100 * MS)
    assert here.sim.get_publishers_info_by_topic("map") == []
    frames = {
        (transform.header.frame_id, transform.child_frame_id)
        for message in here.messages("tf")
        for transform in message.transforms
    }
    assert frames == {("odom", "base_footprint")}
    assert not [name for name, _ in here.sim.get_service_names_and_types() if "amcl" in name]


def test_names_are_relative(stage):
    """A namespace moves every topic but the clock, of which there is one."""
    node = stage(namespace="robot1").sim
    assert {publisher.topic_name for publisher in node.publishers} >= {
        topic if topic.startswith("/") else f"/robot1/{topic}" for topic in TYPES
    }


def test_everything_is_published_at_its_rate_from_the_start_on(stage):
    """In 0.5 s, both ends included: 11 at 20 Hz, 6 scans at 10 Hz, the map once.

    Of one instant, the clock comes first, the scan last.
    """
    here = stage(*QUIET)
    here.run(1 * S)
    assert [topic for topic, _ in here.received] == [
        topic for topic in QUIET if topic != "collisions"
    ]
    here.run(1 * S + 500 * MS)
    others = {"map": 1, "tf_static": 1, "collisions": 0, "scan": 6, "motors_on": 1}
    for topic in QUIET:
        assert len(here.messages(topic)) == others.get(topic, 11), topic
    assert [stamp_ns(clock.clock) for clock in here.messages("/clock")] == [
        1 * S + step * 50 * MS for step in range(11)
    ]
    assert [stamp_ns(scan.header.stamp) for scan in here.messages("scan")] == [
        1 * S + step * 100 * MS for step in range(6)
    ]


@pytest.mark.parametrize("rate", [5, 10, 20, 40, 100, 200])
def test_periods_are_whole_steps(rate):
    """The usual rates fit 5 ms."""
    assert period_of(rate, "lidar.rate") == S / rate


@pytest.mark.parametrize("rate", [30.0, 400.0, 7.0])
def test_a_rate_that_does_not_fit_is_refused_with_both_numbers(rate):
    """The message names what was to run, its rate and the step."""
    with pytest.raises(RateError, match=rf"camera\.rate: .* of 5 ms, got {rate:g} Hz"):
        period_of(rate, "camera.rate")


def test_frames_are_those_of_a_turtlebot3(stage):
    """Map, odom and base_footprint move; the rest of the tree is fixed."""
    here = stage(*QUIET, "camera/camera_info")
    here.run(1 * S)
    frame = {topic: here.messages(topic)[0].header.frame_id for topic in ("scan", "imu", "map")}
    assert frame == {"scan": "base_scan", "imu": "imu_link", "map": "map"}
    assert here.messages("camera/camera_info")[0].header.frame_id == "camera_rgb_frame"
    for topic, parent in (("odom", "odom"), ("ground_truth/odom", "map")):
        message = here.messages(topic)[0]
        assert (message.header.frame_id, message.child_frame_id) == (parent, "base_footprint")
    pairs = [
        (transform.header.frame_id, transform.child_frame_id)
        for topic in ("tf", "tf_static")
        for transform in here.messages(topic)[0].transforms
    ]
    chain = ("map", "odom", "base_footprint", "base_link")
    assert pairs[:3] == list(pairwise(chain))
    assert len(pairs) == 12
    fixed = {frame.child_frame_id: frame for frame in here.messages("tf_static")[0].transforms}
    at = fixed["base_scan"].transform.translation
    assert (at.x, at.y, at.z) == pytest.approx((-0.064, 0.0, 0.122))
    turn = fixed["wheel_left_link"].transform.rotation
    assert (turn.x, turn.w) == pytest.approx((-math.sqrt(0.5), math.sqrt(0.5)))
    assert list(here.messages("joint_states")[0].name) == ["wheel_left_joint", "wheel_right_joint"]


def test_odometry_starts_at_zero_and_the_truth_at_the_spawn(stage):
    """Map to odom is what lies between them."""
    here = stage("odom", "ground_truth/odom", "tf")
    here.run(1 * S)
    odom, truth = (here.messages(topic)[0].pose.pose for topic in ("odom", "ground_truth/odom"))
    assert (odom.position.x, odom.position.y, odom.orientation.w) == (0, 0, 1)
    assert (truth.position.x, truth.position.y) == pytest.approx((-0.5, 0.25), abs=1e-5)
    assert truth.orientation.z == pytest.approx(math.sqrt(0.5), abs=1e-5)
    to_odom = here.messages("tf")[0].transforms[0].transform
    assert (to_odom.translation.x, to_odom.translation.y) == pytest.approx((-0.5, 0.25), abs=1e-5)


def test_map_is_the_world_seen_from_above(stage):
    """Row-major from the corner with the smallest x and y, 0.05 m a cell."""
    world = load_world("nav_arena")
    here = stage("map", world=world)
    here.run(1 * S)
    (grid,) = here.messages("map")
    drawn = rasterise(world)
    assert (grid.info.width, grid.info.height) == (100, 100)
    assert grid.info.resolution == pytest.approx(0.05)
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == (-2.5, -2.5)
    assert grid.info.origin.orientation.w == 1
    assert np.array_equal(np.array(grid.data).reshape(100, 100), drawn.cells)


def test_map_reaches_those_who_come_late(stage):
    """It is latched, as a map server's. What was sent before comes from a thread of DDS's own."""
    here = stage()
    here.run(2 * S)
    here.listen("map")
    while not here.messages("map") and here.clock.now_ns < 1000 * S:
        here.clock.step()
    assert len(here.messages("map")) == 1


def test_scan_has_what_the_simulation_measures(stage, waffle):
    """The wall 0.7 m ahead of the axle, and the limits of an LDS-01."""
    here = stage("scan")
    here.run(1 * S)
    (scan,) = here.messages("scan")
    expected = alone(WALLED, waffle, seed=1).scan(0)
    assert np.array_equal(np.array(scan.ranges, dtype=np.float32), expected)
    assert scan.ranges[0] == pytest.approx(0.7 + 0.064, abs=0.05)
    assert (scan.range_min, scan.range_max) == pytest.approx((0.12, 3.5))


def test_a_command_moves_the_robot_and_runs_out(stage):
    """Commanded once, it drives for 0.2 s and stops: 0.02 m on each ramp."""
    here = stage("odom")
    here.run(1 * S)
    here.command(0.2)
    here.run(1 * S + 200 * MS)
    assert here.sim.robots[0].commanded == (0.2, 0.0)
    here.run(2 * S)
    last = here.messages("odom")[-1]
    assert last.pose.pose.position.x == pytest.approx(0.04, abs=0.005)
    assert last.twist.twist.linear.x == pytest.approx(0, abs=1e-3)
    assert here.sim.robots[0].commanded == (0.0, 0.0)


def test_of_commands_that_wait_the_newest_counts(context, waffle):
    """Without a virtual clock, a late simulator takes one between two steps, and no old one."""
    options = SimOptions(seed=0, camera=False, context=context)
    sim = SimNode(load_world("empty_arena"), [RobotSpawn(waffle)], options)
    driver = Node("driver", context=context)
    commands = driver.create_publisher(TwistStamped, "cmd_vel", 10)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(sim)
    while not commands.get_subscription_count():
        executor.spin_once(timeout_sec=0.01)
    for speed in (0.01, 0.02, 0.03, 0.05):
        message = TwistStamped()
        message.twist.linear.x = speed
        commands.publish(message)
    while not sim.robots[0].commanded[0]:
        executor.spin_once(timeout_sec=1.0)
        sim.advance_to(sim.physics.time_ns + 100 * MS)
    assert sim.robots[0].commanded[0] == pytest.approx(0.05)
    executor.shutdown()
    driver.destroy_node()
    sim.destroy_node()


def test_a_collision_is_published_once(stage):
    """With the time of its onset, between the publications."""
    here = stage("collisions")
    for step in range(100):
        here.run(1 * S + step * 50 * MS)
        here.command(0.25)
    (collision,) = here.messages("collisions")
    assert collision.obstacle == "the wall"
    assert collision.header.frame_id == "map"
    assert collision.point.y == pytest.approx(0.95, abs=0.01)
    assert collision.force > 0
    assert here.sim.robots[0].collisions == 1
    assert 3 * S < stamp_ns(collision.header.stamp) < 4 * S


def test_advance_stops_at_the_last_whole_step(stage):
    """Whoever asks for a time between two steps gets what was due until then."""
    here = stage().sim
    here.advance_to(1 * S + 52 * MS)
    assert here.simulation.physics.time_ns == 1 * S + 50 * MS
    assert here.next_due_ns == 1 * S + 100 * MS
    with pytest.raises(ValueError, match="cannot advance"):
        here.advance_to(1 * S)


def test_nothing_is_drawn_while_nobody_looks(stage, monkeypatch):
    """The camera is made with the first subscription to its pictures."""
    made = []
    monkeypatch.setattr("sim.sensors.camera.Camera", lambda *_: made.append(1))
    here = stage("camera/camera_info")
    here.run(2 * S)
    assert made == []
    assert len(here.messages("camera/camera_info")) == 11


@pytest.mark.parametrize("has_egl", [pytest.param(True, marks=pytest.mark.egl), False])
def test_pictures_come_while_somebody_looks(stage, render, monkeypatch, has_egl):
    """10 a second, of the size and form that the message says; without EGL, drawn ray by ray."""
    tried = []

    def refuse(*_):
        tried.append(1)
        raise NoCameraError("EGL cannot be used on this machine")

    here = stage("camera/image_raw")
    if has_egl:
        render(here.sim.physics)
    else:
        monkeypatch.setattr("sim.sensors.camera.Camera", refuse)
    here.run(1 * S + 300 * MS)
    images = here.messages("camera/image_raw")
    assert len(images) == 4
    assert (images[0].width, images[0].height, images[0].encoding) == (320, 240, "rgb8")
    assert len(images[0].data) == 320 * 240 * 3
    assert np.ptp(np.array(images[0].data)) > 50
    assert len(tried) == (not has_egl)


def test_a_robot_may_do_without_its_camera(stage):
    """With `camera=False` there are no such topics."""
    topics = {publisher.topic_name for publisher in stage(camera=False).sim.publishers}
    assert not any("camera" in topic for topic in topics)


def test_lean_leaves_out_what_a_stage_does_not_need(stage):
    """No parameter services and no /rosout, unless asked for; the robot's own are there."""
    lean, full = stage().sim, stage(lean=False).sim
    assert {service.srv_name for service in lean.services} == {
        "motor_power",
        "reset_odometry",
        "reset_simulation",
    }
    assert len(list(full.services)) >= 9


def digest_of(stage, seed: int) -> str:
    """A digest of every message of a drive of 3 s, to the last bit, in the order of arrival."""
    here = stage(*QUIET, world=load_world("dqn_stage4"), seed=seed)
    for step in range(60):
        here.run(1 * S + step * 50 * MS)
        here.command(0.2, 0.9 if step % 20 < 10 else -0.9)
    here.close()  # two stages of one process hear each other
    # As words: between the fields of a serialised message lie bytes that nobody has set.
    return hashlib.sha256(repr(here.received).encode()).hexdigest()


def test_the_same_seed_tells_the_same_story(stage):
    """Every topic, bit for bit; another seed, another story."""
    first = digest_of(stage, 5)
    assert digest_of(stage, 5) == first
    assert digest_of(stage, 6) != first
