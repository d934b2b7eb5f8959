"""Floods of requests and messages: the responses, the cost, and whether control is on time.

What is flooded runs in a process of its own, `bt-mission servers`, `arbiter` or `serve`, on this
machine's clock, beside a robot that turns as it is told. Whether the servers' control step was on
time is read from the stamps of the velocity commands, which are made in the servers themselves.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
from argparse import Namespace
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import chain, pairwise
from typing import Any

import numpy as np
import rclpy
from action_msgs.srv import CancelGoal
from bt_mission_interfaces.action import ExecuteMission, Turn
from bt_mission_interfaces.srv import SetBreakpoint
from builtin_interfaces.msg import Duration as DurationMessage
from geometry_msgs.msg import TwistStamped
from nav2_msgs.action import Wait
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from safety_kills import process
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from benchmarks.measuring import arguments, figure, process_usage, table, times
from bt_mission.base.stamps import to_ns
from bt_mission.base.wall_clock import Stopwatch, rest

PERIOD_S = 0.05
"""Between two control steps, s."""
CALM_S = 10.0
"""The time for which the control step is watched without a flood, s."""
READY_S = 120.0
"""The limit for a process to serve, s."""
START_S = 10.0
"""The time without growth of memory after which a process counts as started, s."""
REST_S = 12.0
"""The time after which servers accept goals again, s."""
WAITS_S = 3.0
"""The time for which a process is watched after a flood, s."""
PATIENCE_S = 30.0
"""Wall time without a response after which a client stops waiting, s."""
IN_A_ROW = 20
UNANSWERED = 2_000
"""The most open requests: the client's reader must not drop responses."""

DEEP = QoSProfile(depth=20_000)
BEHIND = Duration(seconds=10)
TYPES: dict[str, Any] = {"velocities": TwistStamped, "scans": LaserScan, "clock": Clock}
GOALS: dict[str, Any] = {
    "turns": (Turn, Turn.Goal(angle=3600.0, angular_velocity=0.1)),
    "waits": (Wait, Wait.Goal(time=DurationMessage(sec=3600))),
    "missions": (ExecuteMission, ExecuteMission.Goal(path="no_such_mission")),
}


# ---- a client that floods, as fast as it can, in a process of its own ----------------------------


class Answers:
    """Counts responses and refusals, and notes the time of the last one."""

    def __init__(self) -> None:
        self.sent = self.count = self.refused = 0
        self.last_s = 0.0
        self._watch = Stopwatch()

    def take(self, future: Any) -> None:
        """Count one."""
        answer = future.result()
        self.count += 1
        self.refused += not getattr(answer, "accepted", getattr(answer, "success", True))
        self.last_s = self._watch.elapsed_s

    @property
    def silence_s(self) -> float:
        """Seconds since the last one."""
        return self._watch.elapsed_s - self.last_s


def request(node: Node, kind: str, name: str) -> Callable[[int], Any]:
    """Return a function that sends one request of a kind, by its number, and returns a future."""
    if kind in GOALS:
        action, goal = GOALS[kind]
        sender = ActionClient(node, action, name, goal_service_qos_profile=DEEP)
        sender.wait_for_server()
        return lambda _: sender.send_goal_async(goal)
    service = {"cancels": CancelGoal, "breakpoints": SetBreakpoint}.get(kind, Trigger)
    client = node.create_client(service, name, qos_profile=DEEP)
    client.wait_for_service()
    if kind == "breakpoints":
        return lambda number: client.call_async(SetBreakpoint.Request(node=f"node {number}"))
    # A cancel of neither a goal nor a time is one of all goals.
    return lambda _: client.call_async(service.Request())


