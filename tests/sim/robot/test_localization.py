"""The place on the map that the simulator says: exact, or off as that of a particle filter."""

from __future__ import annotations

import math
import statistics
from itertools import pairwise

import pytest

from sim.robot.localization import Localization, LocalizationError

START_NS = 1_000_000_000


def drive(error, seconds=400, seed=1):
    """Drive straight on at 0.25 m/s; returns the error of the place on the map at each 0.1 s."""
    localization = Localization(error, seed, "")
    return [
        localization.map_to_odom(
            (step * 0.025, 0, 0), (step * 0.025, 0, 0), START_NS + step * 10**8
        )
        for step in range(seconds * 10)
    ]


def test_without_an_error_it_takes_odometry_to_the_truth():
    """Odometry's pose, seen through map to odom, is the true pose."""
    pose, odom = (1.0, 2.0, 0.7), (0.3, -0.4, -0.2)
    x, y, yaw = Localization(None, 1, "").map_to_odom(pose, odom, 0)
    assert x + math.cos(yaw) * odom[0] - math.sin(yaw) * odom[1] == pytest.approx(pose[0])
    assert y + math.sin(yaw) * odom[0] + math.cos(yaw) * odom[1] == pytest.approx(pose[1])
    assert yaw + odom[2] == pytest.approx(pose[2])


def test_between_updates_it_goes_by_odometry():
    """It changes once in 0.25 m, and while the robot stands not at all."""
    result = drive(LocalizationError(place=0.05), seconds=20)
    assert len(set(result)) == 20
    localization = Localization(LocalizationError(place=0.05, jumps=1.0, jump=1.0), 1, "")
    standing = {localization.map_to_odom((0, 0, 0), (0, 0, 0), step) for step in range(100)}
    assert len(standing) == 1
    turned = localization.map_to_odom((0, 0, 0.21), (0, 0, 0.21), 10**9)
    assert turned not in standing


def test_its_error_has_the_standard_deviation_that_is_said():
    """Over many updates."""
    places = drive(LocalizationError(place=0.05), seconds=4000)[::10]
    assert statistics.stdev(y for _, y, _ in places) == pytest.approx(0.05, rel=0.15)
    headings = drive(LocalizationError(yaw=0.03), seconds=4000)[::10]
    assert statistics.stdev(yaw for *_, yaw in headings) == pytest.approx(0.03, rel=0.15)


def test_it_jumps_as_often_as_is_said():
    """A jump of a metre stands out of an error of a millimetre."""
    error = LocalizationError(place=0.001, jumps=0.05, jump=1.0)
    result = drive(error, seconds=2000)
    steps = [math.dist(a[:2], b[:2]) for a, b in pairwise(result)]
    assert sum(length > 0.7 for length in steps) == pytest.approx(100, rel=0.3)


def test_it_follows_from_its_seed():
    """And begins again as at the start."""
    error = LocalizationError(place=0.05)
    assert drive(error) == drive(error)
    assert drive(error, seed=2) != drive(error)
    localization = Localization(error, 1, "")
    first = localization.map_to_odom((0, 0, 0), (0, 0, 0), 0)
    localization.map_to_odom((1, 0, 0), (1, 0, 0), 1)
    localization.restart()
    assert localization.map_to_odom((0, 0, 0), (0, 0, 0), 0) == first
