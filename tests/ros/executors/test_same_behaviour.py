"""Nodes behave under our executors as under rclpy's own.

Each behaviour is played under all, and what each who took part did and saw is compared, with
simulated times. What an executor is free to choose (the order between nodes, and between what is
ready of different kinds) is not; and what ours does otherwise on purpose stands at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import getmembers, isfunction
from types import ModuleType

import pytest
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer
from rclpy.task import Future
from std_msgs.msg import Int64

from tests.support.behaviours import (
    actions,
    coroutines,
    groups,
    guards,
    nodes,
    services,
    timers,
    topics,
)
from tests.support.thorough import sample
from tests.support.two_executors import LivePlay, LockstepPlay, Play, StockPlay, perform

Behaviour = Callable[[Play], None]


def behaviours(module: ModuleType) -> list[Behaviour]:
    """The public functions of a module that play something."""
    return [
        function
        for name, function in getmembers(module, isfunction)
        if list(function.__annotations__) == ["play", "return"] and not name.startswith("_")
    ]


ALL = [
    pytest.param(behaviour, id=behaviour.__name__)
    for module in (timers, topics, services, actions, coroutines, guards, groups, nodes)
    for behaviour in behaviours(module)
]


@pytest.mark.parametrize("behaviour", sample(ALL, 4))
def test_it_is_as_under_rclpys_own_executor(behaviour: Behaviour) -> None:
    """The same happens to everybody, at the same simulated times."""
    expected = perform(behaviour, StockPlay)
    assert expected
    assert perform(behaviour, LockstepPlay) == expected
    assert perform(behaviour, LivePlay) == expected


# ---- what ours does otherwise, on purpose ------------------------------------------------


def a_timer_and_a_message(play: Play) -> None:
    """Of one node, at one instant."""
    node = play.node("a")
    publisher = node.create_publisher(Int64, "count", 10)
    node.create_subscription(Int64, "count", play.hear("a"), 10)
    node.create_timer(0.1, lambda: publisher.publish(Int64(data=1)))
    node.create_timer(0.1, lambda: play.say("a", "timer"))
    play.advance(0.1)


def test_ours_serves_each_timers_messages_before_the_next_timer() -> None:
    """Under rclpy's own, timers that are ready together come before messages."""
    assert perform(a_timer_and_a_message, LockstepPlay) == {"a": ["1", "timer"]}
    assert perform(a_timer_and_a_message, StockPlay) == {"a": ["timer", "1"]}


def tasks_that_wait_for_one_gate(play: Play) -> None:
    """Three, begun one after the other."""
    gate: Future = Future()

    async def wait(name: str) -> None:
        await gate
        play.say("order", name)

    for name in ("one", "two", "three"):
        play.executor.create_task(wait(name))
    play.settle()
    gate.set_result(None)
    play.settle()


def test_ours_resumes_tasks_in_the_order_of_their_start() -> None:
    """Rclpy's resumes the latest first."""
    order = ["one", "two", "three"]
    assert perform(tasks_that_wait_for_one_gate, LockstepPlay) == {"order": order}
    assert perform(tasks_that_wait_for_one_gate, StockPlay) == {"order": order[::-1]}


def an_action_that_outlives_its_node(play: Play) -> None:
    """The node is destroyed, and its action server is not."""
    node, other = play.node("a"), play.node("b")
    ActionServer(node, Turn, "turn", lambda handle: Turn.Result())
    client = ActionClient(other, Turn, "turn")
    play.settle()
    node.destroy_node()
    sent = client.send_goal_async(Turn.Goal())
    play.settle()
    play.say("client", sent.done())


def test_ours_does_not_serve_the_actions_of_a_destroyed_node() -> None:
    """Rclpy's goes on with them, as long as they are in somebody's memory."""
    assert perform(an_action_that_outlives_its_node, LockstepPlay) == {"client": ["False"]}
    assert perform(an_action_that_outlives_its_node, StockPlay) == {"client": ["True"]}


def a_removed_node_that_comes_back(play: Play) -> None:
    """After seven periods of its timer and a half."""
    node = play.node("a")
    node.create_timer(0.1, lambda: play.say("a", play.ms(node)))
    play.executor.remove_node(node)
    play.advance(0.75)
    play.executor.add_node(node)
    play.advance(0.25)


def test_ours_starts_the_timers_of_a_node_that_is_added_anew() -> None:
    """They may come from another clock; rclpy's keep their phase, and one fires at once."""
    assert perform(a_removed_node_that_comes_back, LockstepPlay) == {"a": ["850", "950"]}
    assert perform(a_removed_node_that_comes_back, StockPlay) == {
        "a": ["750", "800", "900", "1000"]
    }
