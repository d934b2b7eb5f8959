"""Facts about the checks of goal fields, and of what is good enough to drive by."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from action_servers.core.checks import refusal, stale
from action_servers.core.error_codes import ErrorCode
from action_servers.core.limits import outside
from action_servers.core.maneuver import Finished, Observation, Refusal
from bt_mission.core.geometry import Pose2D


@pytest.mark.parametrize("value", [0.05, 1.0, 1.82, float(np.float32(1.82))])
def test_both_limits_belong_to_the_range(value):
    """As float32 rounds them, too."""
    assert outside("speed", value, 0.05, 1.82, "rad/s") is None


@pytest.mark.parametrize("value", [0.049, 1.8201, math.nan, math.inf, -math.inf, 1e300])
def test_what_is_outside_is_told_with_limits_and_unit(value):
    """Expected and got, in one line."""
    assert outside("speed", value, 0.05, 1.82, "rad/s") == (
        f"speed must be from 0.05 to 1.82 rad/s, got {value:g}"
    )


def test_the_first_fault_is_told():
    """Then what is not ready; None when nothing is wrong."""
    unready = Finished("aborted", reason="no scan")
    assert refusal(None, "a", "b", unready=unready) == Refusal("a")
    assert refusal(None, None, unready=unready) == Refusal("no scan")
    assert refusal(None, None) is None


def seen(make_scan: Any, *, odometry_s: float, scan_s: float) -> Observation:
    """An observation at 10 s with sensors of some age."""
    return Observation(
        10.0,
        odom=Pose2D(0.0, 0.0, 0.0),
        odom_stamp_s=odometry_s,
        scan=make_scan([1.0], stamp_s=scan_s),
    )


@pytest.mark.parametrize("stamp", [9.0, 10.0, 10.9])
def test_a_second_is_fresh(make_scan, stamp):
    """Either way: clocks of two machines differ a little."""
    assert stale(seen(make_scan, odometry_s=stamp, scan_s=stamp)) is None


def test_odometry_is_told_first(make_scan):
    """One reason at a time."""
    assert stale(seen(make_scan, odometry_s=8.9, scan_s=8.9)) == Finished(
        "aborted", ErrorCode.NO_ODOMETRY, "no odometry for 1 s: the last is 1.10 s old"
    )


def test_a_scan_has_a_code_of_its_own(make_scan):
    """902."""
    assert stale(seen(make_scan, odometry_s=10.0, scan_s=8.9)) == Finished(
        "aborted", ErrorCode.NO_SCAN, "no scan for 1 s: the last is 1.10 s old"
    )


def test_nothing_at_all_is_told_as_that():
    """A robot that is not running is the usual case."""
    assert stale(Observation(10.0)) == Finished(
        "aborted",
        ErrorCode.NO_ODOMETRY,
        "no odometry has arrived yet; is the robot running?",
    )
