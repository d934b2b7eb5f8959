"""``bt-mission actions cancel`` and ``watch``: goals that others have sent."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.task import Future

from bt_mission.commands.graph import action_goals
from bt_mission.commands.graph.action_goals import GoalWatch
from bt_mission.commands.graph.goal_views import GoalObjects
from bt_mission.executive.goals.goal import NO_CALLBACK
from tests.support.graph import TURN


class Robot:
    """A server of rclpy's own, whose goals last until they are cancelled or ended."""

    def __init__(self, ros: Any, *, cancels: bool = True) -> None:
        self.goals: list[Any] = []
        self.ends: list[Future] = []
        answer = CancelResponse.ACCEPT if cancels else CancelResponse.REJECT
        self.node = ros.node("robot")
        self.server = ActionServer(
            self.node, Turn, "turn", self._execute, cancel_callback=lambda _: answer
        )
        self.client = ActionClient(ros.client, Turn, "turn")

    def send(self) -> None:
        self.client.send_goal_async(Turn.Goal(angle=9.0))

    def end(self) -> None:
        self.goals[-1].succeed()
        self.ends[-1].set_result(None)

    async def _execute(self, goal: Any) -> Any:
        self.goals.append(goal)
        end = Future()
        self.ends.append(end)
        self.node.create_timer(0.1, lambda: self._look(goal, end))
        await end
        return Turn.Result()

    def _look(self, goal: Any, end: Future) -> None:
        if goal.is_cancel_requested and not end.done():
            goal.canceled()
            end.set_result(None)

    @property
    def ids(self) -> list[str]:
        return [bytes(goal.goal_id.uuid).hex() for goal in self.goals]


@pytest.fixture
def robot(ros: Any, hand: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Robot]]:
    """Make a robot with so many goals under way."""
    made: list[Robot] = []

    def make(goals: int, **habits: Any) -> Robot:
        robot = Robot(ros, **habits)
        made.append(robot)
        ros.until(robot.client.server_is_ready)
        for _ in range(goals):
            robot.send()
        ros.until(lambda: len(robot.goals) == goals)
        return robot

    # What was said before comes by a thread of the middleware: it takes wall time, here at most
    # that of 1200 steps.
    monkeypatch.setattr(action_goals, "STATUS_WAIT_S", 60.0)
    hand.pauses = 1
    yield make
    for goal in made:
        goal.server.destroy()
        goal.client.destroy()


def test_all_goals_are_cancelled_and_waited_for(type_in: Any, robot: Callable[..., Robot]) -> None:
    """Whoever sent them; then there is none."""
    ids = robot(2).ids
    done = type_in("actions", "cancel", "/turn")
    assert done.code == 0
    assert sorted(done.lines) == sorted(f"goal {goal[:8]} canceled" for goal in ids)
    again = type_in("actions", "cancel", "/turn")
    assert (again.code, again.lines) == (0, ["no goal of /turn is running"])


def test_one_goal_is_meant_by_its_first_digits(type_in: Any, robot: Callable[..., Robot]) -> None:
    """The other goes on; digits of no goal are an error that names those under way."""
    first, second = robot(2).ids
    done = type_in("actions", "cancel", "/turn", first[:6])
    assert (done.code, done.lines) == (0, [f"goal {first[:8]} canceled"])
    again = type_in("actions", "cancel", "/turn", first)
    assert (again.code, again.lines) == (0, [f"goal {first[:8]} has ended"])
    wrong = type_in("actions", "cancel", "/turn", "ffffff0")
    assert wrong.code == 2
    assert f"no goal has an id that begins with ffffff0 (running: {second[:8]})" in wrong.err
    assert "expected hexadecimal digits" in type_in("actions", "cancel", "/turn", "xyz").err


def test_a_refusal_exits_with_3(type_in: Any, robot: Callable[..., Robot]) -> None:
    """And names the goal."""
    (goal,) = robot(1, cancels=False).ids
    done = type_in("actions", "cancel", "/turn")
    assert (done.code, done.lines) == (
        3,
        [f"goal {goal[:8]}: the server refused to cancel{NO_CALLBACK}"],
    )


def test_an_action_without_a_server_has_nothing_to_cancel(type_in: Any, ros: Any) -> None:
    """Its name is looked for as by send."""
    done = type_in("actions", "cancel", "/turn", "--wait", "1")
    assert done.code == 5
    assert "no action /turn in the graph (looked for 1 s); there is no action" in done.err


def test_watching_shows_states_and_feedback(
    ros: Any, hand: Any, type_in: Any, robot: Callable[..., Robot]
) -> None:
    """Of every goal, feedback where it has changed, until Ctrl-C."""
    turning = robot(0)

    def feed() -> None:
        turning.goals[-1].publish_feedback(Turn.Feedback(current_angle=4.0))

    start_s = ros.now_s
    for at_s, move in (
        (0.5, turning.send),
        (1.0, feed),
        (1.1, feed),
        (2.0, turning.end),
        (3.0, hand.press_ctrl_c),
    ):
        hand.at(start_s + at_s, move)
    done = type_in("actions", "watch", "/turn")
    (goal,) = turning.ids
    assert done.code == 130
    assert [line[:8] for line in done.lines] == [goal[:8]] * len(done.lines)
    assert [line.partition(" s  ")[2] for line in done.lines if "accepted" not in line] == [
        "executing",
        "current_angle 4 deg, remaining_angle 0 deg",
        "succeeded",
    ]


def test_goals_under_way_are_told_to_those_who_come_later(
    hand: Any, robot: Callable[..., Robot]
) -> None:
    """For programs: an object a line, a state or a feedback, with the goal's whole id."""
    turning = robot(2)
    out = io.StringIO()
    view = GoalObjects(out)
    goals = GoalWatch(hand, "/turn", TURN)

    def step() -> None:
        hand.step()
        for event in goals.take():
            view.show(event)

    for _ in range(2000):
        step()
        if out.getvalue():
            break
    turning.goals[0].publish_feedback(Turn.Feedback(current_angle=4.0))
    step()
    objects = [json.loads(line) for line in out.getvalue().splitlines()]
    assert objects == [
        *({"goal": goal, "state": "executing", "is_end": False} for goal in turning.ids),
        {"goal": turning.ids[0], "feedback": {"current_angle": 4.0, "remaining_angle": 0.0}},
    ]
