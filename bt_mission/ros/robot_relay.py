"""A robot on the stage, sent to viewers at the pace of the wall clock.

Its topics have the pace of its clock, which may run a hundred times as fast: a subscription from
outside would slow the whole stage down. So a stage sends the same with few messages below the
executive's name, and only with a subscription.
"""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import BatteryState, LaserScan
from tf2_msgs.msg import TFMessage

from bt_mission.base.geometry import Pose2D, set_planar
from bt_mission.base.stamps import set_ns
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events import messages

EVERY_S = 0.25
"""Wall time between two messages."""

QOS = QoSProfile(depth=5)
Pose = tuple[float, float, float]


@dataclass(frozen=True)
class RobotSnapshot:
    """A snapshot of a robot.

    Args:
        time_ns: ROS time, ns.
        pose: On the map: m, m, rad.
        lidar: On the robot, m, m, rad.
        ranges: A full turn of rays from the robot's x axis on, m.
        reach: The least and greatest range of the lidar, m.
        charge: The charge of its battery, 0 to 100; None without one.
    """

    time_ns: int
    pose: Pose
    lidar: Pose
    ranges: npt.NDArray[np.float32]
    reach: tuple[float, float]
    charge: float | None
    voltage: float = math.nan


def readings_of(look: RobotSnapshot) -> Iterator[messages.Robot]:
    """Yield the frames, the scan and the battery of a snapshot."""
    yield (
        messages.FrameTransform("map", "base_footprint", *look.pose),
        messages.FrameTransform("base_footprint", "base_scan", *look.lidar),
    )
    step, ranges = math.tau / len(look.ranges), tuple(look.ranges.tolist())
    yield messages.ScanPoints("base_scan", 0.0, step, *look.reach, ranges)
    if look.charge is not None:
        yield messages.BatteryState(look.charge, look.voltage)


class RobotRelay:
    """Publishes ``~/tf``, ``~/scan`` and ``~/battery_state``.

    Args:
        node: That of the executive.
        look: Called when somebody listens and it is time.
    """

    def __init__(self, node: Node, look: Callable[[], RobotSnapshot]) -> None:
        self._look = look
        self._frames = node.create_publisher(TFMessage, "~/tf", QOS)
        self._scan = node.create_publisher(LaserScan, "~/scan", QOS)
        self._battery = node.create_publisher(BatteryState, "~/battery_state", QOS)
        self._since_last = Stopwatch()

    def flush(self) -> None:
        """Publish, if somebody listens and it is time."""
        if self._since_last.elapsed_s < EVERY_S or not self._scan.get_subscription_count():
            return
        self._since_last = Stopwatch()
        look = self._look()
        stamp = set_ns(Time(), look.time_ns)
        self._frames.publish(
            TFMessage(
                transforms=[
                    _transform(stamp, "map", "base_footprint", look.pose),
                    _transform(stamp, "base_footprint", "base_scan", look.lidar),
                ]
            )
        )
        scan = LaserScan(
            angle_increment=math.tau / len(look.ranges),
            range_min=look.reach[0],
            range_max=look.reach[1],
            ranges=array.array("f", look.ranges.tobytes()),
        )
        scan.header.stamp, scan.header.frame_id = stamp, "base_scan"
        self._scan.publish(scan)
        if look.charge is not None:
            self._battery.publish(BatteryState(percentage=look.charge, voltage=look.voltage))


def _transform(stamp: Time, parent: str, child: str, pose: Pose) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, parent
    set_planar(message.transform.translation, message.transform.rotation, Pose2D(*pose))
    return message
