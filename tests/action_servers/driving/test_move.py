"""Facts about driving at a constant velocity for a time."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import ZERO, Finished
from action_servers.driving.move import Move, plan
from bt_mission.core.geometry import Twist2D


def goal(secs=5, linear=0.0, angular=0.0):
    """A goal of Move."""
    return SimpleNamespace(secs=secs, linear_velocity=linear, angular_velocity=angular)


def test_it_drives_for_exactly_the_time(fake, robot):
    """Five seconds are a hundred commands at 20 Hz; then it stops, and ends standing."""
    base = fake(robot)
    assert base.run(Move(5, Twist2D(0.2, 0.0), robot)) == Finished("succeeded")
    assert base.twists.count(Twist2D(0.2, 0.0)) == 100
    assert set(base.twists[100:]) == {ZERO}
    assert base.linear < 0.01
    assert base.x == pytest.approx(1.0, abs=0.01)


def test_feedback_comes_every_second_and_the_status_has_real_figures(fake, waffle):
    """Five for five seconds."""
    base = fake(waffle)
    move = Move(5, Twist2D(0.2, 0.0), waffle)
    reports = []
    for _ in range(120):
        time_s = base.time_s
        answer = base.step(move.step)
        feedback = move.feedback()
        if feedback is not None:
            reports.append((round(time_s - 10.0, 6), feedback["feedback"]))
        if isinstance(answer, Finished):
            break
    assert [time for time, _ in reports] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert reports[1][1] == "driving, 2.00 of 5 s, 0.38 m so far"
    assert move.result() == {"status": "drove for 5.00 of 5 s, 1.00 m"}


def test_a_canceled_move_tells_what_it_did(fake, waffle):
    """Not what it was asked for."""
    base = fake(waffle)
    move = Move(5, Twist2D(0.2, 0.0), waffle)
    base.run_for(move, 1.55)
    assert move.result() == {"status": "drove for 1.50 of 5 s, 0.28 m"}


def test_no_velocity_at_all_is_a_tenth_of_a_metre_a_second(fake, waffle):
    """Straight on."""
    move = plan(goal(), fake(waffle).observe(), waffle)
    assert isinstance(move, Move)
    assert move.step(fake(waffle).observe()) == Twist2D(0.1, 0.0)


@pytest.mark.parametrize(
    ("twist", "wall"),
    [
        (Twist2D(0.2, 0.0), (1.0, -2.0, 1.0, 2.0)),
        (Twist2D(-0.2, 0.0), (-1.0, -2.0, -1.0, 2.0)),
        (Twist2D(0.2, 0.3), (0.6, -2.0, 0.6, 2.0)),
        (Twist2D(0.22, -0.2), (-2.0, -0.7, 2.0, -0.7)),
    ],
)
def test_it_ends_blocked_before_it_touches(fake, robot, twist, wall):
    """Forwards, backwards and along an arc; a gap of a few centimetres is left."""
    base = fake(robot, [wall])
    finished = base.run(Move(60, twist, robot))
    assert (finished.status, finished.error_code) == ("aborted", ErrorCode.BLOCKED)
    assert "an obstacle is in the way" in finished.reason
    while base.linear or base.angular:
        base.move(ZERO)
    gap = hull_gap(base, robot, wall)
    assert 0.01 <= gap <= 0.2


def hull_gap(base, robot, wall):
    """Distance of the hull's nearest corner to a wall along an axis, metres."""
    hull = robot.hull
    corners = [
        (along, across)
        for along in (hull.front, hull.rear)
        for across in (hull.half_width, -hull.half_width)
    ]
    cosine, sine = math.cos(base.yaw), math.sin(base.yaw)
    x = [base.x + cosine * along - sine * across for along, across in corners]
    y = [base.y + sine * along + cosine * across for along, across in corners]
    if wall[0] == wall[2]:
        return min(abs(wall[0] - value) for value in x)
    return min(abs(wall[1] - value) for value in y)


def test_it_does_not_begin_where_there_is_no_room(fake, waffle):
    """Within the margin not a millimetre, and beyond it one slow step that keeps the margin."""
    for wall, most in ((0.105, 0.0), (0.12, 0.006)):
        base = fake(waffle, [(wall, -1.0, wall, 1.0)])
        base.run(Move(5, Twist2D(0.2, 0.0), waffle))
        assert len(base.twists) == 2
        base.move(ZERO, 0.2)
        assert base.x <= most


def test_a_base_that_does_not_follow_ends_it(fake, waffle):
    """Within two seconds."""
    base = fake(waffle)
    base.stuck = True
    finished = base.run(Move(60, Twist2D(0.2, 0.0), waffle))
    assert finished.error_code == ErrorCode.BLOCKED
    assert "no progress for 2 s" in finished.reason