def ask(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Send a number of requests, and wait for the responses."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    send = request(node, kind, name)
    answers = Answers()
    while answers.count < count and answers.silence_s < PATIENCE_S:
        for _ in range(
            min(IN_A_ROW, count - answers.sent, UNANSWERED - answers.sent + answers.count)
        ):
            send(answers.sent).add_done_callback(answers.take)
            answers.sent += 1
        executor.spin_once(timeout_sec=0.0 if answers.sent < count else 0.1)
    return {
        "sent": answers.sent,
        "answered": answers.count,
        "refused": answers.refused,
        "seconds": answers.last_s,
    }


def publish(node: Node, kind: str, name: str, count: int) -> dict[str, float]:
    """Publish so many messages, each as soon as the one before it has gone."""
    publisher = node.create_publisher(TYPES[kind], name, 10)
    messages = [serialize_message(message) for message in _messages(node, kind)]
    while not publisher.get_subscription_count():
        rest(0.05)
    watch = Stopwatch()
    for index in range(count):
        publisher.publish(messages[index % len(messages)])
    return {"sent": count, "seconds": watch.elapsed_s}


def _messages(node: Node, kind: str) -> list[Any]:
    """Return messages that are sent in turns."""
    if kind == "clock":
        now = node.get_clock().now()
        return [Clock(clock=time.to_msg()) for time in (now, now - BEHIND)]
    message = TYPES[kind]()
    if kind == "velocities":
        message.twist.angular.z = 0.1
    return [message]


def flood(kind: str, name: str, count: str) -> None:
    """Flood once, and print the outcome as JSON."""
    node = rclpy.create_node("flood", enable_rosout=False)
    flooded = (publish if kind in TYPES else ask)(node, kind, name, int(count))
    print(json.dumps(flooded), flush=True)


# ---- what is flooded -----------------------------------------------------------------------------


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
            while not future.done() and watch.elapsed_s < READY_S:
                self.spin(0.1)
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
        late = ("", "")
        if self.late_s:
            late_ms = figure(f"{name}: a command is late by", times(1000, self.late_s), "ms")
            late = (f"{np.percentile(late_ms, 99):.0f} ms", f"{max(late_ms):.0f} ms")
        sent = f"{self.sent:,} in {self.seconds:.1f} s"
        return (name, sent, answered, f"{self.cpu_s:.1f}", f"{self.grown_mib:.1f}", *late)


def watched(
    robot: Robot, target: subprocess.Popen[bytes], kind: str, name: str, count: int
) -> Flooded:
    """Flood a process from another one, and measure it."""
    cpu_s, resident = process_usage(target.pid)
    first = len(robot.stamps_s)
    client = subprocess.Popen(  # noqa: S603 - starts our own program
        [sys.executable, __file__, "--flood", kind, name, str(count)], stdout=subprocess.PIPE
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


KINDS = ["waits", "cancels", "scans", "turns", "stops", "clock", "velocities", "missions"]
KINDS += ["breakpoints"]
HEAD = ("flood", "sent", "answered", "CPU, s", "memory, MiB", "99 % late by", "latest by")


def servers(robot: Robot, folder: str, options: Namespace) -> Iterator[tuple[object, ...]]:
    """Flood the servers while they turn a robot."""
    count = options.count
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
            if kind not in options.kinds:
                continue
            result = watched(robot, target, kind, name, many)
            if kind in ("turns", "stops"):
                result.late_s = []  # the driving goal is replaced, or has ended
            yield result.row(f"servers: {kind}")
            robot.call("release")
            if kind != "stops":
                robot.rest(REST_S)
                robot.drive()


def others(robot: Robot, folder: str, options: Namespace) -> Iterator[tuple[object, ...]]:
    """Flood the other processes, and servers on simulated time."""
    count = options.count
    for words, kind, name, many in (
        (("servers", "--images", folder), "clock", "/clock", 10 * count),
        (("arbiter", "--wall-clock"), "velocities", "cmd_vel_mission", 100 * count),
        (("sim", "--no-camera"), "velocities", "cmd_vel", 100 * count),
        (("serve", "--wall-clock", "--missions", folder), "missions", "execute_mission", count),
        (("serve", "--wall-clock"), "breakpoints", "bt_mission/breakpoint", count),
    ):
        if kind not in options.kinds:
            continue
        with process(*words) as target:
            settle(robot, target)
            result = watched(robot, target, kind, name, many)
        result.late_s = []
        yield result.row(f"{words[0]}: {kind}")


def main() -> None:
    """Print the table."""
    options = arguments(
        __doc__,
        only={"servers": servers, "others": others},
        count=(10_000, "requests of a flood"),
        kinds=(KINDS, "of floods"),
        pauses=(1.0, "of the usual ones, what part"),
        flood=([""], "kind, name and count: be a client that floods"),
    )
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    rclpy.init()
    if any(options.flood):
        flood(*options.flood)
    else:
        robot = Robot(options.pauses)
        with tempfile.TemporaryDirectory() as folder:
            parts = (part(robot, folder, options) for part in options.only)
            table(HEAD, chain.from_iterable(parts))
        robot.close()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
