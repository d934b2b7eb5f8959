"""Why a goal was rejected: its server says so on another way than the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from rcl_interfaces.msg import Log

TURN = "mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 9\n"
LOOP = """\
mission: m
tree:
  retry: {attempts: 2}
  do: {turn: {angle: 90}, timeout: 9}
"""


@pytest.fixture
def warn(ros: Any) -> Callable[[str, str], None]:
    """Somebody warns."""
    publisher = ros.client.create_publisher(Log, "/rosout", 10)
    return lambda name, text: publisher.publish(Log(level=Log.WARN, name=name, msg=text))


def test_the_reason_reaches_the_leaf(ros: Any, warn: Callable[[str, str], None]) -> None:
    """That of its own server, at the tick that hears of the rejection."""
    server = ros.server(accepts=None)
    node = ros.mission(TURN)
    began = ros.until(lambda: server.goals)
    warn("other", "not mine")
    warn("turn_server.turn", "goal rejected: angle: too\x1b[31m large")
    server.goal.reject()
    ended = ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: angle: too\x1b[31m large"
    assert ended - began == pytest.approx(0.05)


def test_words_may_come_after_the_answer(ros: Any, warn: Callable[[str, str], None]) -> None:
    """Until the leaf is ticked."""
    server = ros.server(accepts=None)
    node = ros.mission(TURN)
    ros.until(lambda: server.goals)
    server.goal.reject()
    ros.run(0.0)
    warn("turn_server", "not today")
    ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: not today"


def test_words_of_before_the_goal_do_not_count(ros: Any, warn: Callable[[str, str], None]) -> None:
    """A server that gives no reason is said to have given none."""
    server = ros.server(accepts=None)
    node = ros.mission(LOOP)
    ros.until(lambda: server.goals)
    warn("turn_server", "not today")
    server.goal.reject()
    ros.until(lambda: len(server.goals) == 2)
    assert "rejected: /turn: not today" in [change.message for change in ros.changes]
    server.goal.reject()
    ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: its server gave no reason"
