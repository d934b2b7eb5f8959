"""The subscriptions of the servers: a few topics, each translated only when it is read.

Messages are kept serialized: most are never read. Those that every control step reads are decoded
by `bt_mission.cdr`: to unpack an odometry message with rclpy costs ten times as much as to
receive it.

The poses of frames on the map, from the transforms of ROS.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from sensor_msgs.msg import Image as ImageMessage
from sensor_msgs.msg import JointState, LaserScan, Range
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from action_servers.core.maneuver import Guard, Hazard, Image, Observation, Refusal, Scan
from action_servers.robot_io.messages import (
    ScanMerger,
    grid_of,
    image_of,
    joints_of,
    odometry_of,
    odometry_picker,
    planar_pose,
    scan_of,
    speed_limit_of,
    transform_of,
)
from bt_mission.base.geometry import Pose2D, composed
from bt_mission.base.parameters import text
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import NS, clock_ns
from bt_mission.cdr.decoder import DecodingError, decoder_of
from bt_mission.cdr.picker import Picker, Texts
from bt_mission.robots.model import RobotModel

KEPT = 100
"""The number of kept messages of moving frames: one or two seconds of a TurtleBot3's."""

_LEAST_UPRIGHT = 0.99
"""Cosine of the tilt up to which a frame counts as level, 8 degrees."""

_TRANSFORMS = "tf2_msgs/msg/TFMessage"


class Frames:
    """Finds a frame's pose on the map, as of now, from messages of `tf` and `tf_static`.

    Messages are kept as they arrive, and decoded only for a request.
    """

    def __init__(self, map_frame: str) -> None:
        self._map_frame = map_frame
        self.fixed: deque[bytes] = deque(maxlen=KEPT)
        """Serialized messages of `tf_static`."""
        self.moving: deque[bytes] = deque(maxlen=KEPT)
        """Serialized messages of `tf`."""

    def on_map(self, frame: str) -> Pose2D | Refusal:
        """Return the place of a frame on the map, or why it is not known."""
        links = self._links()
        pose, at = Pose2D(0.0, 0.0, 0.0), frame
        for _ in range(len(links) + 1):
            if at == self._map_frame:
                return pose
            if at not in links:
                break
            parent, transform = links[at]
            placed = transform_of(transform)
            if placed is None:
                return Refusal(f"the transform from '{parent}' to '{at}' holds no finite numbers")
            if _upright(transform.rotation) < _LEAST_UPRIGHT:
                return Refusal(f"the frame '{frame}' is tilted, at the transform to '{at}'")
            pose, at = composed(placed, pose), parent
        known = ", ".join(sorted({self._map_frame, *links})) or "none"
        return Refusal(
            f"the frame '{frame}' has no transform to '{self._map_frame}' (known frames: {known})"
        )

    def _links(self) -> dict[str, tuple[str, Any]]:
        """Return parent and transform of each frame, the newest of each."""
        return {
            stamped.child_frame_id: (stamped.header.frame_id, stamped.transform)
            for data in (*self.fixed, *self.moving)
            for stamped in transforms_of(data)
        }


class PlaceOnMap:
    """The pose of one frame on the map, from messages that contain it directly."""

    def __init__(self, map_frame: str) -> None:
        self._map_frame = map_frame
        self._frame = ""
        self._picker = Picker(decoder_of(_TRANSFORMS), self._newest)

    def place(self, data: bytes, frame: str) -> Pose2D | None:
        """Return the frame's pose in a serialized message of `tf`.

        None if the message lacks it, is of another type, or contains numbers that are not finite.
        """
        if frame != self._frame:
            self._frame = frame
            self._picker = Picker(decoder_of(_TRANSFORMS), self._newest)
        try:
            numbers = self._picker.pick(data).numbers
        except DecodingError:
            return None
        return planar_pose(*numbers) if numbers else None

    def _newest(self, texts: Texts) -> list[str]:
        """Return the paths of the last transform from the map to the frame, if there is one."""
        paths: list[str] = []
        for path, words in texts.items():
            transform = path.removesuffix(".child_frame_id")
            if transform == path or words != self._frame:
                continue
            if texts[f"{transform}.header.frame_id"] == self._map_frame:
                paths = [
                    *(f"{transform}.transform.translation.{axis}" for axis in "xy"),
                    *(f"{transform}.transform.rotation.{axis}" for axis in "xyzw"),
                ]
        return paths


