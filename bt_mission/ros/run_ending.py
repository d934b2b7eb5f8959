"""Waits for the goals of a halted mission to end, also after ROS was shut down.

rclpy's handlers of Ctrl-C and SIGTERM shut the context down. Requests still leave it, so goals are
cancelled, but no response is received any more: the results are then requested over another
context.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from bt_mission.base.errors import callback_failure
from bt_mission.base.wall_clock import Stopwatch, rest
from bt_mission.ros.goal_client import RosGoalClient
from bt_mission.ros.graph import END_WAIT_S, WAIT_S, quiet_node

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.node import Node

    from bt_mission.ros.mission_runtime import MissionRuntime


SPUN_ELSEWHERE = "generator already executing"
"""The ValueError of an executor of rclpy that another thread spins, and with it the node."""

FIND_WAIT_S = 3.0
"""The limit of the search for servers over another context."""


def see_to_the_end(runner: MissionRuntime) -> None:
    """Spin until every goal of a halted mission has ended, within a bound of wall time."""
    watch = Stopwatch()
    with ExitStack() as made:
        if runner.node.context.ok():
            _spin(runner, _executor_of(runner.node, made), watch)
        if not runner.is_done:
            runner.executive.after_tick.clear()  # what they publish goes nowhere any more
            runner.executive.cleanups.skip("ROS was shut down")
            runner.tick()
        if not runner.is_done:
            node = _stand_in(runner, made)
            executor = SingleThreadedExecutor(context=node.context)
            made.callback(executor.shutdown)
            executor.add_node(node)
            made.callback(executor.remove_node, node)
            if _move_goals(runner, node, executor, made):
                _spin(runner, executor, watch)


def _executor_of(node: Node, made: ExitStack) -> Executor:
    executor: Executor | None = node.executor
    if executor is None or node not in executor.get_nodes():
        # `rclpy.spin_once` takes the node out of its executor each time.
        executor = SingleThreadedExecutor(context=node.context)
        made.callback(executor.shutdown)
        executor.add_node(node)
        made.callback(executor.remove_node, node)
    return executor


def _spin(runner: MissionRuntime, executor: Executor, watch: Stopwatch) -> None:
    """Spin until the mission is done, or the executor's context is shut down.

    Clean-ups have their own time besides.
    """
    while not runner.is_done:
        if watch.elapsed_s > END_WAIT_S + runner.executive.cleanups.limit_s:
            runner.executive.abandon(f"not every goal had ended after {END_WAIT_S:g} s")
        try:
            executor.spin_once(timeout_sec=WAIT_S)
        except ExternalShutdownException:
            return
        except Exception as error:  # noqa: BLE001 - what the caller does on its node
            if isinstance(error, ValueError) and str(error) == SPUN_ELSEWHERE:
                rest(WAIT_S)
                continue
            if not executor.context.ok():
                return  # such as of a timer that was made while ROS was shut down
            runner.executive.abandon(callback_failure(error))
        else:
            runner.tick()  # also if ROS time, and with it the timer, does not move


def _stand_in(runner: MissionRuntime, made: ExitStack) -> Node:
    """Make a node in a separate context, in place of one whose context is shut down."""
    node = runner.node
    context = rclpy.Context()
    rclpy.init(
        context=context,
        domain_id=runner.domain_id,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    made.callback(context.shutdown)
    other = quiet_node(f"{node.get_name()}_ending", context, node.get_namespace())
    made.callback(other.destroy_node)
    return other


def _move_goals(runner: MissionRuntime, node: Node, executor: Executor, made: ExitStack) -> bool:
    """Request the results of open goals over another node; False if a server does not answer."""
    goals = runner.ledger.open_goals
    clients = {goal.goal_client for goal in goals if isinstance(goal.goal_client, RosGoalClient)}
    for client in clients:
        client.move_to(node)
        made.callback(client.close)
    watch = Stopwatch()
    while not all(client.is_ready() for client in clients):
        if watch.elapsed_s > FIND_WAIT_S:
            missing = ", ".join(
                sorted(goal_client.name for goal_client in clients if not goal_client.is_ready())
            )
            runner.executive.abandon(
                "ROS was shut down before every goal had ended: cancels were sent, but no server "
                f"of {missing} was found within {FIND_WAIT_S:g} s"
            )
            return False
        executor.spin_once(timeout_sec=WAIT_S)
    for goal in goals:
        if isinstance(goal.goal_client, RosGoalClient):
            goal.goal_client.ask_again(goal)
    return True
