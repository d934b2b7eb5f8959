"""One of two values, elements of lists, and the formats of numbers in texts."""

import random
from typing import Any

import pytest

from bt_mission.language.expressions.expression import Expression, Template
from bt_mission.language.expressions.outcomes import evaluate_constants
from bt_mission.language.expressions.values import ExpressionError, Type

NAMES: dict[str, Any] = {"n": 2, "x": 0.125, "word": "a", "none": [], "yes": True}
NAMES["list"] = [1, [2, 3], 4]
TYPES: dict[str, Type] = {"n": "integer", "x": "number", "word": "text", "yes": "bool"}
TYPES["list"] = "list"


def evaluate(text):
    """Return the value of an expression."""
    return Expression(text).evaluate(NAMES, random.Random(0))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 if n > 1 else 2", 1),
        ("1 if n > 2 else 2 if n > 1 else 3", 2),
        ("(1 if yes else 2) + 1", 2),
        ("1 + 1 if yes else 5", 2),
        ("1 / 0 if n > 9 else 7", 7),
        ("max(1 if yes else 2, 0)", 1),
        ("list[0]", 1),
        ("list[-1]", 4),
        ("list[n - 1][0]", 2),
        ("-list[2] ** 2", -16),
        ("list[0 if yes else 1]", 1),
        ("len(list[1])", 2),
    ],
)
def test_values(text, value):
    """As in Python."""
    assert evaluate(text) == value


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("list[3]", 6, "the list has 3 elements, none at 3"),
        ("list[-4]", 6, "the list has 3 elements, none at -4"),
        ("none[0]", 6, "the list has 0 elements, none at 0"),
        ("list[x]", 6, "expected an integer, got 0.125"),
        ("word[0]", 1, "expected a list, got string 'a'"),
        ("1 if n else 2", 6, "expected a boolean, got 2"),
        ("1 if yes", 9, "expected 'else' for the 'if' in 'if yes'"),
        ("list[0", 7, "expected ']' for the '[' in 'list[0'"),
        ("[0]", 1, "expected a number, a name or a '(', got '['"),
        ("if yes", 1, "expected a number, a name or a '(', got 'if'"),
        ("list[]", 6, "expected a number, a name or a '(', got ']'"),
    ],
)
def test_what_is_wrong_has_its_column(text, column, message):
    """When it is read, or when it is evaluated."""
    with pytest.raises(ExpressionError) as caught:
        evaluate(text)
    assert (caught.value.column, caught.value.message) == (column, message)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("1 if yes else 2", "integer"),
        ("1 if yes else x", "number"),
        ("word if yes else 'b'", "text"),
        ("list[0]", None),
        ("list[0] if yes else 1", None),
    ],
)
def test_types_are_known_where_both_values_agree(text, found):
    """Elements may have any type."""
    assert Expression(text).infer(lambda name: TYPES[name.name]) == found


def test_values_of_two_types_are_refused():
    """Where both are known."""
    with pytest.raises(ExpressionError, match="one value of 'if' is a string, the other one an i"):
        Expression("word if yes else n").infer(lambda name: TYPES[name.name])


@pytest.mark.parametrize(
    ("text", "is_refused"),
    [
        ("1 / 0 if n > 9 else 7", False),
        ("1 / 0 if n < 9 else 7", True),
        ("1 / 0 if later else 7", False),
        ("list[9] + later", True),
    ],
)
def test_what_is_not_selected_is_not_evaluated_before_the_run_either(text, is_refused):
    """Nor both values where the condition is not known yet."""
    try:
        evaluate_constants(Expression(text).root, NAMES, lambda name: name.name in NAMES)
    except ExpressionError:
        assert is_refused
    else:
        assert not is_refused


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("${x:.2f}", "0.12"),
        ("${n:03d} ${n}", "002 2"),
        ("${x:+.1e}", "+1.2e-01"),
        ("${x:.0%}", "12%"),
        ("${n:6.1f}|", "   2.0|"),
        ("${'a:b'}", "a:b"),
        ("${1 if yes else 2:.1f}", "1.0"),
    ],
)
def test_numbers_have_formats(text, filled):
    """As in Python."""
    assert Template(text).evaluate(NAMES, random.Random(0)) == filled


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("at ${x:.2z}", 8, "expected a number format such as '.2f' behind ':', got '.2z'"),
        ("at ${x:}", 8, "expected a number format such as '.2f' behind ':', got ''"),
        ("at ${x:999d}", 8, "expected a number format such as '.2f' behind ':', got '999d'"),
        ("at ${word:.2f}", 6, "expected a number, got string 'a'"),
        ("at ${x:d}", 6, "expected an integer, got 0.125"),
    ],
)
def test_a_format_that_does_not_fit_has_its_column(text, column, message):
    """In the whole text."""
    with pytest.raises(ExpressionError) as caught:
        Template(text).evaluate(NAMES, random.Random(0))
    assert (caught.value.column, caught.value.message) == (column, message)