def transforms_of(data: bytes) -> list[Any]:
    """Return the transforms of a serialized message; none where it is of another type."""
    try:
        return list(decoder_of(_TRANSFORMS).decode(data).transforms)
    except DecodingError:
        return []


def _upright(rotation: Any) -> float:
    """Return the cosine of the angle between a frame's z axis and its parent's."""
    return float(1.0 - 2.0 * (rotation.x**2 + rotation.y**2))


T = TypeVar("T")

# Best effort matches every publisher, also drivers that send sensor data best effort, and of a
# stream only the newest message is of use.
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TRANSFORMS = QoSProfile(depth=100)
FIXED_TRANSFORMS = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)

LARGEST_STATE = 1 << 16
"""Bytes of an odometry message or of transforms. A hundred transforms are kept; those of a
TurtleBot3 have 500 bytes.
"""

LARGEST_SCAN = 1 << 19
LARGEST_MAP = 1 << 26
"""Bytes: 400 m by 400 m in cells of 0.05 m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorWiring:
    """Which topics are listened to, relative to the namespace unless they begin with a slash."""

    scan: str = text("topics.scan", "scan", "The lidar, sensor_msgs/LaserScan.")
    odom: str = text("topics.odom", "odom", "Odometry, nav_msgs/Odometry.")
    tf: str = text(
        "topics.tf", "tf", "Transforms; the one from the map to the odometry frame is read."
    )
    tf_static: str = text(
        "topics.tf_static", "tf_static", "Fixed transforms, for goals in frames of the robot."
    )
    joints: str = text(
        "topics.joints", "joint_states", "Joints of arm and gripper, sensor_msgs/JointState."
    )
    speed_limit: str = text(
        "topics.speed_limit", "speed_limit", "The highest speed, nav2_msgs/SpeedLimit."
    )
    map: str = text("topics.map", "map", "The map, nav_msgs/OccupancyGrid.")
    camera: str = text("topics.camera", "camera/image_raw", "Pictures, sensor_msgs/Image.")
    map_frame: str = text("frames.map", "map", "Frame of the map, in transforms.")


class Latest(Generic[T]):
    """The newest message of a topic, translated at its first use."""

    def __init__(
        self, unpack: Callable[[bytes], Any], translate: Callable[[Any], T | None]
    ) -> None:
        self._unpack = unpack
        self._translate = translate
        self._data: bytes | None = None
        self._value: T | None = None

    def take(self, data: bytes) -> None:
        """Keep a serialized message."""
        self._data = data

    def clear(self) -> None:
        """Forget everything."""
        self._data = self._value = None

    def value(self) -> T | None:
        """Return the newest message, translated; the same object until there is a newer one.

        A message without content, which translates to None, is skipped, and so is one of another
        type. Raises ValueError for a message that cannot be translated.
        """
        if self._data is not None:
            data, self._data = self._data, None
            try:
                message = self._unpack(data)
            except Exception:  # noqa: BLE001 - bytes of another type fail in many ways
                return self._value
            former, self._value = self._value, None
            new = self._translate(message)
            self._value = former if new is None else new
        return self._value


class CameraStream:
    """The camera's images, while a maneuver needs them: a simulator renders only then."""

    def __init__(self, node: Node, topic: str) -> None:
        self.topic = node.resolve_topic_name(topic)
        """Full name of the topic."""
        self._node = node
        self._latest = Latest(partial(deserialize_message, message_type=ImageMessage), image_of)
        self._subscription: Subscription | None = None
        self.is_on = False
        """Whether a maneuver needs images."""
        self._users: set[CameraUser] = set()

    @property
    def is_sent(self) -> bool:
        """Whether a node publishes images."""
        return self._node.count_publishers(self.topic) > 0

    def user(self) -> CameraUser:
        """Return a separate switch: images arrive until all switches are off."""
        return CameraUser(self)

    def turn_on(self, user: CameraUser) -> None:
        """Listen to the camera, if not yet."""
        self._users.add(user)
        self.is_on = True
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                ImageMessage, self.topic, self._latest.take, NEWEST, raw=True
            )

    def turn_off(self, user: CameraUser) -> None:
        """Listen no more, if nobody else does, and forget the last picture."""
        self._users.discard(user)
        if self._subscription is not None and not self._users:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
            self.is_on = False
            self._latest.clear()

    def value(self) -> Image | None:
        """Return the newest picture since the camera is on."""
        return self._latest.value()


