"""The arbiter as a ROS node: between several topics of commands and the base."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from action_servers.arbiter.arbiter import SOURCES, Arbiter, CommandSource
from action_servers.core.maneuver import ZERO, Twist2D
from action_servers.robot_io.base import CommandPublisher
from action_servers.robot_io.command_types import Choice
from action_servers.robot_io.interrupts import SignalNote
from action_servers.robot_io.node_parameters import declare, made_with, overrides
from action_servers.robot_io.parameter_file import read_parameters
from action_servers.robot_io.robot_settings import RobotTopics, Setting, Wiring, base_settings

if TYPE_CHECKING:
    from rclpy.context import Context

NODE_NAME = "bt_mission_arbiter"
CHECK_HZ = 50.0
"""Looks a second whether a source has fallen silent."""

LAST_WORDS_S = 0.5
"""Seconds to wait until the robot has confirmed the last command."""

SHORTEST_S, LONGEST_S = 0.1, 5.0


class ArbiterNode(Node):
    """Sends to `cmd_vel` what the highest of `cmd_vel_stop`, `cmd_vel_joy`, `cmd_vel_mission` says.

    All of them are `geometry_msgs/TwistStamped`. While nobody speaks, it sends zero velocity. The
    topics of the sources are listened to only while the base would hear, so that whoever sends to
    them can tell.

    :param lean: no parameter services, log topic or type description.
    :param command_type: the type of `cmd_vel`; "auto" is what the robot listens for.
    :param parameters: values of parameters by name, instead of their defaults.
    """

    def __init__(
        self,
        *,
        lean: bool = False,
        context: Context | None = None,
        namespace: str | None = None,
        use_sim_time: bool = False,
        command_type: Choice = "stamped",
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(
            NODE_NAME,
            context=context,
            namespace=namespace,
            enable_rosout=not lean,
            start_parameter_services=not lean,
            parameter_overrides=[
                Parameter("use_sim_time", value=use_sim_time),
                Parameter("start_type_description_service", value=not lean),
                *overrides(parameters or {}),
            ],
        )
        self._log = _logger(self)
        if lean:
            self._log.set_level(LoggingSeverity.WARN)
        values = declare(self, (*base_settings(command_type), *_timeouts()))
        self._sources = [
            replace(source, timeout_s=values[_timeout_name(source)]) for source in SOURCES
        ]
        self._arbiter = Arbiter(self._sources)
        self._leader: str | None = None
        self._inputs: list[Subscription] = []
        wiring = Wiring(
            RobotTopics(cmd_vel=values["topics.cmd_vel"]),
            base_frame=values["frames.base"],
            command_type=values["cmd_vel_type"],
            watched=command_type == "auto",
        )
        self._base = CommandPublisher(self, wiring, lambda _: self._listen())
        self._listen()
        self.create_timer(1.0 / CHECK_HZ, self._check)

    def stop(self) -> None:
        """Command zero velocity, and hear nobody any more."""
        self._hear_nobody()
        self._base.command(ZERO)

    def wait_until_stopped(self, timeout_s: float) -> None:
        """Block until the base has acknowledged the last command."""
        self._base.wait_until_stopped(timeout_s)

    def destroy_node(self) -> None:
        """Stop the robot, then leave the graph."""
        self.stop()
        Node.destroy_node(self)

    def _listen(self) -> None:
        if self._base.fault is not None:
            self._hear_nobody()
        elif not self._inputs:
            self._inputs = [
                self.create_subscription(
                    TwistStamped, source.topic, partial(self._take, source.topic), 10
                )
                for source in self._sources
            ]

    def _hear_nobody(self) -> None:
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self._inputs.clear()

    def _take(self, topic: str, message: Any) -> None:
        twist = Twist2D(message.twist.linear.x, message.twist.angular.z)
        now_ns = self._now_ns()
        try:
            answer = self._arbiter.take(topic, twist, now_ns)
        except ValueError as error:
            self._log.warning(f"passed over: {error}", throttle_duration_sec=5.0)
            return
        self._report(now_ns)
        if answer is not None:
            self._base.command(answer)

    def _check(self) -> None:
        self._listen()
        now_ns = self._now_ns()
        answer = self._arbiter.step(now_ns)
        self._report(now_ns)
        if answer is not None:
            self._base.command(answer)

    def _report(self, now_ns: int) -> None:
        leader = self._arbiter.leader(now_ns)
        if leader != self._leader:
            self._leader = leader
            self._log.info(f"{leader} drives" if leader else "nobody drives: the base stands")

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def _logger(node: Node) -> Any:
    return node.get_logger()


def _timeouts() -> tuple[Setting, ...]:
    return tuple(
        Setting(
            _timeout_name(source),
            source.timeout_s,
            f"Seconds after which silence of {source.topic} means that it has gone.",
            SHORTEST_S,
            LONGEST_S,
        )
        for source in SOURCES
    )


def _timeout_name(source: CommandSource) -> str:
    return f"timeouts.{source.topic.removeprefix('cmd_vel_')}"


def main(
    *,
    namespace: str = "",
    use_sim_time: bool = False,
    command_type: Choice = "stamped",
    parameters: Path | None = None,
) -> int:
    """Arbitrate until SIGINT or SIGTERM, then stop the robot. Returns the exit code 0."""
    file = None if parameters is None else read_parameters(parameters, NODE_NAME)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = made_with(
            file,
            lambda values: ArbiterNode(
                namespace=namespace,
                use_sim_time=use_sim_time,
                command_type=command_type,
                parameters=values,
            ),
        )
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        with SignalNote() as interrupts:
            while not interrupts.received:
                executor.spin_once(timeout_sec=0.1)
            node.stop()
            node.wait_until_stopped(LAST_WORDS_S)
        executor.shutdown()
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return 0
