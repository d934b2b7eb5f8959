"""Facts about measuring a distance while somebody drives."""

from __future__ import annotations

import pytest

from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished, Observation
from action_servers.driving.record_distance import RecordDistance
from bt_mission.core.geometry import Pose2D, Twist2D


def drive(base, maneuver, seconds):
    """Drive on at 0.2 m/s meanwhile; what was told when, and the end."""
    reports = []
    for _ in range(round(seconds * 20) + 1):
        answer = maneuver.step(base.observe())
        feedback = maneuver.feedback()
        if feedback is not None:
            reports.append((round(base.time_s - 10.0, 6), feedback["current_dist"]))
        if isinstance(answer, Finished):
            return reports, answer
        base.move(Twist2D(0.2, 0.0))
    return reports, None


def test_it_tells_and_publishes_each_second_and_ends_with_the_last(fake, waffle):
    """Five for five seconds; the sum is the path from odometry."""
    published: list[float] = []
    base = fake(waffle)
    record = RecordDistance(5, waffle, published.append)
    reports, end = drive(base, record, 6.0)
    assert end == Finished("succeeded")
    assert [time for time, _ in reports] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert published == [distance for _, distance in reports]
    assert published[-1] == pytest.approx(base.x)
    assert record.result() == {"status": True, "total_dist": published[-1]}


def test_before_the_end_the_status_is_false(fake, waffle):
    """A cancel has the distance so far."""
    base = fake(waffle)
    record = RecordDistance(5, waffle, lambda _: None)
    drive(base, record, 2.0)
    result = record.result()
    assert result["status"] is False
    assert result["total_dist"] == pytest.approx(0.4, abs=0.03)


def test_odometry_that_jumps_or_stops_ends_it(fake, waffle):
    """With the reason; what was measured until then stays."""
    base = fake(waffle)
    record = RecordDistance(5, waffle, lambda _: None)
    drive(base, record, 1.0)
    base.changes = {"odom": Pose2D(9.0, 0.0, 0.0)}
    end = record.step(base.observe())
    assert isinstance(end, Finished)
    assert end.error_code == ErrorCode.NO_ODOMETRY
    assert "odometry jumped by" in end.reason
    silent = RecordDistance(5, waffle, lambda _: None)
    assert silent.step(Observation(10.0)) == Finished(
        "aborted", ErrorCode.NO_ODOMETRY, "no odometry has arrived yet; is the robot running?"
    )
