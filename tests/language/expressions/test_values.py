"""Types of values, and values in words."""

import math

import pytest

from bt_mission.language.expressions.values import (
    ExpressionError,
    bounded,
    fits,
    mismatch,
    show,
    type_of,
)


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (True, "bool"),
        (1, "integer"),
        (1.0, "number"),
        ("", "text"),
        ([], "list"),
        ((), "list"),
        ({}, None),
        (None, None),
    ],
)
def test_types_of_values(value, kind):
    """Truth is no number; a mapping has no type."""
    assert type_of(value) == kind


def test_an_integer_fits_where_a_number_is_wanted_and_not_the_reverse():
    """And what is not known fits anywhere."""
    assert fits("integer", "number")
    assert not fits("number", "integer")
    assert not fits("bool", "number")
    assert fits(None, "text")


@pytest.mark.parametrize(
    ("value", "text"),
    [(True, "true"), (2, "2"), (1 / 3, "0.333333"), ([1, "a"], "1, a"), (2.0, "2"), ("x", "x")],
)
def test_values_are_shown_briefly(value, text):
    """As a log line wants them."""
    assert show(value) == text


def test_only_results_of_finite_numbers_must_be_finite():
    """Infinity goes through where it came in."""
    assert bounded(math.inf, 1, was_finite=False) == math.inf
    with pytest.raises(ExpressionError, match="too large"):
        bounded(math.inf, 1, was_finite=True)
    with pytest.raises(ExpressionError, match="not a number"):
        bounded(math.nan, 1, was_finite=True)


def test_a_mismatch_says_what_was_there():
    """The value itself where it is short, its kind where it is not."""
    assert mismatch(True, "number", 3).message == "expected a number, got true"
    assert mismatch("x", "number", 3).message == "expected a number, got string 'x'"
    assert mismatch([1, 2], "bool", 3).message == "expected a boolean, got a list of 2"
    assert mismatch({"a": 1}, "text", 3).message == "expected a string, got a value"


def test_an_error_prints_with_hint_and_column():
    """Where it is not located in a file."""
    assert str(ExpressionError("wrong", 4, "write 'x'")) == "wrong; write 'x' (column 4)"
