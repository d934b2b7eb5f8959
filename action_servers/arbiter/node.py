"""The arbiter as a ROS node: between several topics of commands and the base."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from geometry_msgs.msg import TwistStamped
from rclpy.executors import Executor
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from action_servers.arbiter.arbiter import SOURCES, Arbiter, CommandAge, CommandSource
from action_servers.core.maneuver import ZERO
from action_servers.robot_io.base import Choice, CommandPublisher, CommandWiring
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import ParameterSpec
from bt_mission.base.stamps import to_ns
from bt_mission.ros.executors.process import (
    NO_ARGUMENTS,
    ProcessOptions,
    RobotNode,
    RobotNodeOptions,
    run,
)

NODE_NAME = "bt_mission_arbiter"
CHECK_HZ = 50.0
"""Looks a second whether a source has fallen silent."""

LAST_WORDS_S = 0.5
"""Seconds to wait until the robot has confirmed the last command."""

NEWEST = QoSProfile(depth=1)
"""Of several waiting commands, only the newest is used."""

SHORTEST_S, LONGEST_S = 0.1, 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ArbiterOptions(RobotNodeOptions):
    """The options of the arbiter.

    `command_type`: of `cmd_vel`; "auto" is what the robot subscribes to.
    """

    command_type: Choice = "stamped"


class ArbiterNode(RobotNode):
    """Publishes on `cmd_vel` the command of the highest active source.

    The sources are `cmd_vel_stop`, `cmd_vel_joy`, `cmd_vel_mission`, all
    `geometry_msgs/TwistStamped`. Without an active source it sends zero velocity. It subscribes to
    the sources only while the base subscribes to `cmd_vel`, so that publishers can detect that.
    """

    def __init__(self, options: ArbiterOptions) -> None:
        super().__init__(NODE_NAME, options)
        wiring = self.declare_all(CommandWiring.of_type(options.command_type))
        self._sources = [
            replace(source, timeout_s=self.declare(*_timeout(source))) for source in SOURCES
        ]
        self._arbiter = Arbiter(self._sources)
        self._ages = {source.topic: CommandAge() for source in self._sources}
        self._leader: str | None = None
        self._inputs: list[Subscription] = []
        self._base = CommandPublisher(self, wiring, lambda _: self._listen())
        self._listen()
        self.create_timer(1.0 / CHECK_HZ, self._check)

    def stop(self) -> None:
        """Command zero velocity, and hear nobody any more."""
        self._hear_nobody()
        self._base.command(ZERO)

    def destroy_node(self) -> None:
        """Stop the robot, then leave the graph."""
        self.stop()
        super().destroy_node()

    def end(self, signal: str, executor: Executor) -> None:  # noqa: ARG002 - a node's
        """Stop the robot."""
        self.stop()
        self._base.wait_until_stopped(LAST_WORDS_S)

    def _listen(self) -> None:
        if self._base.fault is not None:
            self._hear_nobody()
        elif not self._inputs:
            self._inputs = [
                self.create_subscription(
                    TwistStamped, source.topic, partial(self._take, source.topic), NEWEST
                )
                for source in self._sources
            ]

    def _hear_nobody(self) -> None:
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self._inputs.clear()

    def _take(self, topic: str, message: Any) -> None:
        linear = message.twist.linear
        twist = Twist2D(linear.x, message.twist.angular.z, linear.y)
        now_ns = self._now_ns()
        age_ns = self._ages[topic].of(to_ns(message.header.stamp), now_ns)
        try:
            answer = self._arbiter.take(topic, twist, now_ns, age_ns)
        except ValueError as error:
            self._log.warning(f"passed over: {error}", throttle_duration_sec=5.0)
            return
        self._report(now_ns)
        if answer is not None:
            # The stamp is the time of sending, so that the base's timeout does not restart. A stamp
            # that is a lifetime old is invalid; 0 is the least that a message can hold here.
            self._base.command(answer, max(0, now_ns - age_ns))

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


def _timeout(source: CommandSource) -> tuple[str, ParameterSpec]:
    return f"timeouts.{source.topic.removeprefix('cmd_vel_')}", ParameterSpec(
        source.timeout_s,
        f"Seconds after which silence of {source.topic} means that it has gone.",
        SHORTEST_S,
        LONGEST_S,
    )


def main(
    *,
    namespace: str = "",
    use_sim_time: bool = False,
    command_type: Choice = "stamped",
    process: ProcessOptions = NO_ARGUMENTS,
) -> int:
    """Arbitrate until SIGINT or SIGTERM, then stop the robot. Returns the exit code 0."""
    options = ArbiterOptions(
        namespace=namespace, use_sim_time=use_sim_time, command_type=command_type
    )
    return run(NODE_NAME, process, options, ArbiterNode)
