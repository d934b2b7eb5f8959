"""Angles that are in the other unit, by their look."""

import math

import pytest

from bt_mission.sessions.goal_checks import is_like_radians


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [
        (math.pi / 2, True),
        (-1.5708, True),
        (0.0, False),
        (0.001, False),
        (3.0, False),
        (90.0, False),
    ],
)
def test_a_usual_angle_in_radians_is_no_number_of_degrees(degrees, expected):
    """Zero and whole numbers are usual in degrees, too."""
    assert is_like_radians(degrees) is expected
