"""What the servers hear and tell beside their actions: stop, motors, executives, state.

The liveliness of executives, which DDS reports: pure.

An executive whose sign of life is late may have died, or the machine or the network is busy. So the
base is held at once, and goals end only if the sign of life stays away.

The check of the publishers of the robot's odometry: two robots are not driven as one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.timer import Timer
from std_msgs.msg import Bool, Empty
from std_srvs.srv import Trigger

from action_servers.core.maneuver import ErrorCode
from action_servers.core.pilot import Interlock, Pilot
from action_servers.robot_io.adapter import REQUESTS
from action_servers.robot_io.sensors import LATCHED
from bt_mission.base.dds.liveliness import LEASE_S, TIMEOUT_S, TOPIC
from bt_mission.base.dds.publishers import duplicate_publishers, single_publisher_topics
from bt_mission.base.parameters import number
from bt_mission.base.ros_log import log_of

LOOK_S = 0.1
"""The interval of :meth:`ExecutiveWatch.look` while an executive is late, s. Looks are counted, not
time: a server that is delayed itself does not take the executive for dead.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExecutiveLimits:
    """The limits of an executive without a sign of life, s of the wall clock."""

    executive_lease: float = number(
        LEASE_S,
        (LEASE_S, 10.0),
        "Time without a sign of life of an executive after which the base is held, s. With the "
        "0.26 s of braking from full speed, it stands within 0.5 s.",
        is_fixed=True,
    )
    executive_timeout: float = number(
        TIMEOUT_S,
        (LEASE_S, 600.0),
        "Time without a sign of life of an executive after which every goal is aborted, s.",
        is_fixed=True,
    )


class ExecutiveWatch:
    """Counts executives that are alive, late and given up.

    Args:
        limits: The time until one is late, for messages, and until it is given up.
        on_late: Called with the reason when one is late.
        on_back: Called when none is late any more.
        on_lost: Called with the reason when one is given up, and when the last one leaves.
    """

    def __init__(
        self,
        limits: ExecutiveLimits,
        on_late: Callable[[str], None],
        on_back: Callable[[], None],
        on_lost: Callable[[str], None],
    ) -> None:
        self._limits = limits
        self._on_late, self._on_back, self._on_lost = on_late, on_back, on_lost
        self._alive = 0
        self._not_alive = 0
        self._given_up = 0
        self._looks = 0

    @property
    def late(self) -> int:
        """The number of executives that are late and not given up."""
        return self._not_alive - self._given_up

    def update(self, alive: int, not_alive: int) -> None:
        """Take in how many executives give a sign of life now, and how many do not."""
        has_left = alive + not_alive < self._alive + self._not_alive
        late_before = self.late
        has_left_late = has_left and not_alive < self._not_alive and alive <= self._alive
        self._alive, self._not_alive = alive, not_alive
        self._given_up = min(self._given_up, not_alive)
        if self.late > late_before:
            self._looks = 0
            lease_s = self._limits.executive_lease
            self._on_late(f"no sign of life of the executive for {lease_s:g} s: the base is held")
        elif late_before and has_left_late:
            self._lose("the executive has gone while its sign of life was late")
        elif has_left and not alive and not self.late:
            self._on_lost("the executive has left")
        if late_before and not self.late:
            self._on_back()

    def look(self) -> None:
        """Give those up that have been late for too long."""
        if not self.late:
            return
        self._looks += 1
        since_s = self._limits.executive_lease + self._looks * LOOK_S
        if since_s >= self._limits.executive_timeout - LOOK_S / 2:
            limit_s = self._limits.executive_timeout
            self._lose(f"the executive has died: no sign of life for {limit_s:g} s")
            self._on_back()

    def _lose(self, why: str) -> None:
        self._given_up = self._not_alive
        self._on_lost(why)


