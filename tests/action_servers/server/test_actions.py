"""Facts about single actions as their clients see them."""

from __future__ import annotations

from typing import Any

import pytest
from std_msgs.msg import Float64

from tests.support.served import goal


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
