"""Velocity commands that have waited, without a virtual clock."""

import pytest
from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bt_mission.core.robot.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.world.loader import load_world

MS = 1_000_000


def test_of_commands_that_wait_the_newest_counts(context):
    """A simulator that is late takes one command between two steps, and it is not an old one."""
    options = SimOptions(seed=0, camera=False, context=context)
    sim = SimNode(load_world("empty_arena"), [RobotSpawn(load_robot("waffle"))], options)
    driver = Node("driver", context=context)
    commands = driver.create_publisher(TwistStamped, "cmd_vel", 10)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(sim)
    while not commands.get_subscription_count():
        executor.spin_once(timeout_sec=0.01)
    for speed in (0.01, 0.02, 0.03, 0.05):
        message = TwistStamped()
        message.twist.linear.x = speed
        commands.publish(message)
    while not sim.robots[0].commanded[0]:
        executor.spin_once(timeout_sec=1.0)
        sim.advance_to(sim.physics.time_ns + 100 * MS)
    assert sim.robots[0].commanded[0] == pytest.approx(0.05)
    executor.shutdown()
    driver.destroy_node()
    sim.destroy_node()
