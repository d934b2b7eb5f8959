"""Floods of requests and messages: what is answered, what it costs, and whether control is on time.

What is flooded runs in a process of its own, `bt-mission servers`, `arbiter` or `serve`, on this
machine's clock, beside a robot that turns as it is told. Whether the servers' control step was on
time is read from the stamps of the velocity commands, which are made in the servers themselves.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from bt_mission_interfaces.action import Turn
from geometry_msgs.msg import TwistStamped
from measuring import table
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from safety_kills import process
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from bt_mission.core.stamps import to_ns

PERIOD_S = 0.05
"""Between two control steps, s."""
CALM_S = 10.0
"""For how long the control step is watched without a flood, s."""
READY_S = 60.0
"""How long a process may take until it serves, s."""
WAITS_S = 3.0
CLIENT = Path(__file__).with_name("floods_client.py")


class Robot:
    """A base on the spot that turns as told, with a scan that sees nothing; hears its commands."""

    def __init__(self) -> None:
        self.node = Node("robot", enable_rosout=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._yaw = self._angular = 0.0
        self._odometry = self.node.create_publisher(Odometry, "odom", 10)
        self._scan = self.node.create_publisher(LaserScan, "scan", 10)
        self.node.create_subscription(TwistStamped, "cmd_vel", self._take, QoSProfile(depth=1000))
        self.node.create_timer(PERIOD_S, self._tell)
        self.stamps_s: list[float] = []
        """Of the commands that move, in order."""
        self._turn = ActionClient(self.node, Turn, "turn")

    def close(self) -> None:
        """Leave."""
        self._executor.shutdown()
        self.node.destroy_node()

    def spin(self, seconds: float) -> None:
        """Go on for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    def drive(self) -> None:
        """Have the servers turn the base for as long as anything is measured."""
        end = time.monotonic() + READY_S
        goal = Turn.Goal(angle=3_600.0, angular_velocity=0.1)
        while time.monotonic() < end:
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

    def _tell(self) -> None:
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
    """What became of one flood."""

    sent: int = 0
    answered: int | None = None
    refused: int = 0
    seconds: float = 0.0
    cpu_s: float = 0.0
    grown_mib: float = 0.0
    late_s: list[float] = field(default_factory=list)
    """How much later than 50 ms after the one before it each command was."""

    def row(self, name: str) -> tuple[object, ...]:
        """Return the cells of a table."""
        answered = (
            "" if self.answered is None else f"{self.answered:,}, {self.refused:,} of them no"
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
    robot: Robot, target: subprocess.Popen[bytes], kind: str, name: str, count: int, *, floods: int
) -> Flooded:
    """Flood a process from so many others, and see what becomes of it."""
    cpu_s, resident = _used(target.pid)
    first = len(robot.stamps_s)
    clients = [
        subprocess.Popen(  # noqa: S603 - starts our own program
            [sys.executable, str(CLIENT), kind, name, str(count // floods)],
            stdout=subprocess.PIPE,
        )
        for _ in range(floods)
    ]
    most = resident
    while any(client.poll() is None for client in clients):
        robot.spin(0.1)
        if target.poll() is not None:
            raise RuntimeError(f"the process has ended: {target.returncode}")
        most = max(most, _used(target.pid)[1])
    robot.spin(WAITS_S)
    found = Flooded()
    for client in clients:
        assert client.stdout is not None
        answer = json.loads(client.stdout.read())
        found.sent += answer["sent"]
        found.seconds = max(found.seconds, answer["seconds"])
        if "answered" in answer:
            found.answered = (found.answered or 0) + answer["answered"]
            found.refused += answer["refused"]
    cpu_after_s, resident_after = _used(target.pid)
    found.cpu_s = cpu_after_s - cpu_s
    found.grown_mib = (max(most, resident_after) - resident) / 2**20
    found.late_s = _lateness(robot.stamps_s[first:])
    return found


def calm(robot: Robot, target: subprocess.Popen[bytes]) -> Flooded:
    """Watch the control step without a flood."""
    cpu_s, resident = _used(target.pid)
    first = len(robot.stamps_s)
    robot.spin(CALM_S)
    cpu_after_s, after = _used(target.pid)
    late_s = _lateness(robot.stamps_s[first:])
    grown_mib = (after - resident) / 2**20
    return Flooded(seconds=CALM_S, cpu_s=cpu_after_s - cpu_s, grown_mib=grown_mib, late_s=late_s)


def _lateness(stamps_s: list[float]) -> list[float]:
    gaps = [after - before for before, after in zip(stamps_s, stamps_s[1:], strict=False)]
    return [gap - PERIOD_S for gap in gaps]


def _used(pid: int) -> tuple[float, int]:
    """Return seconds of CPU and bytes of memory that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK"), int(fields[21]) * resource.getpagesize()


HEAD = ("flood", "sent", "answered", "CPU, s", "memory, MiB", "99 % late by", "latest by")


def servers(count: int) -> list[tuple[object, ...]]:
    """Flood the servers while they turn a robot."""
    rows = []
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        options = ("servers", "--images", folder, "--wall-clock")
        with Path("/tmp/fl/servers.log").open("wb") as log:
            target = stack.enter_context(process(*options, log=log))
        robot = Robot()
        stack.callback(robot.close)
        robot.drive()
        rows.append(calm(robot, target).row("servers: none"))
        for kind, name, many in (
            ("goals", "turn", count),
            ("cancels", "move/_action/cancel_goal", count),
            ("scans", "scan", 10 * count),
            ("odometry", "odom", 10 * count),
            ("stop", "stop", count),
        ):
            robot.spin(12.0)  # until goals are accepted again
            robot.call("release")
            robot.drive()
            found = watched(robot, target, kind, name, many, floods=1)
            rows.append(found.row(f"servers: {kind}"))
            print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    arguments = parser.parse_args()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    rclpy.init()
    table(HEAD, servers(arguments.count))
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
