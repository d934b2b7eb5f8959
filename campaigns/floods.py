"""Floods of requests and messages: the responses, the cost, and whether control is on time.

What is flooded runs in a process of its own, `bt-mission servers`, `arbiter` or `serve`, on this
machine's clock, beside a robot that turns as it is told. Whether the servers' control step was on
time is read from the stamps of the velocity commands, which are made in the servers themselves.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import rclpy
from bt_mission_interfaces.action import Turn
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from safety_kills import process
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from benchmarks.measuring import figure, process_usage, table
from bt_mission.core.stamps import to_ns
from bt_mission.core.wall_clock import Stopwatch

PERIOD_S = 0.05
"""Between two control steps, s."""
CALM_S = 10.0
"""The time for which the control step is watched without a flood, s."""
READY_S = 60.0
"""The limit for a process to serve, s."""
START_S = 10.0
"""The time without growth of memory after which a process counts as started, s."""
REST_S = 12.0
"""The time after which servers accept goals again, s."""
WAITS_S = 3.0
"""The time for which a process is watched after a flood, s."""
CLIENT = Path(__file__).with_name("floods_client.py")


class Robot:
    """A base on the spot that turns as told, with a scan that sees nothing; hears its commands.

    :param pauses: how long they are, of the usual ones.
    """

    def __init__(self, pauses: float) -> None:
        self._pauses = pauses
        self.node = Node("robot", enable_rosout=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._yaw = self._angular = 0.0
        self._odometry = self.node.create_publisher(Odometry, "odom", 10)
        self._scan = self.node.create_publisher(LaserScan, "scan", 10)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._take, QoSProfile(depth=1000))
        self.node.create_timer(PERIOD_S, self._publish)
        self.stamps_s: list[float] = []
        """The stamps of the commands that move, in order."""
        self._turn = ActionClient(self.node, Turn, "turn")

    def close(self) -> None:
        """Destroy the node."""
        self._executor.shutdown()
        self.node.destroy_node()

    def spin(self, seconds: float) -> None:
        """Spin for a while."""
        watch = Stopwatch()
        while watch.elapsed_s < seconds:
            self._executor.spin_once(timeout_sec=0.02)

    def rest(self, usual_s: float) -> float:
        """Spin for a pause. Return its seconds."""
        seconds = self._pauses * usual_s
        self.spin(seconds)
        return seconds

    def drive(self) -> None:
        """Have the servers turn the base during all measurements."""
        watch = Stopwatch()
        goal = Turn.Goal(angle=3_600.0, angular_velocity=0.1)
        while watch.elapsed_s < READY_S:
            self.spin(0.2)
            if not self._turn.server_is_ready():
                continue
            future = self._turn.send_goal_async(goal)
            self.spin(0.5)
            if future.done() and future.result().accepted:
                self.spin(1.0)
                return
        raise RuntimeError("the servers accept no goal")

    def call(self, name: str) -> None:
        """Call a service that takes nothing."""
        client = self.node.create_client(Trigger, name)
        client.wait_for_service(READY_S)
        future = client.call_async(Trigger.Request())
        while not future.done():
            self.spin(0.02)
        self.node.destroy_client(client)

    def _take(self, message: Any) -> None:
        self._angular = message.twist.angular.z
        if message.twist.angular.z or message.twist.linear.x:
            self.stamps_s.append(to_ns(message.header.stamp) / 1e9)

    def _publish(self) -> None:
        self._yaw = math.remainder(self._yaw + self._angular * PERIOD_S, math.tau)
        now = self.node.get_clock().now().to_msg()
        odometry = Odometry()
        odometry.header.stamp, odometry.header.frame_id = now, "odom"
        odometry.pose.pose.orientation.z = math.sin(self._yaw / 2)
        odometry.pose.pose.orientation.w = math.cos(self._yaw / 2)
        odometry.twist.twist.angular.z = self._angular
        self._odometry.publish(odometry)
        scan = LaserScan(angle_increment=math.radians(1), range_min=0.1, range_max=3.5)
        scan.header.stamp = now
        scan.ranges = [math.inf] * 360
        self._scan.publish(scan)


@dataclass
class Flooded:
    """The outcome of one flood."""

    sent: int = 0
    answered: int | None = None
    refused: int = 0
    seconds: float = 0.0
    cpu_s: float = 0.0
    grown_mib: float = 0.0
    late_s: list[float] = field(default_factory=list)
    """The delay of each command beyond 50 ms after the one before it."""

    def row(self, name: str) -> tuple[object, ...]:
        """Return the cells of a table."""
        answered = (
            "" if self.answered is None else f"{self.answered:,}, {self.refused:,} of them no"
        )
        figure(f"{name}: CPU", self.cpu_s, "s")
        if self.late_s:
            figure(
                f"{name}: a command is late by", (1000 * delay_s for delay_s in self.late_s), "ms"
            )
        return (
            name,
            f"{self.sent:,} in {self.seconds:.1f} s",
            answered,
            f"{self.cpu_s:.1f}",
            f"{self.grown_mib:.1f}",
            *_late(self.late_s),
        )


def _late(late_s: list[float]) -> tuple[str, str]:
    if not late_s:
        return "", ""
    ordered = sorted(late_s)
    share = ordered[min(len(ordered) - 1, math.floor(0.99 * len(ordered)))]
    return f"{share * 1e3:.0f} ms", f"{ordered[-1] * 1e3:.0f} ms"


def watched(
    robot: Robot, target: subprocess.Popen[bytes], kind: str, name: str, count: int
) -> Flooded:
    """Flood a process from another one, and measure it."""
    cpu_s, resident = process_usage(target.pid)
    first = len(robot.stamps_s)
    client = subprocess.Popen(  # noqa: S603 - starts our own program
        [sys.executable, str(CLIENT), kind, name, str(count)], stdout=subprocess.PIPE
    )
    most = resident
    while client.poll() is None:
        robot.spin(0.1)
        if target.poll() is not None:
            raise RuntimeError(f"{kind}: the process has ended with {target.returncode}")
        most = max(most, process_usage(target.pid)[1])
    robot.rest(WAITS_S)
    assert client.stdout is not None
    result = Flooded(**json.loads(client.stdout.read()))
    cpu_after_s, resident_after = process_usage(target.pid)
    result.cpu_s = cpu_after_s - cpu_s
    result.grown_mib = (max(most, resident_after) - resident) / 2**20
    result.late_s = _lateness(robot.stamps_s[first:])
    return result


def calm(robot: Robot, target: subprocess.Popen[bytes]) -> Flooded:
    """Watch the control step without a flood."""
    cpu_s, resident = process_usage(target.pid)
    first = len(robot.stamps_s)
    seconds = robot.rest(CALM_S)
    cpu_after_s, after = process_usage(target.pid)
    late_s = _lateness(robot.stamps_s[first:])
    grown_mib = (after - resident) / 2**20
    return Flooded(seconds=seconds, cpu_s=cpu_after_s - cpu_s, grown_mib=grown_mib, late_s=late_s)


def settle(robot: Robot, target: subprocess.Popen[bytes]) -> None:
    """Wait until a process has started: until its memory stays constant."""
    before, now = -1, 0
    while before != now:
        robot.rest(START_S)
        before, now = now, process_usage(target.pid)[1] >> 20


def _lateness(stamps_s: list[float]) -> list[float]:
    return [after - before - PERIOD_S for before, after in pairwise(stamps_s)]


KINDS = ("waits", "cancels", "scans", "turns", "stops", "clock", "velocities", "missions")
KINDS += ("breakpoints",)
HEAD = ("flood", "sent", "answered", "CPU, s", "memory, MiB", "99 % late by", "latest by")


def servers(
    robot: Robot, folder: str, count: int, kinds: Collection[str]
) -> Iterator[tuple[object, ...]]:
    """Flood the servers while they turn a robot."""
    with process("servers", "--images", folder, "--wall-clock") as target:
        robot.drive()
        yield calm(robot, target).row("servers: none")
        for kind, name, many in (
            ("waits", "wait", count),
            ("cancels", "move/_action/cancel_goal", count),
            ("scans", "scan", 100 * count),
            ("turns", "turn", count),
            ("stops", "stop", count),
        ):
            if kind not in kinds:
                continue
            result = watched(robot, target, kind, name, many)
            if kind in ("turns", "stops"):
                result.late_s = []  # the driving goal is replaced, or has ended
            yield result.row(f"servers: {kind}")
            robot.call("release")
            if kind != "stops":
                robot.rest(REST_S)
                robot.drive()


def others(
    robot: Robot, folder: str, count: int, kinds: Collection[str]
) -> Iterator[tuple[object, ...]]:
    """Flood the other processes, and servers on simulated time."""
    for options, kind, name, many in (
        (("servers", "--images", folder), "clock", "/clock", 10 * count),
        (("arbiter", "--wall-clock"), "velocities", "cmd_vel_mission", 100 * count),
        (("sim", "--no-camera"), "velocities", "cmd_vel", 100 * count),
        (("serve", "--wall-clock", "--missions", folder), "missions", "execute_mission", count),
        (("serve", "--wall-clock"), "breakpoints", "bt_mission/breakpoint", count),
    ):
        if kind not in kinds:
            continue
        with process(*options) as target:
            settle(robot, target)
            result = watched(robot, target, kind, name, many)
        result.late_s = []
        yield result.row(f"{options[0]}: {kind}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000, help="requests of a flood")
    parser.add_argument("--only", choices=("servers", "others"))
    parser.add_argument("--kinds", choices=KINDS, nargs="+", default=KINDS, help="of floods")
    parser.add_argument("--pauses", type=float, default=1.0, help="of the usual ones, what part")
    arguments = parser.parse_args()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    rclpy.init()
    robot = Robot(arguments.pauses)
    with tempfile.TemporaryDirectory() as folder:
        floods = [
            measure for measure in (servers, others) if arguments.only in (None, measure.__name__)
        ]
        table(
            HEAD,
            (
                row
                for flood in floods
                for row in flood(robot, folder, arguments.count, arguments.kinds)
            ),
        )
    robot.close()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
