"""The topics and services of one simulated robot: those of a TurtleBot3 on Jazzy.

Its sensors are separate (`sim.ros.sensor_topics`). Nothing is published without a subscription. All
names begin with the robot's prefix.

Writes readings into ROS messages, which are handed in.

The simulator in AMCL's place: programs for Nav2 wait for it before they send goals.
"""

from __future__ import annotations

import array
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, TypeAlias

from bt_mission_interfaces.msg import Collision as CollisionMessage
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist, TwistStamped
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from nav_msgs.msg import Odometry as OdometryMessage
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from bt_mission.base.geometry import Pose2D, set_planar
from bt_mission.base.goal_rate import MOST_WAITING
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import NS, set_ns
from bt_mission.cdr.decoder import decoder_of
from bt_mission.cdr.picker import Picker
from bt_mission.cdr.writer import MessageTemplate
from sim import frames
from sim.frames import MAP, FramePose
from sim.physics.contacts import Collision
from sim.robot.description import description, fixed_frames
from sim.robot.robot import SimulatedRobot
from sim.ros.schedule import Schedule
from sim.ros.sensor_topics import LATCHED, RELIABLE


def header(message: Any, stamp: Any, frame: str, child: str | None = None) -> Any:
    """Give a message its frames, and a stamp that others may share. Return the message."""
    message.header.stamp, message.header.frame_id = stamp, frame
    if child is not None:
        message.child_frame_id = child
    return message


def transform(message: Any, frame: FramePose, stamp: Any) -> Any:
    """Fill a TransformStamped with a fixed frame, and return it."""
    header(message, stamp, frame.parent, frame.child)
    t, r = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = frame.translation
    r.x, r.y, r.z, r.w = frame.rotation
    return message


def with_collision(message: Any, event: Collision) -> Any:
    """Fill a Collision, with its own time as the stamp, and return it."""
    set_ns(message.header.stamp, event.time_ns)
    message.header.frame_id = MAP
    message.obstacle, message.force = event.obstacle, event.force
    message.point.x, message.point.y, message.point.z = event.point
    return message


def planar(x: float, y: float, yaw: float) -> tuple[float, float, float, float]:
    """Return x and y of a place, and z and w of its quaternion."""
    return x, y, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


COMMANDS = QoSProfile(depth=1)  # of several waiting ones, only the newest counts
REQUESTS = QoSProfile(depth=MOST_WAITING)
TRANSFORMS = QoSProfile(depth=100)  # what tf2's listeners and broadcasters use

# The numbers that change from one message to the next.
PLANAR = ("position.x", "position.y", "orientation.z", "orientation.w")
PLANAR_MOTION = (
    *(f"pose.pose.{name}" for name in PLANAR),
    "twist.twist.linear.x",
    "twist.twist.angular.z",
)
PLANAR_TRANSFORM = tuple(
    f"transform.{name}" for name in ("translation.x", "translation.y", "rotation.z", "rotation.w")
)
TRANSFORM = tuple(
    f"transform.{part}.{axis}"
    for part, axes in (("translation", "xyz"), ("rotation", "xyzw"))
    for axis in axes
)
CommandType: TypeAlias = Literal["stamped", "plain"]
COMMAND_TYPES: Mapping[CommandType, str] = {
    "stamped": "geometry_msgs/msg/TwistStamped",
    "plain": "geometry_msgs/msg/Twist",
}
"""Types of `cmd_vel` that a robot takes: the first is that of a TurtleBot3 on Jazzy, the second
that with `enable_stamped_cmd_vel: false`. Never both: in one participant of Fast DDS a topic has
one type."""

_COMMAND: Mapping[CommandType, tuple[str, ...]] = {
    "stamped": (
        "header.stamp.sec",
        "header.stamp.nanosec",
        "twist.linear.x",
        "twist.angular.z",
    ),
    "plain": ("linear.x", "angular.z"),
}


