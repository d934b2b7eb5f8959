"""Processes that are killed while the robot drives: how soon the base stands, by its true pose.

Sim, arbiter, servers and executive are processes, at the speed of the wall clock. Times are those
of the simulation; the truth is published 20 times a second, so each is exact to 0.05 s.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Self

import rclpy
import yaml
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from bt_mission.base.stamps import to_ns
from bt_mission.base.wall_clock import Stopwatch

SPEED = 0.26
TRUTH_PERIOD_S = 0.05
"""Between two messages of the true motion."""
PATIENCE_S = 180.0
"""Seconds of the wall clock until the robot must drive, and after the kill, stand."""
WATCHED_S = 1.0
"""Seconds of the simulation for which the base is watched once it stands."""

MISSION = """\
mission: drive
world: {world}
tree:
  retry: {{attempts: 20, pause: 1}}
  do:
    explore_forward: {{fwd_velocity: {speed}, stopping_distance: 0.3}}
    timeout: 100
"""


@dataclass(frozen=True)
class Kill:
    """A process that was killed at full speed, and when the base then stood."""

    killed: str
    with_arbiter: bool
    stood_after_s: float
    way_m: float
    """How far the base still went."""
    after_command_s: float = float("inf")
    """When it stood, after the time at which the last command that moves was sent."""
    commands: tuple[tuple[float, float], ...] = ()
    """What the base was told from then on, in order: m/s ahead, rad/s to the left."""
    stayed: bool = False
    """Whether it stood for all of :data:`WATCHED_S` after that."""
    load: float = 0.0
    """Mean load of the machine in the last minute."""


class Truth:
    """Hears the true motion of the base, as `(time s, x, linear, angular)`, and its commands."""

    def __init__(self) -> None:
        self._exit = ExitStack()
        self.context = Context()
        rclpy.init(context=self.context)
        self._exit.callback(self.context.shutdown)
        node = rclpy.create_node("truth", context=self.context, enable_rosout=False)
        self._exit.callback(node.destroy_node)
        node.create_subscription(Odometry, "ground_truth/odom", self._take, 50)
        node.create_subscription(TwistStamped, "cmd_vel", self._take_command, 50)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(node)
        self._exit.callback(self._executor.shutdown)
        self.seen: list[tuple[float, float, float, float]] = []
        self.commands: list[tuple[float, float]] = []
        self.commanded_s = 0.0
        """When the last command that moves was sent."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    def _take(self, message: Any) -> None:
        stamp, twist = message.header.stamp, message.twist.twist
        self.seen.append(
            (
                stamp.sec + stamp.nanosec * 1e-9,
                message.pose.pose.position.x,
                twist.linear.x,
                twist.angular.z,
            )
        )

    def _take_command(self, message: Any) -> None:
        self.commands.append((message.twist.linear.x, message.twist.angular.z))
        if message.twist.linear.x or message.twist.angular.z:
            self.commanded_s = to_ns(message.header.stamp) / 1e9

    def hear(self, seconds: float) -> None:
        """Take in what there is, and what comes within seconds of the wall clock."""
        watch = Stopwatch()
        while (left_s := seconds - watch.elapsed_s) > 0.0:
            self._executor.spin_once(timeout_sec=left_s)

    def stands(self) -> bool:
        """Tell whether the base stands, by the newest truth that was heard."""
        return _stands(*self.seen[-1][2:])

    def forget(self) -> None:
        """Begin anew, as the simulation does."""
        self.seen.clear()
        self.commanded_s = 0.0

    @property
    def newest_s(self) -> float:
        """Time of the newest truth that was heard, s; 0 before there is any."""
        return self.seen[-1][0] if self.seen else 0.0

    def stood_s(self) -> float:
        """Time from which on the base stands, by all truth since then, s."""
        first_s = self.newest_s
        for time_s, _, linear, angular in reversed(self.seen):
            if not _stands(linear, angular):
                break
            first_s = time_s
        return first_s

    def newest(self) -> tuple[float, float, float, float]:
        """Return the newest truth that there is, after a look for more."""
        before = len(self.seen)
        watch = Stopwatch()
        while len(self.seen) == before and watch.elapsed_s < PATIENCE_S:
            self._executor.spin_once(timeout_sec=0.5)
        for _ in range(20):
            self._executor.spin_once(timeout_sec=0.0)
        return self.seen[-1]


def _stands(linear: float, angular: float) -> bool:
    return abs(linear) < 0.01 and abs(angular) < 0.02


@contextmanager
def process(
    *arguments: str, log: int | IO[bytes] = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``bt-mission`` in a process that is killed at the end, with its log somewhere."""
    started = subprocess.Popen(  # noqa: S603 - starts our own program
        [sys.executable, "-m", "bt_mission", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=log,
    )
    try:
        yield started
    finally:
        started.kill()
        started.wait()


@contextmanager
def driving(
    *,
    with_arbiter: bool,
    world: str = "empty_arena",
    log: int | IO[bytes] = subprocess.DEVNULL,
    parameters: Mapping[str, Any] | None = None,
) -> Iterator[tuple[dict[str, subprocess.Popen[bytes]], Truth]]:
    """Have a base drive at full speed: the processes "servers" and "executive", and the truth.

    The servers have these parameters, and their log goes to `log`. Raises RuntimeError when it
    never drives.
    """
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        mission, file = folder / "drive.yaml", folder / "parameters.yaml"
        mission.write_text(MISSION.format(world=world, speed=SPEED), encoding="utf-8")
        topic = "cmd_vel_mission" if with_arbiter else "cmd_vel"
        values = {"topics.cmd_vel": topic, **(parameters or {})}
        file.write_text(
            yaml.safe_dump({"bt_mission_servers": {"ros__parameters": values}}), encoding="utf-8"
        )
        options = ["--images", str(folder / "images"), "--params", str(file)]
        stack.enter_context(process("sim", "--world", world, "--no-camera"))
        if with_arbiter:
            stack.enter_context(process("arbiter"))
        images = str(folder / "images")
        processes = {
            "servers": stack.enter_context(
                process("servers", "--images", images, *options, log=log)
            ),
            "executive": stack.enter_context(process("run", str(mission), "--attach")),
        }
        truth = stack.enter_context(Truth())
        watch = Stopwatch()
        # Without a command that was heard, nothing could be said of the time since the last one.
        while truth.newest()[2] < 0.98 * SPEED or not truth.commanded_s:
            if watch.elapsed_s > PATIENCE_S:
                raise RuntimeError("the robot never drove; are the processes alive?")
        yield processes, truth


def kill(what: str, *, with_arbiter: bool, world: str = "empty_arena") -> Kill:
    """Kill "servers" or "executive" when the base drives at full speed.

    Raises RuntimeError when it never does.
    """
    with driving(with_arbiter=with_arbiter, world=world) as (processes, truth):
        killed_s, killed_x, *_ = truth.newest()
        before = len(truth.commands)
        processes[what].kill()
        watch = Stopwatch()
        while True:
            x = truth.newest()[1]
            if truth.stands():
                stood_s = truth.stood_s()
                break
            if watch.elapsed_s > PATIENCE_S:
                return Kill(what, with_arbiter, float("inf"), x - killed_x)
        stayed = True
        while truth.newest()[0] < stood_s + WATCHED_S:
            stayed = stayed and truth.stands()
        return Kill(
            what,
            with_arbiter,
            stood_after_s=stood_s - killed_s,
            way_m=x - killed_x,
            after_command_s=stood_s - truth.commanded_s,
            commands=tuple(truth.commands[before:]),
            stayed=stayed,
            load=os.getloadavg()[0],
        )
