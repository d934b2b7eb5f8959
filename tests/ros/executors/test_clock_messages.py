"""A node follows `/clock`, whatever comes on it."""

from __future__ import annotations

from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from bt_mission.ros.executors.clock_messages import ValidClock

TURNS = 200


class Follower(ValidClock, Node):
    """A node on simulated time."""


def test_a_time_before_0_is_passed_over() -> None:
    """The subscription of rclpy itself raises there; later times count."""
    context = Context()
    rclpy.init(context=context)
    options: dict[str, Any] = {
        "context": context,
        "enable_rosout": False,
        "start_parameter_services": False,
    }
    sim_time = [rclpy.Parameter("use_sim_time", value=True)]
    follower = Follower("follower", parameter_overrides=sim_time, **options)
    teller = Node("teller", **options)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(follower)
    publisher = teller.create_publisher(Clock, "/clock", 10)
    for _ in range(TURNS):
        for seconds in (-1, 5, -(2**31)):
            message = Clock()
            message.clock.sec = seconds
            publisher.publish(message)
            executor.spin_once(timeout_sec=0.05)
        if follower.get_clock().now().nanoseconds:
            break
    assert follower.get_clock().now().nanoseconds == 5_000_000_000
    executor.shutdown()
    follower.destroy_node()
    teller.destroy_node()
    context.shutdown()
