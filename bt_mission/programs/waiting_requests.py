"""What the log of a node says of its threads: why a request waited, and what would wait."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Container, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from rclpy.action import ActionServer
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription

from bt_mission.base.clock_watch import callback_in
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import NS
from bt_mission.programs.calls import Call
from bt_mission.programs.places import what_of
from bt_mission.ros.virtual_time import VirtualTimeExecutor

LATE = "BT-920"
"""The code of a request that has waited."""

WAITED_NS = 500_000_000
"""A request that has waited this long is worth a line, ns."""

LOOPED_NS = 2_000_000_000
"""So is a callback that has looped this long without waiting, ns, and are messages that have waited
this long."""

NAMES = {"cancel": "cancel request", "goal": "goal request"}

QUIET = ("/parameter_events", "/clock")
"""Topics to which rclpy itself subscribes."""


@dataclass
class _Refused:
    server: ActionServer
    why: str
    times_ns: list[int] = field(default_factory=list)
    """When its requests came."""


def _why(holders: Sequence[Call], of_group: str) -> str:
    """Say what holds the threads of an executor, or the group of an entity, and what to do."""
    if of_group:
        threads = (
            f"the callback group of the {of_group}; give the {of_group} a ReentrantCallbackGroup"
        )
    elif len(holders) == 1:
        threads = (
            "the only thread of its executor; use a MultiThreadedExecutor and a "
            "ReentrantCallbackGroup"
        )
    else:
        threads = f"one of the {len(holders)} threads of its executor, all busy; use more threads"
    return f"{what_of(holders[0])} in {threads}"


class Remarks:
    """Finds what is worth a line in the log of a node."""

    def __init__(self, clock: VirtualTimeExecutor) -> None:
        self._clock = clock
        self._refused: dict[int, _Refused] = {}
        self._starved_ns: dict[int, int] = {}
        """Since when messages of a subscription wait, by its identity."""
        self._lines: set[tuple[str, str]] = set()
        self.warnings: list[str] = []
        """The warnings in the logs, each after the name of its node."""

    def refuse(self, entity: Any, node: Node, holders: Sequence[Call], *, by_group: bool) -> None:
        """Note that an action server or a subscription has to wait for these calls."""
        if not holders:
            return
        now_ns = self._clock.now_ns
        if isinstance(entity, ActionServer):
            refused = self._refused.get(id(entity))
            if refused is None:
                why = _why(holders, "server" if by_group else "")
                refused = self._refused[id(entity)] = _Refused(entity, why)
            new = self._clock.arrivals.count_of(entity) - len(refused.times_ns)
            refused.times_ns += [now_ns] * new
        elif isinstance(entity, Subscription):
            since_ns = self._starved_ns.setdefault(id(entity), now_ns)
            if since_ns >= 0 and now_ns - since_ns >= LOOPED_NS and entity.topic_name not in QUIET:
                self._starved_ns[id(entity)] = -1
                self.say(
                    node,
                    f"messages of {entity.topic_name} have waited {LOOPED_NS / NS:g} s: "
                    f"{_why(holders, 'subscription' if by_group else '')} [{LATE}]",
                )

    def close(self) -> None:
        """Say which cancel requests have waited until now."""
        for refused in tuple(self._refused.values()):
            with suppress(InvalidHandle, _rclpy.RCLError):
                server = refused.server
                server._is_goal_request_ready = server._is_goal_expired = False
                server._is_cancel_request_ready = server._is_result_request_ready = True
                self.took(server, server.take_data())

    def took(self, waitable: Any, parts: Any) -> None:
        """Say for how long a request has waited, and why."""
        refused = self._refused.pop(id(waitable), None)
        if refused is None or not refused.times_ns:
            return
        for part, name in NAMES.items():
            # Of the requests that wait together, that for the result of the goal comes first.
            is_second = part == "cancel" and "result" in parts and len(refused.times_ns) > 1
            waited_ns = self._clock.now_ns - refused.times_ns[is_second]
            if part in parts and waited_ns >= WAITED_NS:
                self._warn(
                    waitable._node,
                    f"the {name} waited {waited_ns / NS:g} s: {refused.why} [{LATE}]",
                )

    def serve(self, entity: Any, node: Node, waiting: Sequence[Call]) -> None:
        """Say that a node needs several threads, where callbacks wait while another one runs."""
        self._starved_ns.pop(id(entity), None)
        for call in waiting:
            if call.entity is not entity:
                self.say(
                    node,
                    f"{what_of(call)} while other callbacks of its node run; under rclpy.spin, "
                    "they would wait",
                )

    def sleep_on_ros_time(self, nodes: Sequence[Node]) -> None:
        """Say what a sleep does in the thread in which a node receives `/clock`."""
        holder = callback_in(sys._getframe())
        for node in nodes[:1]:
            text = (
                f"{holder} sleeps on ROS time in the only thread of its executor; with use_sim_time"
            )
            self.say(node, f"{text}, it would hang on a robot, since nothing takes /clock")

    def loop(self, call: Call, looped_ns: int) -> None:
        """Say that a call has looped for a while, where nothing can end its loop."""
        spin = call.spin
        if looped_ns < LOOPED_NS or spin is None or spin.executor.free() is not None:
            return
        holder = callback_in(sys._getframe())
        self.say(
            call.node or spin.executor.get_nodes()[0],
            f"{holder} loops without waiting in the only thread of its executor; on a robot "
            "nothing else of its program runs: use a timer, or a MultiThreadedExecutor",
        )

    def compare_qos(self, nodes: Sequence[Node], own: Container[Node]) -> None:
        """Say which endpoints of own nodes are not matched for their QoS, as rclpy does."""
        publishers = defaultdict(list)
        for node in nodes:
            for publisher in node.publishers:
                publishers[publisher.topic_name].append((node, publisher))
        for receiver in nodes:
            for subscription in receiver.subscriptions:
                topic, wanted = subscription.topic_name, subscription.qos_profile
                for sender, publisher in publishers[topic]:
                    if receiver in own or sender in own:
                        verdict, why = qos_check_compatible(publisher.qos_profile, wanted)
                        if verdict == QoSCompatibility.ERROR:
                            why = why.removeprefix("ERROR: ").rstrip(";").lower()
                            self.say(
                                receiver if receiver in own else sender,
                                f"{receiver.get_name()} gets no messages of {topic} from "
                                f"{sender.get_name()}: incompatible QoS, {why}",
                            )

    def say(self, node: Node, text: str) -> None:
        """Log a line of a node once."""
        line = (node.get_fully_qualified_name(), text)
        if line not in self._lines:
            self._lines.add(line)
            self._warn(node, text)

    def _warn(self, node: Node, text: str) -> None:
        self.warnings.append(f"{node.get_fully_qualified_name().lstrip('/')}: {text}")
        log_of(node).warning(text)
