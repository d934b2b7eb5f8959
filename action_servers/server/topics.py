"""What the servers hear and tell beside their actions: stop, motors, executives, state."""

from __future__ import annotations

from collections.abc import Callable
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

from action_servers.core.error_codes import ErrorCode
from action_servers.core.executive_watch import LOOK_S, ExecutiveLimits, ExecutiveWatch
from action_servers.core.pilot import Interlock, Pilot
from action_servers.robot_io.adapter import REQUESTS
from action_servers.robot_io.sensors import LATCHED
from bt_mission.base.dds.liveliness import TOPIC
from bt_mission.base.ros_log import log_of


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