class RobotPublishers:
    """The topics and services of one robot, apart from its sensors.

    Args:
        node: The simulator's node.
        schedule: The schedule of its messages.
        stamp: The stamp of all messages, shared.
        robot: The robot of the topics.
        command_type: Of `cmd_vel`.
        localises: Whether `tf` has the place of `odom` on the map.
    """

    def __init__(
        self,
        node: Node,
        schedule: Schedule,
        stamp: Any,
        robot: SimulatedRobot,
        *,
        command_type: CommandType = "stamped",
        localises: bool = True,
    ) -> None:
        self._node = node
        self._localises = localises
        self._schedule = schedule
        self._stamp = stamp
        self._robot = robot
        self._make_tree()
        self._make_collisions()
        self._make_base()
        self._make_motors()
        fields = _COMMAND[command_type]
        if robot.robot.drive.slide_velocity:
            fields = (*fields[:-1], fields[-2].removesuffix("x") + "y", fields[-1])
        self._slides = len(fields) > len(_COMMAND[command_type])
        self._commands = Picker(decoder_of(COMMAND_TYPES[command_type]), fields)
        node.create_subscription(
            TwistStamped if command_type == "stamped" else Twist,
            self._name("cmd_vel"),
            self._on_command,
            COMMANDS,
            raw=True,
        )
        if robot.servos is not None:
            node.create_subscription(
                JointState, self._name("joint_commands"), self._on_joint_command, RELIABLE
            )
        name = self._name("reset_odometry")
        node.create_service(Trigger, name, self._on_reset_odometry, qos_profile=REQUESTS)

    def restart(self) -> None:
        """Publish the latched topics again, after the robot was put back to its start."""
        self._publish_motors()

    def _name(self, topic: str) -> str:
        return self._robot.prefix + topic

    def _publisher(self, kind: Any, topic: str, qos: QoSProfile = RELIABLE) -> Publisher:
        return self._node.create_publisher(kind, self._name(topic), qos)

    def _packed(
        self, message: Any, *parts: tuple[Any, tuple[str, ...]], unused: int = 0
    ) -> MessageTemplate:
        return MessageTemplate(message, self._stamp, parts, serialize_message, unused)

    # ---- commands and services -----------------------------------------------------------

    def _on_command(self, data: bytes) -> None:
        try:
            numbers: Sequence[Any] = self._commands.pick(data).numbers
            lateral = 0.0
            if self._slides:
                *stamp, linear, lateral, angular = numbers
                numbers = *stamp, linear, angular
            *stamp, linear, angular = numbers
            stamp_ns = stamp[0] * NS + stamp[1] if stamp else 0
            if stamp_ns:
                stamp_ns += self._schedule.set_back_ns
            age_s = self._robot.command(linear, angular, stamp_ns, lateral)
        except ValueError as error:
            log_of(self._node).warning(f"cmd_vel refused: {error}", throttle_duration_sec=5.0)
            return
        is_old = age_s > 0.0 and age_s >= self._robot.command_timeout_s
        if is_old and (linear or angular or lateral):
            limit_s = self._robot.command_timeout_s
            why = f"{age_s:.2f} s old, more than the command timeout of {limit_s:g} s"
            log_of(self._node).warning(f"cmd_vel ignored: {why}", throttle_duration_sec=5.0)

    def _on_joint_command(self, command: Any) -> None:
        assert self._robot.servos is not None
        try:
            self._robot.servos.command(command.name, command.position, command.effort)
        except ValueError as error:
            log_of(self._node).warning(
                f"joint_commands refused: {error}", throttle_duration_sec=5.0
            )

    def _on_motor_power(self, request: Any, response: Any) -> Any:
        response.success = self._robot.power_motors(on=request.data)
        state = "on" if self._robot.motors_on else "off"
        response.message = f"motors are {state}" + ("" if response.success else ": no charge left")
        self._publish_motors()
        return response

    def _on_reset_odometry(self, _: Any, response: Any) -> Any:
        self._robot.reset_odometry()
        response.success, response.message = True, "odometry is (0, 0, 0) here"
        return response

    # ---- state ---------------------------------------------------------------------------

    def _make_tree(self) -> None:
        tree = TFMessage()
        tree.transforms = [
            transform(TransformStamped(), frame, self._stamp)
            for frame in fixed_frames(self._robot.robot)
        ]
        publisher = self._publisher(TFMessage, "tf_static", LATCHED)
        self._schedule.once(lambda _: publisher.publish(tree))
        links = self._robot.links
        drawing = description(self._robot.robot, () if links is None else links.all)
        drawn = self._publisher(String, "robot_description", LATCHED)
        self._schedule.once(lambda _: drawn.publish(String(data=drawing)))

    def _make_collisions(self) -> None:
        publisher = self._publisher(CollisionMessage, "collisions")
        who = f"{self._robot.name}: " if self._robot.name else ""

        def publish(_: int) -> None:
            for collision in self._robot.take_collisions():
                log_of(self._node).info(f"{who}collision with {collision.obstacle}")
                on_clock = replace(collision, time_ns=self._schedule.clock_ns(collision.time_ns))
                publisher.publish(with_collision(CollisionMessage(), on_clock))

        self._schedule.every(self._robot.robot.odometry_rate, "odometry_rate", publish)

    def _make_base(self) -> None:
        """Publish wheels, odometry, moving frames and true pose, all of one instant."""
        robot, joints = self._robot, self._robot.joints
        turned = header(JointState(name=list(joints)), self._stamp, "")
        still = array.array("d", (0.0,) * len(joints))
        turned.position, turned.velocity = still, still
        reckoned = header(OdometryMessage(), self._stamp, frames.ODOM, frames.BASE_FOOTPRINT)
        true = header(OdometryMessage(), self._stamp, frames.MAP, frames.BASE_FOOTPRINT)
        base = header(TransformStamped(), self._stamp, frames.ODOM, frames.BASE_FOOTPRINT)
        odom = header(TransformStamped(), self._stamp, frames.MAP, frames.ODOM)
        sent = [odom, base] if self._localises else [base]
        links = robot.links
        moved = [
            transform(TransformStamped(), frame, self._stamp)
            for frame in (() if links is None else links.frames)
        ]
        moving = self._packed(
            TFMessage(transforms=[*sent, *moved]),
            *((frame, PLANAR_TRANSFORM) for frame in sent),
            *((frame, TRANSFORM) for frame in moved),
        )
        if robot.servos is not None:
            turned.effort = still
        with_effort = ("position", "velocity", "effort")
        wheels = (
            self._packed(turned, (turned, with_effort[:2]), unused=4)
            if robot.servos is None
            else self._packed(turned, (turned, with_effort))
        )
        slides = robot.robot.drive.slide_velocity > 0
        sliding = (*PLANAR_MOTION[:-1], "twist.twist.linear.y", PLANAR_MOTION[-1])
        odometry = self._packed(reckoned, (reckoned, sliding if slides else PLANAR_MOTION))
        truth = self._packed(true, (true, PLANAR_MOTION))
        wheels_out = self._publisher(JointState, "joint_states")
        odometry_out = self._publisher(OdometryMessage, "odom")
        moving_out = self._publisher(TFMessage, "tf", TRANSFORMS)
        truth_out = self._publisher(OdometryMessage, "ground_truth/odom")
        localises = self._localises

        def publish(_: int) -> None:
            reading = robot.read_odometry()
            here = (reading.x, reading.y, reading.yaw)
            faults = robot.faults.now
            if wheels_out.get_subscription_count() and not faults["joints"].dead:
                wheels_out.publish(wheels.packed(*robot.joint_numbers))
            if odometry_out.get_subscription_count() and not faults["odometry"].dead:
                motion: tuple[float, ...] = reading.linear, reading.angular
                if slides:
                    motion = reading.linear, reading.lateral, reading.angular
                odometry_out.publish(odometry.packed(*planar(*here), *motion))
            to_odom = robot.localization.map_to_odom(robot.pose, here, robot.physics.time_ns)
            if moving_out.get_subscription_count() and not faults["odometry"].dead:
                places: tuple[float, ...] = planar(*here)
                if localises:
                    places = (*planar(*to_odom), *places)
                if links is not None:
                    places = (*places, *links.places())
                moving_out.publish(moving.packed(*places))
            if truth_out.get_subscription_count():
                place = planar(*robot.pose)
                truth_out.publish(truth.packed(*place, *robot.velocity))

        self._schedule.every(robot.robot.odometry_rate, "odometry_rate", publish)

    def _make_motors(self) -> None:
        """Publish whether they have power: latched, at the start and at every change."""
        publisher = self._publisher(Bool, "motors_on", LATCHED)
        published: list[bool] = []

        def publish_changed(_: int = 0) -> None:
            if published != [self._robot.motors_on]:
                published[:] = [self._robot.motors_on]
                publisher.publish(Bool(data=published[0]))

        self._publish_motors = publish_changed
        # Published with the odometry, since an empty battery switches them off, too.
        self._schedule.every(self._robot.robot.odometry_rate, "odometry_rate", publish_changed)
        name = self._name("motor_power")
        self._node.create_service(SetBool, name, self._on_motor_power, qos_profile=REQUESTS)


RATE_HZ = 2.0


def localise(node: Node, schedule: Schedule, stamp: Any, robot: SimulatedRobot) -> None:
    """Publish a robot's pose by its localization as `amcl_pose`; its node's state is "active"."""
    message = header(PoseWithCovarianceStamped(), stamp, frames.MAP)
    place = message.pose.pose
    publisher = node.create_publisher(type(message), f"{robot.prefix}amcl_pose", LATCHED)

    def publish(_: int) -> None:
        reading = robot.read_odometry()
        believed = robot.localization.believed(robot.pose, (reading.x, reading.y, reading.yaw))
        set_planar(place.position, place.orientation, Pose2D(*believed))
        publisher.publish(message)

    def answer(_request: Any, response: Any) -> Any:
        response.current_state.id = State.PRIMARY_STATE_ACTIVE
        response.current_state.label = "active"
        return response

    schedule.every(RATE_HZ, "amcl_pose", publish)
    name = f"{robot.prefix}amcl/get_state"
    node.create_service(GetState, name, answer, qos_profile=REQUESTS)
