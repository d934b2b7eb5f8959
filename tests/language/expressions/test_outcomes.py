"""What a condition can come to where the numbers in it lie in ranges."""

import math

import pytest

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.outcomes import ANYTHING, outcomes, range_of
from bt_mission.language.expressions.syntax import Name

RANGES = {"angle": (0.0, 90.0), "left": (-5.0, 5.0), "count": (3.0, 3.0), "gap": (0.0, math.inf)}


def find(name):
    """Return the range of a name; of other parts none is known."""
    return RANGES.get(name.name) if isinstance(name, Name) else None


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("angle > 90", {False}),
        ("angle >= 90", {True, False}),
        ("angle >= 0", {True}),
        ("angle < 0", {False}),
        ("0 <= angle <= 90", {True}),
        ("angle == 91", {False}),
        ("angle != 91", {True}),
        ("count == 3", {True}),
        ("not angle > 90", {True}),
        ("angle > 90 or left > 6", {False}),
        ("angle > 90 or left > 4", {True, False}),
        ("angle >= 0 and left > 6", {False}),
        ("angle > 90 and unknown > 1", {False}),
        ("unknown > 1", {True, False}),
        ("angle * 2 + 1 > 181", {False}),
        ("abs(left) > 5", {False}),
        ("-left > 5", {False}),
        ("max(angle, left) > 90", {False}),
        ("min(angle, left) > 5", {False}),
        ("gap - gap > 1", {True, False}),
        ("sqrt(angle) > 100", {True, False}),
        ("unknown == 'red'", {True, False}),
        ("unknown == true", {True, False}),
        ("true", {True}),
        ("unknown", {True, False}),
        ("uniform(0, 1) > 2", {True, False}),
    ],
)
def test_a_condition_in_ranges(text, expected):
    """Only what is certain is left out."""
    assert outcomes(Expression(text).root, find) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("angle - left", (-5.0, 95.0)),
        ("abs(left)", (0.0, 5.0)),
        ("abs(angle + 1)", (1.0, 91.0)),
        ("'red'", ANYTHING),
        ("angle / 2", ANYTHING),
    ],
)
def test_a_number_in_ranges(text, expected):
    """From where to where."""
    assert range_of(Expression(text).root, find) == expected
