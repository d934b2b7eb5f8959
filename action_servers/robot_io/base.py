"""The commands from the pilot to the wheels: one publisher, of the type that the robot takes.

The type of command that the robot subscribes to: pure decisions from the ROS graph.

A TurtleBot3 on Jazzy takes `geometry_msgs/TwistStamped` by default and `geometry_msgs/Twist` with
`enable_stamped_cmd_vel: false`. DDS never delivers one type to a reader of the other, and reports
nothing.

The commands from the servers to the joints of arm and gripper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from bt_mission.base.dds.liveliness import RECORDER
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import text
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import clock_ns, set_ns
from bt_mission.cdr.writer import MessageTemplate
from bt_mission.robots.model import RobotModel

STAMPED = "geometry_msgs/msg/TwistStamped"
PLAIN = "geometry_msgs/msg/Twist"
COMMAND_TYPES = (STAMPED, PLAIN)

Choice: TypeAlias = Literal["auto", "stamped", "plain"]
CHOICES: tuple[Choice, ...] = ("auto", "stamped", "plain")
_CHOSEN = {"stamped": STAMPED, "plain": PLAIN}


class Listeners:
    """The type of command to send, decided once; after that, other types are errors.

    Args:
        topic: Full name of the topic, for the messages.
        choice: "auto" takes the type of the robot's subscription; "stamped" and "plain" are fixed.
    """

    def __init__(self, topic: str, choice: Choice = "auto") -> None:
        self._topic = topic
        self.type: str | None = _CHOSEN.get(choice)
        """Full name of the command's type; None until it is known."""

    def look(self, types: Iterable[str]) -> str | None:
        """Handle the subscriptions' types; return why the robot would not receive commands."""
        offered = sorted(set(types))
        wanted = [name for name in offered if name in COMMAND_TYPES]
        if not offered:
            return f"{self._topic} has no subscriber; is the robot's bringup running?"
        if len(wanted) != len(offered):
            strange = ", ".join(name for name in offered if name not in COMMAND_TYPES)
            return f"{self._topic} must be TwistStamped or Twist, but {strange} is listened for"
        if len(wanted) > 1:
            return (
                f"both {_short(STAMPED)} and {_short(PLAIN)} are listened for on {self._topic}, "
                "so one of the two would not hear; give all of them the same type "
                "(enable_stamped_cmd_vel of the robot's bringup)"
            )
        if self.type is None:
            self.type = wanted[0]
        if self.type != wanted[0]:
            return (
                f"{self._topic} is subscribed as {_short(wanted[0])}, but {_short(self.type)} is "
                f"sent; reset the robot's enable_stamped_cmd_vel, or restart the servers"
            )
        return None


def _short(type_name: str) -> str:
    return type_name.rpartition("/")[2]