class CameraUser:
    """The switch of one maneuver; both may be called in any state."""

    def __init__(self, stream: CameraStream) -> None:
        self._stream = stream

    def on(self) -> None:
        """Have pictures sent."""
        self._stream.turn_on(self)

    def off(self) -> None:
        """Need no more pictures."""
        self._stream.turn_off(self)


_MISSED = 3.0
"""Periods of a bumper or a cliff sensor after which it is silent, if these are long."""


@dataclass(slots=True)
class HazardTopic:
    """A topic of which each message says whether a hazard is present."""

    type: Any
    qos: QoSProfile
    latest: Latest[bool]
    hazard: Hazard
    patience_s: float
    arrived_s: float | None = None

    def guard(self, topic: str) -> Guard:
        """Return what is known of its silence."""
        return Guard(topic, self.arrived_s, self.patience_s)


def _bumpers(robot: RobotModel) -> dict[str, HazardTopic]:
    unpack = partial(deserialize_message, message_type=Bool)
    return {
        f"bumper_{name}": HazardTopic(
            Bool,
            LATCHED,
            Latest(unpack, lambda message: bool(message.data)),
            Hazard(bumper.bearing, f"the bumper {name} is pressed"),
            _MISSED / bumper.rate,
        )
        for name, bumper in robot.bumpers.items()
    }


def _cliffs(robot: RobotModel) -> dict[str, HazardTopic]:
    unpack = decoder_of("sensor_msgs/msg/Range").decode
    return {
        f"range_{name}": HazardTopic(
            Range,
            NEWEST,
            # A range that is NaN shows no floor either.
            Latest(unpack, lambda message: not message.range <= message.max_range),
            Hazard(sensor.bearing, f"the cliff sensor {name} sees no floor"),
            _MISSED / sensor.rate,
        )
        for name, sensor in robot.range_sensors.items()
        if sensor.kind == "cliff"
    }


