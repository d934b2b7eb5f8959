"""Facts about poses on the floor."""

import math
from types import SimpleNamespace

import pytest

from bt_mission.base.geometry import (
    Pose2D,
    between,
    composed,
    distance,
    relative,
    set_planar,
    wrap,
    yaw_of,
)


def test_wrapped_angles_lie_within_half_a_turn():
    """Half a turn and a bit to the left is a bit less than half a turn to the right."""
    assert wrap(math.pi + 0.1) == pytest.approx(-math.pi + 0.1)
    assert wrap(-5 * math.tau + 0.2) == pytest.approx(0.2)


def test_relative_undoes_composed():
    """A pose seen from another, put back, is the pose."""
    outer, inner = Pose2D(1.0, -2.0, 2.5), Pose2D(0.3, 0.4, 1.5)
    back = relative(outer, composed(outer, inner))
    assert (back.x, back.y, back.yaw) == pytest.approx((0.3, 0.4, 1.5))
    assert distance(outer, composed(outer, inner)) == pytest.approx(0.5)


def test_between_turns_the_short_way_round():
    """From 170 to -170 degrees it goes over 180, not over 0."""
    middle = between(Pose2D(0.0, 0.0, math.radians(170)), Pose2D(1.0, 2.0, math.radians(-170)), 0.5)
    assert (middle.x, middle.y) == (0.5, 1.0)
    assert abs(middle.yaw) == pytest.approx(math.pi)


def test_a_yaw_that_is_set_is_read_again():
    """Also from a quaternion that is twice as long as it should be."""
    place, rotation = SimpleNamespace(x=0.0, y=0.0), SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    set_planar(place, rotation, Pose2D(1.0, -2.0, 2.5))
    assert (place.x, place.y, yaw_of(rotation)) == pytest.approx((1.0, -2.0, 2.5))
    rotation.z, rotation.w = 2.0 * rotation.z, 2.0 * rotation.w
    assert yaw_of(rotation) == pytest.approx(2.5)


def test_a_quaternion_beyond_all_numbers_has_no_angle():
    """It is skipped like an invalid one, and the reader continues."""
    rotation = SimpleNamespace(x=0.0, y=0.0, z=1e200, w=1e200)
    assert math.isnan(yaw_of(rotation))
