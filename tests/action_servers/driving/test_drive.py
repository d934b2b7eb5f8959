"""Facts about the way of every driving maneuver, and about driving and measuring for a time."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from action_servers.core.drive_limits import speed_to_stop_in
from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Held, Observation, Reason
from action_servers.driving.drive import Drive
from action_servers.driving.move import Move, plan
from action_servers.driving.record_distance import RecordDistance
from bt_mission.base.geometry import Pose2D, Twist2D

FORWARD = Twist2D(0.2, 0.0)


@pytest.mark.parametrize(
    ("held", "end"),
    [
        (Held(Reason.BASE, "blocked", Twist2D(0.2, 0.0), 10.0), "blocked"),
        (Held(Reason.OBSTACLE, "a wall", ZERO, 8.0), "a wall, for 2 s"),
        (Held(Reason.OBSTACLE, "a wall", ZERO, 8.05), None),
        (Held(Reason.OBSTACLE, "a wall", Twist2D(0.1, 0.0), 0.0), None),
        (Held(Reason.MOVING, "a robot", ZERO, 0.0), None),
        (Held(Reason.EXECUTIVE, "late", ZERO, 0.0), None),
    ],
)
def test_it_ends_where_the_base_does_not_follow_or_stands_for_long(fake, waffle, held, end):
    """For 2 s before an obstacle; not while it gives way, or somebody holds it."""
    now = dataclasses.replace(fake(waffle).observe(), held=held)
    expected = None if end is None else Finished("aborted", ErrorCode.BLOCKED, end)
    assert Drive(waffle).fault(now) == expected


def test_rests_until_odometry_says_that_it_stands(fake, waffle):
    """Zero is commanded meanwhile."""
    base, drive = fake(waffle), Drive(waffle)
    base.linear = 0.2
    steps = 0
    while drive.rest(base.observe()) == ZERO:
        base.move(ZERO)
        steps += 1
    assert steps == 4
    assert base.linear == pytest.approx(0.0, abs=1e-9)


def test_does_not_wait_for_ever_for_a_base_to_stand(waffle):
    """Odometry without velocities ends the wait after a second."""
    drive: Any = Drive(waffle)
    assert drive.rest(Observation(5.0)) == ZERO
    assert drive.rest(Observation(5.95)) == ZERO
    assert drive.rest(Observation(6.0)) is None


def test_each_rest_has_its_own_second(waffle):
    """Between two of them a speed was asked for."""
    drive: Any = Drive(waffle)
    assert drive.rest(Observation(5.0)) == ZERO
    assert drive.speed_ahead(Observation(5.5, odom_stamp_s=5.5), 1.0, 0.2) == 0.2
    assert drive.rest(Observation(6.0)) == ZERO


def test_the_delay_of_a_command_counts_the_age_of_odometry(waffle):
    """One control step, and what has passed since the odometry."""
    now = Observation(5.0, odom_stamp_s=4.98)
    deceleration = 0.5 * waffle.max_linear_acceleration
    expected = speed_to_stop_in(0.05, deceleration=deceleration, delay_s=0.07)
    assert Drive(waffle).speed_ahead(now, 0.05, 1.0) == pytest.approx(expected)


def reported(base, maneuver, seconds, command=None):
    """Step a maneuver; return when it told what, and its end. `command` drives the base instead."""
    reports = []
    for _ in range(round(seconds * 20) + 1):
        time_s = round(base.time_s - 10.0, 6)
        answer = maneuver.step(base.observe()) if command else base.step(maneuver.step)
        feedback = maneuver.feedback()
        if feedback is not None:
            reports.append((time_s, *feedback.values()))
        if isinstance(answer, Finished):
            return reports, answer
        if command:
            base.move(command)
    return reports, None


def test_a_move_drives_for_exactly_the_time(fake, robot):
    """Five seconds are a hundred commands at 20 Hz; then it stops, and ends standing."""
    base = fake(robot)
    assert base.run(Move(5, FORWARD, robot)) == Finished("succeeded")
    assert base.twists.count(FORWARD) == 100
    assert set(base.twists[100:]) == {ZERO}
    assert base.linear < 0.01
    assert base.x == pytest.approx(1.0, abs=0.01)


def test_a_move_tells_each_second_and_in_the_end_what_it_did(fake, waffle):
    """Five times for five seconds."""
    move = Move(5, FORWARD, waffle)
    reports, _ = reported(fake(waffle), move, 6.0)
    assert [time for time, _ in reports] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert reports[1][1] == "driving, 2.00 of 5 s, 0.38 m so far"
    assert move.result() == {"status": "drove for 5.00 of 5 s, 1.00 m"}


def test_a_canceled_move_tells_what_it_did(fake, waffle):
    """Not what it was asked for."""
    move = Move(5, FORWARD, waffle)
    fake(waffle).run_for(move, 1.55)
    assert move.result() == {"status": "drove for 1.50 of 5 s, 0.28 m"}


def test_no_velocity_at_all_is_a_tenth_of_a_metre_a_second(fake, waffle):
    """Straight on."""
    now = fake(waffle).observe()
    goal = SimpleNamespace(secs=5, linear_velocity=0.0, angular_velocity=0.0)
    assert plan(goal, now, waffle).step(now) == Twist2D(0.1, 0.0)


def test_a_move_does_not_begin_where_there_is_no_room(fake, waffle):
    """Within the margin not a millimetre, and beyond it one slow step that keeps the margin."""
    for wall, most in ((0.105, 0.0), (0.12, 0.006)):
        base = fake(waffle, [(wall, -1.0, wall, 1.0)])
        ended = base.run(Move(5, FORWARD, waffle))
        assert (ended.status, ended.error_code) == ("aborted", ErrorCode.BLOCKED)
        assert "an obstacle is in the way" in ended.reason
        assert len(base.twists) == 2
        base.move(ZERO, 0.2)
        assert base.x <= most


def test_a_recorded_distance_is_told_and_published_each_second_and_ends_with_the_last(fake, waffle):
    """Five for five seconds; the sum is the path from odometry."""
    published: list[Any] = []
    base = fake(waffle)
    record = RecordDistance(5, waffle, published.append)
    reports, end = reported(base, record, 6.0, FORWARD)
    assert end == Finished("succeeded")
    assert [time for time, _ in reports] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert published == [{"data": distance} for _, distance in reports]
    assert reports[-1][1] == pytest.approx(base.x)
    assert record.result() == {"status": True, "total_dist": reports[-1][1]}


def test_before_the_end_the_status_of_a_record_is_false(fake, waffle):
    """A cancel has the distance so far."""
    record = RecordDistance(5, waffle, lambda _: None)
    reported(fake(waffle), record, 2.0, FORWARD)
    assert record.result() == {"status": False, "total_dist": pytest.approx(0.4, abs=0.03)}


def test_odometry_that_jumps_or_stops_ends_a_record(fake, waffle):
    """With the reason; what was measured until then stays."""
    base = fake(waffle)
    record: Any = RecordDistance(5, waffle, lambda _: None)
    reported(base, record, 1.0, FORWARD)
    base.changes = {"odom": Pose2D(9.0, 0.0, 0.0)}
    end = record.step(base.observe())
    assert end.error_code == ErrorCode.NO_ODOMETRY
    assert "odometry jumped by" in end.reason
    assert record.result()["total_dist"] == pytest.approx(0.2, abs=0.03)
    silent = RecordDistance(5, waffle, lambda _: None)
    assert silent.step(Observation(10.0)) == Finished(
        "aborted", ErrorCode.NO_ODOMETRY, "no odometry has arrived yet; is the robot running?"
    )