class Switches:
    """The services `stop` and `release`, and the topic `motors_on`, of an interlock.

    A robot that does not tell about its motors has them on.
    """

    def __init__(self, node: Node, interlock: Interlock) -> None:
        self._log = log_of(node)
        self._interlock = interlock
        self._logged = ""
        for name, act in (("stop", interlock.stop), ("release", interlock.release)):
            serve = partial(self._serve, act)
            node.create_service(Trigger, name, serve, qos_profile=REQUESTS)
        node.create_subscription(Bool, "motors_on", self._hear_of_motors, LATCHED)

    def _serve(self, act: Callable[[], str], _request: Any, response: Any) -> Any:
        done = act()
        if done != self._logged:
            self._logged = done
            self._log.info(done)
        response.success, response.message = True, done
        return response

    def _hear_of_motors(self, message: Any) -> None:
        self._interlock.set_motors(on=message.data)


def watch_executives(node: Node, limits: ExecutiveLimits, pilot: Pilot) -> None:
    """Hold the base while an executive is late; end its goals when it has died or left.

    A client other than an executive of this package is not watched.
    """
    log = log_of(node)
    timer: Timer | None = None

    def be_late(why: str) -> None:
        nonlocal timer
        if not pilot.idle:
            log.warning(why)
        pilot.hold()
        if timer is None:  # made when it is needed: virtual time has no timer of another clock
            wall = Clock(clock_type=ClockType.STEADY_TIME)
            timer = node.create_timer(LOOK_S, watch.look, clock=wall)
        timer.reset()

    def lose(why: str) -> None:
        if not pilot.idle:
            pilot.stop(why, ErrorCode.EXECUTIVE_LOST)

    def be_back() -> None:
        if timer is not None:
            timer.cancel()
        pilot.release()

    watch = ExecutiveWatch(limits, be_late, be_back, lose)

    def changed(status: Any) -> None:
        watch.update(status.alive_count, status.not_alive_count)

    events = SubscriptionEventCallbacks(liveliness=changed, use_default_callbacks=False)
    presence = QoSProfile(
        depth=1,
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(nanoseconds=round(limits.executive_lease * 1e9)),
    )
    node.create_subscription(Empty, TOPIC, lambda _: None, presence, event_callbacks=events)


def answer_as_navigator(node: Node, is_ready: Callable[[], bool]) -> None:
    """Offer `bt_navigator/get_state`, which programs for Nav2 ask until they hear "active".

    Args:
        node: Of the servers.
        is_ready: Whether navigation has all that it needs; "inactive" until then.
    """

    def answer(_request: Any, response: Any) -> Any:
        state = response.current_state
        state.id, state.label = (
            (State.PRIMARY_STATE_ACTIVE, "active")
            if is_ready()
            else (State.PRIMARY_STATE_INACTIVE, "inactive")
        )
        return response

    node.create_service(GetState, "bt_navigator/get_state", answer, qos_profile=REQUESTS)


WATCH_PERIOD_S = 0.5
"""Seconds between two looks."""


class PublisherWatch:
    """Checks whether topics of the robot have several publishers.

    Args:
        node: A node of the graph.
        odometry: The topic of odometry.
        on_fault: Called with each new reason.
    """

    def __init__(self, node: Node, odometry: str, on_fault: Callable[[str], None]) -> None:
        self._node = node
        self._odometry = odometry
        self._log = log_of(node)
        self._on_fault = on_fault
        self._fault: str | None = None
        node.create_timer(WATCH_PERIOD_S, self.look)

    def look(self) -> str | None:
        """Return why nothing may be driven, or None."""
        if not self._node.context.ok():
            return None
        fault, before = duplicate_publishers(self._node, self._odometry), self._fault
        self._fault = fault
        if fault is not None and fault != before:
            self._log.error(fault)
            self._on_fault(fault)
        elif fault is None and before is not None:
            topics = single_publisher_topics(self._node, self._odometry)
            self._log.info(f"each of {', '.join(topics)} has one publisher again")
        return fault