class SensorSubscriptions:
    """The subscriptions of a node, and the observation of the robot from them.

    The limits of a scan are the narrower ones of message and robot: the driver of the LDS-02
    reports 0 to 100 m. The scans of several lidars are merged. `listen_to_map` is False for the
    mapper itself.
    """

    def __init__(
        self, node: Node, wiring: SensorWiring, robot: RobotModel, *, listen_to_map: bool = True
    ) -> None:
        self._node = node
        self._clock = node.get_clock()
        self._log: Any = log_of(node)
        lidars = robot.all_lidars
        self._scans = {
            topic: Latest(
                decoder_of("sensor_msgs/msg/LaserScan").decode, partial(scan_of, lidar=lidar)
            )
            for topic, lidar in lidars.items()
        }
        self._scan = self._scans["scan"]
        self._hazards = {**_bumpers(robot), **_cliffs(robot)}
        self._merger = ScanMerger(tuple(lidars.values())) if len(lidars) > 1 else None
        self._odometry = Latest(odometry_picker().pick, odometry_of)
        self._joints = (
            Latest(decoder_of("sensor_msgs/msg/JointState").decode, joints_of)
            if robot.moved_joints
            else None
        )
        self._speed_limit = Latest(
            partial(deserialize_message, message_type=SpeedLimit),
            partial(speed_limit_of, fastest=robot.max_linear_velocity),
        )
        self._highest_speed = math.inf
        self._grid = Latest(partial(deserialize_message, message_type=OccupancyGrid), grid_of)
        self._newest_read: bytes | None = None
        """The newest of the transforms that have been looked through."""
        self._map_to_odom: Pose2D | None = None
        self._map_users = 0
        self._places = PlaceOnMap(wiring.map_frame)
        self._frames = Frames(wiring.map_frame)
        self.camera = CameraStream(node, wiring.camera)
        listen = partial(self._listen, largest=LARGEST_STATE)
        for topic, scan in self._scans.items():
            name = wiring.scan + topic.removeprefix("scan")
            self._listen(LaserScan, name, scan.take, NEWEST, largest=LARGEST_SCAN)
        for topic, hazard in self._hazards.items():
            listen(hazard.type, topic, partial(self._take_hazard, hazard), hazard.qos)
        if self._joints is not None:
            listen(JointState, wiring.joints, self._joints.take, NEWEST)
        listen(OdometryMessage, wiring.odom, self._odometry.take, NEWEST)
        listen(TFMessage, wiring.tf, self._frames.moving.append, TRANSFORMS)
        if listen_to_map:
            listen(SpeedLimit, wiring.speed_limit, self._take_speed_limit, RELIABLE)
            listen(TFMessage, wiring.tf_static, self._frames.fixed.append, FIXED_TRANSFORMS)
            self._listen(OccupancyGrid, wiring.map, self._grid.take, LATCHED, largest=LARGEST_MAP)

    def _take_speed_limit(self, data: bytes) -> None:
        # They are rare: translated when they come, none costs a control step anything.
        self._speed_limit.take(data)
        limit = self._speed_limit.value()
        self._highest_speed = math.inf if limit is None else limit

    def _take_hazard(self, hazard: HazardTopic, data: bytes) -> None:
        hazard.latest.take(data)
        hazard.arrived_s = clock_ns(self._clock) / NS

    def _listen(
        self,
        message_type: type,
        topic: str,
        take: Callable[[bytes], None],
        qos: QoSProfile,
        *,
        largest: int,
    ) -> None:
        """Subscribe to messages of at most so many bytes as given."""

        def take_some(data: bytes) -> None:
            if len(data) <= largest:
                take(data)
            else:
                why = f"a message of {len(data):,} bytes; {largest:,} are the limit"
                self._log.warning(f"{topic}: passed over {why}", throttle_duration_sec=5.0)

        self._node.create_subscription(message_type, topic, take_some, qos, raw=True)

    @contextmanager
    def localization(self) -> Iterator[None]:
        """Meanwhile, observations hold map and pose on the map."""
        self._map_users += 1
        try:
            yield
        finally:
            self._map_users -= 1

    def observe(self, *, on_map: bool = False) -> Observation:
        """Return the present observation; `on_map` adds the map and the pose on it."""
        odometry = self._odometry.value()
        on_map = on_map or self._map_users > 0
        return Observation(
            time_s=clock_ns(self._clock) / NS,
            odom=odometry.pose if odometry else None,
            odom_stamp_s=odometry.stamp_s if odometry else 0.0,
            velocity=odometry.velocity if odometry else None,
            scan=self._scan.value() if self._merger is None else self._merged_scan(),
            map_pose=self._pose_on_map() if on_map else None,
            grid=self._grid.value() if on_map else None,
            image=self.camera.value() if self.camera.is_on else None,
            frame_on_map=self._frames.on_map if on_map else None,
            hazards=self._present_hazards() if self._hazards else (),
            guards=self._guards() if self._hazards else (),
            joints=None if self._joints is None else self._joints.value(),
            speed_limit=self._highest_speed,
        )

    def _guards(self) -> tuple[Guard, ...]:
        return tuple(each.guard(topic) for topic, each in self._hazards.items())

    def _present_hazards(self) -> tuple[Hazard, ...]:
        hazards = self._hazards.values()
        return tuple(each.hazard for each in hazards if each.latest.value())

    def _merged_scan(self) -> Scan | None:
        assert self._merger is not None
        return self._merger.merged([scan.value() for scan in self._scans.values()])

    def _pose_on_map(self) -> Pose2D | None:
        odometry = self._odometry.value()
        if odometry is None:
            return None
        # The newest transform of the odometry frame counts; other transforms are in between.
        transforms = self._frames.moving
        for data in reversed(transforms):
            if data is self._newest_read:
                break
            place = self._places.place(data, odometry.frame)
            if place is not None:
                self._map_to_odom = place
                break
        if transforms:
            self._newest_read = transforms[-1]
        return self._map_to_odom and composed(self._map_to_odom, odometry.pose)
