"""Facts about actions as their clients see them, and about the adapter that serves each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bt_mission_interfaces.action import ExploreForward, Turn
from nav2_msgs.action import FollowWaypoints
from rclpy.parameter import Parameter
from std_msgs.msg import Float64

from action_servers.core.maneuver import ZERO, Finished, Observation
from action_servers.robot_io.adapter import SHOWN_CHARACTERS, Before, HookedManeuver, shown
from bt_mission.base.geometry import Twist2D
from sim.world.motion import Drifting
from tests.support.moving_robot import Mover
from tests.support.served import goal
from tests.support.thorough import sample


def test_the_distance_is_published_each_second_while_it_is_recorded(bench):
    """As feedback, too; then nothing more is published."""
    messages: list[Any] = []
    bench.clients[1].create_subscription(Float64, "total_distance", messages.append, 10)
    record = bench.send("record_distance", goal("record_distance", seconds=5))
    bench.send("move", client=1)
    bench.until(lambda: record.status is not None)
    assert record.status == "succeeded"
    assert len(record.feedback) == 5
    assert [message.data for message in messages] == [
        feedback.current_dist for feedback in record.feedback
    ]
    assert record.result.status is True
    assert record.result.total_dist == messages[-1].data == pytest.approx(0.5, abs=0.03)
    bench.steps(60)
    assert len(messages) == 5


def test_pictures_are_taken_while_the_robot_drives(bench):
    """One each second: jpeg, in the result as in the feedback."""
    taken = bench.send("take_pictures", goal("take_pictures", nseconds=3))
    move = bench.send("move", client=1)
    bench.until(lambda: taken.status is not None)
    assert (taken.status, move.status) == ("succeeded", None)
    assert len(taken.result.all_pictures) == 3
    assert [feedback.last_image for feedback in taken.feedback] == taken.result.all_pictures
    stamps = [image.header.stamp.sec for image in taken.result.all_pictures]
    assert stamps == [stamps[0], stamps[0] + 1, stamps[0] + 2]
    assert {image.format for image in taken.result.all_pictures} == {"jpeg"}


def test_an_invalid_recovery_does_not_end_what_drives(bench):
    """It is accepted and aborted, as in Nav2, beside the goal that runs."""
    turn = bench.send("turn")
    bench.steps(5)
    wrong = goal("drive_on_heading", speed=-0.1)
    sent = bench.send("drive_on_heading", wrong, client=1)
    bench.steps(3)
    assert (sent.accepted, sent.status) == (True, "aborted")
    assert sent.result.error_code == sent.result.INVALID_INPUT
    assert turn.status is None


def test_a_wait_is_as_long_as_it_says(bench):
    """With the time that has passed, to the nanosecond."""
    sent = bench.send("wait")
    bench.until(lambda: sent.status is not None)
    assert sent.status == "succeeded"
    elapsed = sent.result.total_elapsed_time
    assert (elapsed.sec, elapsed.nanosec) == (10, 0)


def test_a_goal_is_shown_in_one_line_and_a_long_one_is_cut(pose):
    """Every field with its value; a hundred waypoints do not fill the log."""
    assert shown(Turn.Goal(angle=0.2)) == "angle=0.2, angular_velocity=0.0"
    text = shown(FollowWaypoints.Goal(poses=[pose(1.0, 2.0)] * 100))
    assert len(text) == SHOWN_CHARACTERS + 3
    assert text.endswith("...")


def test_a_check_that_raises_rejects_the_goal_and_not_the_server(bench, monkeypatch):
    """Whatever a goal holds."""

    def broken(*_: Any, **__: Any) -> None:
        raise IndexError("list index out of range")

    with monkeypatch.context() as patch:
        patch.setattr("action_servers.core.action.faults", broken)
        bad = bench.send("turn")
        bench.steps(2)
    assert bad.accepted is False
    assert bench.commands == []
    sound = bench.send("turn")
    bench.steps(2)
    assert sound.accepted is True


def test_a_preparation_that_raises_ends_the_goal_and_not_the_server(bench, monkeypatch):
    """It has been accepted by then, so it is aborted with the cause; the robot does not move."""

    def broken(*_: Any) -> None:
        raise OSError("no more file handles")

    with monkeypatch.context() as patch:
        patch.setattr(bench.servers._sensors, "localization", broken)
        bad = bench.send("navigate_to_pose")
        bench.steps(2)
    assert (bad.accepted, bad.status) == (True, "aborted")
    assert bad.result.error_msg == "OSError: no more file handles"
    assert set(bench.commands) <= {ZERO}
    sound = bench.send("navigate_to_pose")
    bench.steps(5)
    assert (sound.accepted, sound.status) == (True, None)


def meet(bench: Any) -> Any:
    """Send it ahead, while a cylinder comes at it; return the goal 6 s later."""
    mover, start_s = Mover(Drifting((2.0, 0.0), (-0.3, 0.0))), bench.robot.fake.time_s
    wall = [(3.0, -3.0, 3.0, 3.0)]
    sent = bench.send(
        "explore_forward", ExploreForward.Goal(fwd_velocity=0.2, stopping_distance=0.3)
    )
    for _ in range(120):
        walls = [*wall, *mover.walls(bench.robot.fake.time_s - start_s)]
        bench.robot.fake.walls = np.array(walls)
        bench.steps(1)
    return sent


def test_the_result_says_that_it_gave_way(bench):
    """Also of a goal that is canceled; and the base backed off, or turned aside."""
    sent = meet(bench)
    assert any(twist.linear < 0.0 or twist.angular for twist in bench.commands)
    bench.cancel("explore_forward")
    bench.until(lambda: sent.result is not None)
    assert sent.result.error_msg.startswith("gave way ")
    assert bench.commands[-1] == ZERO


@pytest.mark.parametrize("name", sample(["give_way_time", "give_way_distance"], 2))
def test_a_parameter_turns_it_off(bench, name):
    """From the next goal on."""
    (set_it,) = bench.servers.set_parameters([Parameter(name, value=0.0)])
    assert set_it.successful
    sent = meet(bench)
    assert all(twist.linear >= 0.0 and not twist.angular for twist in bench.commands)
    bench.until(lambda: sent.result is not None)
    assert "gave way" not in sent.result.error_msg


class Counter:
    """Drives, and counts its steps."""

    needs_base = True

    def __init__(self) -> None:
        self.steps = 0

    def step(self, now: Observation) -> Twist2D:
        self.steps += 1
        return Twist2D(0.1)

    def feedback(self) -> Any:
        return {"steps": self.steps} if self.steps != 2 else None

    def result(self) -> Any:
        return {"steps": self.steps}


def test_hooks_are_asked_before_each_method_with_the_newest_feedback() -> None:
    """They may join and leave while the maneuver runs; what one gives before a step ends it."""
    asked: list[Any] = []

    def note(method: str, feedback: Any) -> None:
        asked.append((method, dict(feedback)))

    before: list[Before] = []
    maneuver = HookedManeuver(Counter(), before)
    assert maneuver.needs_base
    assert maneuver.step(Observation(0.0)) == Twist2D(0.1)
    before.append(note)
    assert maneuver.feedback() == {"steps": 1}
    maneuver.step(Observation(0.1))
    assert maneuver.feedback() is None
    assert maneuver.result() == {"steps": 2}
    assert asked == [
        ("feedback", {}),
        ("step", {"steps": 1}),
        ("feedback", {"steps": 1}),
        ("result", {"steps": 1}),
    ]
    before[:] = [lambda method, _: (906, "stuck") if method == "step" else None]
    assert maneuver.step(Observation(0.2)) == Finished("aborted", 906, "stuck")
    before.clear()
    assert maneuver.step(Observation(0.3)) == Twist2D(0.1)


def test_what_a_hook_raises_the_maneuver_raises() -> None:
    """As a fault in the maneuver's own code."""

    def fail(_method: str, _feedback: Any) -> None:
        raise KeyError("no such sensor")

    with pytest.raises(KeyError):
        HookedManeuver(Counter(), [fail]).step(Observation(0.0))
