"""The strictness of expressions: what Python lets pass and we do not."""

import math
import random
from typing import Any

import pytest

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.values import ExpressionError

KINDS: dict[str, Any] = {
    "i": "integer",
    "x": "number",
    "t": "bool",
    "s": "text",
    "l": "list",
    "u": None,
}
VALUES: dict[str, Any] = {"i": 2, "x": 0.5, "t": True, "s": "word", "l": [1, 2], "u": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 + t", "expected a number, got a boolean"),
        ("-s", "expected a number, got a string"),
        ("s + s", "expected a number, got a string"),
        ("i and t", "expected a boolean, got an integer"),
        ("x or t", "expected a boolean, got a number"),
        ("not i", "expected a boolean, got an integer"),
        ("i == s", "cannot compare an integer with a string"),
        ("t == 1", "cannot compare a boolean with an integer"),
        ("s < s", "'<' compares numbers, got a string"),
        ("t <= t", "'<=' compares numbers, got a boolean"),
        ("sqrt(s)", "expected a number, got a string"),
        ("len(x)", "expected a list, got a number"),
    ],
)
def test_types_are_kept_apart_before_and_during_the_run(text, message):
    """What is refused at loading would fail in the run as well."""
    expression = Expression(text)
    with pytest.raises(ExpressionError) as caught:
        expression.infer(lambda name: KINDS[name.name])
    assert caught.value.message == message
    with pytest.raises(ExpressionError):
        expression.evaluate(VALUES, random.Random(0))


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("i + 1", "integer"),
        ("i + x", "number"),
        ("i / 2", "number"),
        ("i // 2", "integer"),
        ("-i % 3", "integer"),
        ("2 ** 3", "integer"),
        ("2 ** i", None),
        ("2 ** x", "number"),
        ("round(x)", "integer"),
        ("round(x, 1)", "number"),
        ("floor(x) + sign(x)", "integer"),
        ("max(i, 2)", "integer"),
        ("max(i, x)", "number"),
        ("max(i, u)", None),
        ("u + 1", None),
        ("u / 1", "number"),
        ("i > x", "bool"),
        ("u and t", "bool"),
        ("not u", "bool"),
        ("s == 'a'", "bool"),
        ("choice('a', s)", "text"),
        ("choice(1, s)", None),
        ("choice(l)", None),
        ("len(l)", "integer"),
        ("pi", "number"),
        ("'x'", "text"),
        ("true", "bool"),
    ],
)
def test_types_are_inferred(text, kind):
    """As far as they are known; None is no promise."""
    assert Expression(text).infer(lambda name: KINDS[name.name]) == kind


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 / 0", "division by zero"),
        ("1 // 0", "division by zero"),
        ("1 % 0", "division by zero"),
        ("0 ** -1", "division by zero"),
        ("(-8) ** 0.5", "the result is not a number"),
        ("1e308 * 10", "the result is too large"),
        ("2 ** 64 + 1", "the result is too large"),
        ("sqrt(-1)", "sqrt: the result is not a number"),
        ("clamp(1, 3, 2)", "clamp: the lower limit 3 is above the upper limit 2"),
        ("choice(none)", "choice: nothing to choose from"),
        ("levy(0, 1)", "levy: expected 0 < shortest <= longest, got 0 and 1"),
    ],
)
def test_what_has_no_value_is_an_error_with_a_column(text, message):
    """Never nan or infinity out of finite numbers."""
    with pytest.raises(ExpressionError) as caught:
        Expression(text).evaluate({"none": []}, random.Random(0))
    assert caught.value.message == message


def test_infinite_readings_can_be_compared():
    """A lidar that sees nothing says infinity; that is no error of the mission."""
    expression = Expression("min(distance, 3.5) < 1 or distance - 1 > 2")
    assert expression.evaluate({"distance": math.inf}, random.Random(0)) is True


def test_the_second_side_is_looked_at_only_where_it_matters():
    """As in Python, so that a guard can stand before a division."""
    expression = Expression("n != 0 and 1 / n > 0.1")
    assert expression.evaluate({"n": 0}, random.Random(0)) is False


def test_a_value_of_no_known_type_cannot_be_used():
    """A nested message is no number."""
    with pytest.raises(ExpressionError, match="expected a number, got a value"):
        Expression("1 + pose").evaluate({"pose": {"x": 1}}, random.Random(0))
