"""Facts about what the servers hear of the robot."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Image, LaserScan
from tf2_msgs.msg import TFMessage

from action_servers.core.maneuver import Refusal
from action_servers.robot_io.messages import image_of, scan_of
from action_servers.robot_io.sensors import LARGEST_STATE, Latest
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.geometry import Pose2D
from bt_mission.cdr.decoder import decoder_of


def transform(parent: str, child: str, x: float) -> TransformStamped:
    """A shift along x."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


@pytest.fixture
def sensors(bench: Any) -> Any:
    """The sensors of the servers, which have heard of the robot."""
    return bench.servers._sensors


def test_nothing_is_known_of_a_silent_robot(silent_bench):
    """All fields are None, apart from the time."""
    now = silent_bench.servers._sensors.observe(on_map=True)
    assert now.time_s == pytest.approx(10.1)
    known = (now.odom, now.velocity, now.scan, now.map_pose, now.image)
    assert known == (None,) * 5


def test_the_newest_of_each_topic_is_known(sensors):
    """Stamped with the instant at which it was sent."""
    now = sensors.observe(on_map=True)
    assert now.time_s == now.odom_stamp_s
    assert now.odom == Pose2D(0.0, 0.0, 0.0)
    assert now.scan is not None
    assert now.map_pose == Pose2D(0.0, 0.0, 0.0)
    assert now.grid is not None
    assert now.grid.cells.shape == (120, 120)


def test_the_same_object_until_there_is_a_newer_message(bench, sensors):
    """So that a maneuver can tell whether a scan is new."""
    first = sensors.observe(on_map=True)
    again = sensors.observe(on_map=True)
    assert first.scan is again.scan
    assert first.grid is again.grid
    bench.steps(1)
    assert sensors.observe().scan is not first.scan


def test_the_map_is_left_out_unless_it_is_wanted(sensors):
    """Transforms cost as much as odometry, and only navigation needs them."""
    now = sensors.observe()
    assert (now.map_pose, now.grid) == (None, None)
    with sensors.localization():
        assert sensors.observe().map_pose is not None
    assert sensors.observe().map_pose is None


def test_the_pose_on_the_map_is_that_of_odometry_moved(sensors):
    """The newest transform from the map to the odometry frame counts, in whatever message."""
    take = sensors._frames.moving.append
    for transforms in (
        [transform("map", "odom", 1.0)],
        [transform("odom", "base_footprint", 9.0), transform("map", "odom", 2.0)],
        [transform("odom", "base_footprint", 9.0)],
        [transform("world", "odom", 8.0), transform("map", "somewhere", 7.0)],
    ):
        take(serialize_message(TFMessage(transforms=transforms)))
    assert sensors.observe(on_map=True).map_pose == Pose2D(2.0, 0.0, 0.0)
    # It stays known when only others come.
    take(serialize_message(TFMessage(transforms=[transform("odom", "base_footprint", 9.0)])))
    assert sensors.observe(on_map=True).map_pose == Pose2D(2.0, 0.0, 0.0)


def test_the_camera_is_listened_to_only_while_it_is_on(bench, sensors):
    """A simulator renders only then; what was seen before is forgotten."""
    camera = sensors.camera.user()
    images = bench.robot.camera
    assert images.get_subscription_count() == 0
    camera.on()
    camera.on()
    bench.steps(2)
    assert images.get_subscription_count() == 1
    assert sensors.observe().image is not None
    camera.off()
    camera.off()
    bench.steps(1)
    assert images.get_subscription_count() == 0
    assert sensors.observe().image is None


def test_a_message_is_translated_when_it_is_looked_at():
    """And only once."""
    translated = []

    def translate(message):
        translated.append(message)
        return scan_of(message)

    latest = Latest(decoder_of("sensor_msgs/msg/LaserScan").decode, translate)
    assert latest.value() is None
    for ray in (1.0, 2.0, 3.0):
        latest.take(serialize_message(LaserScan(angle_increment=1.0, range_max=5.0, ranges=[ray])))
    assert translated == []
    value: Any = latest.value()
    assert value.ranges.tolist() == [3.0]
    assert latest.value() is value
    assert len(translated) == 1


def test_a_message_that_cannot_be_translated_raises_once():
    """Afterwards nothing is known, until the next one."""
    latest = Latest(partial(deserialize_message, message_type=Image), image_of)
    latest.take(serialize_message(Image(encoding="jpeg")))
    with pytest.raises(ValueError, match="image encoding"):
        latest.value()
    assert latest.value() is None


def test_a_map_of_the_wrong_length_is_passed_over(sensors):
    """Whoever has sent it; the next one counts again."""
    sensors._grid.take(b"\0\1\0\0\5")
    assert sensors.observe(on_map=True).grid is None


def test_a_robot_in_a_namespace(tmp_path, waffle, context):
    """All names are relative."""
    node = ServersNode(
        waffle,
        ServerOptions(image_folder=tmp_path, lean=True, context=context, namespace="robot_7"),
    )
    topics = {subscription.topic_name for subscription in node.subscriptions}
    names = ("scan", "odom", "tf", "tf_static", "map", "motors_on", "speed_limit")
    assert topics == {f"/robot_7/{name}" for name in names}
    assert node.count_publishers("/robot_7/cmd_vel") == 1
    node.destroy_node()


GARBAGE = (b"", b"\x00", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + b"\xff" * 400)


@pytest.mark.parametrize(
    ("topic", "kind"),
    [("scan", LaserScan), ("odom", Odometry), ("tf", TFMessage), ("map", OccupancyGrid)],
)
def test_bytes_of_another_type_are_passed_over(bench, topic, kind, sensors):
    """Another participant may send anything; what was known before stays."""
    before = sensors.observe(on_map=True)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = bench.clients[0].create_publisher(kind, topic, latched)
    for data in GARBAGE:
        publisher.publish(data)
        bench.clock.run_until_quiet()
        now = sensors.observe(on_map=True)
        assert (now.odom, now.map_pose) == (before.odom, before.map_pose)
        assert (now.scan, now.grid) == (before.scan, before.grid)
        assert isinstance(now.frame_on_map("camera"), Refusal)


def test_a_message_beyond_the_limit_is_not_kept(bench, sensors):
    """Two hundred messages of transforms are, of any sender."""
    publisher = bench.clients[0].create_publisher(TFMessage, "tf", 100)
    for name, size in (("small", 100), ("large", LARGEST_STATE)):
        moved = transform("map", name, 1.0)
        filler = transform("map", "x" * size, 0.0)
        publisher.publish(TFMessage(transforms=[moved, filler]))
    bench.clock.run_until_quiet()
    find = sensors.observe(on_map=True).frame_on_map
    assert find("small") == Pose2D(1.0, 0.0, 0.0)
    assert isinstance(find("large"), Refusal)
