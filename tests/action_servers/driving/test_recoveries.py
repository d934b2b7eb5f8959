"""Facts about what Nav2's recoveries have in common."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from nav2_msgs.action import BackUp, DriveOnHeading, Spin

from action_servers.core.error_codes import BACK_UP, DRIVE_ON_HEADING, SPIN, ErrorCode
from action_servers.core.maneuver import Finished, Observation
from action_servers.driving.recoveries import Allowance, seconds_of


@pytest.mark.parametrize(
    ("codes", "result"),
    [(SPIN, Spin.Result), (BACK_UP, BackUp.Result), (DRIVE_ON_HEADING, DriveOnHeading.Result)],
)
def test_codes_are_those_of_the_interfaces(codes, result):
    """By name and number; Spin has no INVALID_INPUT."""
    for name in ("unknown", "timeout", "tf_error", "collision_ahead", "invalid_input"):
        assert getattr(codes, name) == getattr(result, name.upper(), 0)


@pytest.mark.parametrize(
    ("ours", "nav2"),
    [
        (ErrorCode.NONE, 0),
        (ErrorCode.NO_ODOMETRY, 722),
        (ErrorCode.BLOCKED, 723),
        (ErrorCode.NO_SCAN, 720),
    ],
)
def test_our_codes_become_nav2s(ours, nav2):
    """Each has one; what Nav2 has no number for is unknown."""
    assert DRIVE_ON_HEADING.of(ours) == nav2


def test_an_allowance_that_is_used_up_ends_the_goal():
    """At the time itself it is not yet used up."""
    allowance = Allowance(2.0, SPIN)
    assert allowance.late(Observation(10.0)) is None
    assert allowance.late(Observation(12.0)) is None
    assert allowance.late(Observation(12.05)) == Finished(
        "aborted", 701, "the time allowance of 2 s is used up"
    )
    assert allowance.elapsed_s == pytest.approx(2.05)


def test_an_allowance_of_nothing_is_no_limit():
    """As in Nav2."""
    allowance = Allowance(0.0, SPIN)
    assert [allowance.late(Observation(time)) for time in (10.0, 1e6)] == [None, None]


def test_durations():
    """Nanoseconds count upwards, also below zero."""
    assert seconds_of(SimpleNamespace(sec=1, nanosec=500_000_000)) == 1.5
    assert seconds_of(SimpleNamespace(sec=-1, nanosec=500_000_000)) == -0.5