WATCH_PERIOD_S = 0.5
"""Seconds between two checks of the subscriptions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandWiring:
    """The topic and form of commands, as parameters.

    `is_watched`: check the subscriptions, and refuse goals that drive without one.
    """

    topic: str = text(
        "topics.cmd_vel", "cmd_vel", "Velocity commands, geometry_msgs/TwistStamped or Twist."
    )
    frame: str = text("frames.base", "base_footprint", "Frame id of stamped velocity commands.")
    type: Choice = text(  # noqa: RUF009 - makes a field, as above
        "cmd_vel_type",
        "stamped",
        "stamped, plain, or auto: what the robot is found to listen for.",
        CHOICES,
    )
    is_watched: bool = False

    @classmethod
    def of_type(cls, choice: Choice) -> CommandWiring:
        """Return the wiring for a type of command; with "auto" it is watched."""
        return cls(type=choice, is_watched=choice == "auto")


class CommandPublisher:
    """Publishes commands to the base, as `geometry_msgs/TwistStamped` or `geometry_msgs/Twist`.

    With the type "auto", it is the type of the robot's subscription. If the wiring is watched,
    goals that drive are refused with the reason without a subscription, and `on_fault` is called
    once.
    """

    def __init__(self, node: Node, wiring: CommandWiring, on_fault: Callable[[str], None]) -> None:
        self._node = node
        self._clock = node.get_clock()
        self._context: Any = node.context
        self._log = log_of(node)
        self._topic = node.resolve_topic_name(wiring.topic)
        self._frame = wiring.frame
        self._on_fault = on_fault
        self._listeners = Listeners(self._topic, wiring.type)
        self._publisher: Publisher | None = None
        self._stamp = Time()
        self._message: MessageTemplate
        self._fault: str | None = None
        self._watched = wiring.is_watched
        self._logged: str | None = None
        if self.type is not None:
            self._open()
        if self._watched:
            # Not at once: discovery takes a moment, and `on_fault` is not set yet.
            self._fault = f"nobody has looked yet who listens on {self._topic}"
            node.create_timer(WATCH_PERIOD_S, self.watch)

    @property
    def fault(self) -> str | None:
        """Why the robot would not receive commands, as of the last check, or None."""
        return self._fault

    @property
    def type(self) -> str | None:
        """Full name of the published type; None until it is known."""
        return self._listeners.type

    def command(self, twist: Twist2D, stamp_ns: int | None = None) -> None:
        """Send a velocity, if there is a publisher.

        `stamp_ns` is the time of its decision, ns of ROS time; None is now.
        """
        publisher = self._publisher
        if publisher is None or not self._context.ok():
            return  # the shutdown of the context has destroyed the publisher
        set_ns(self._stamp, clock_ns(self._clock) if stamp_ns is None else stamp_ns)
        publisher.publish(self._message.packed(twist.linear, twist.lateral, twist.angular))

    def watch(self) -> str | None:
        """Check the subscriptions; return why the robot would not receive commands, or None."""
        if not self._watched:
            return None
        infos = self._node.get_subscriptions_info_by_topic(self._topic)
        self._fault = self._listeners.look(
            info.topic_type for info in infos if info.node_name != RECORDER
        )
        if self._publisher is None and self.type is not None:
            self._open()
        if self._fault != self._logged:
            self._log_fault()
        return self._fault

    def wait_until_stopped(self, timeout_s: float) -> None:
        """Block until every subscriber has acknowledged the last command."""
        if self._publisher is not None:
            self._publisher.wait_for_all_acked(Duration(nanoseconds=round(timeout_s * 1e9)))

    def _open(self) -> None:
        message: Any = TwistStamped() if self.type == STAMPED else Twist()
        twist = message
        if self.type == STAMPED:
            message.header.stamp, message.header.frame_id = self._stamp, self._frame
            twist = message.twist
        parts = [(twist, ("linear.x", "linear.y", "angular.z"))]
        self._message = MessageTemplate(message, self._stamp, parts, serialize_message)
        self._publisher = self._node.create_publisher(type(message), self._topic, 10)
        self._log.info(f"commands go to {self._topic} as {self.type}")

    def _log_fault(self) -> None:
        self._logged = self._fault
        if self._fault is None:
            self._log.info(f"{self._topic} is listened to as {self.type}")
            return
        self._log.error(self._fault)
        self._on_fault(self._fault)


class JointCommander:
    """Publishes positions for joints on `joint_commands`, as topic_based_ros2_control does.

    A robot without such joints has no topic.
    """

    def __init__(self, node: Node, robot: RobotModel) -> None:
        self._clock = node.get_clock()
        self._context = node.context
        self._publisher = (
            node.create_publisher(JointState, "joint_commands", 10) if robot.moved_joints else None
        )

    def send(
        self, names: Sequence[str], positions: Sequence[float], efforts: Sequence[float] = ()
    ) -> None:
        """Send joints to positions, rad or m, with at most these forces, N or N m."""
        if self._publisher is None or not self._context.ok():
            return
        message = JointState(
            name=list(names), position=list(positions), effort=[float(each) for each in efforts]
        )
        message.header.stamp = self._clock.now().to_msg()
        self._publisher.publish(message)
