"""The functions of expressions; those that Python has too are compared in test_against_python."""

import math
import random

import pytest

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.functions import FUNCTIONS
from bt_mission.language.expressions.values import ExpressionError


def value_of(text, seed=0, **names):
    """Evaluate an expression."""
    return Expression(text).evaluate(names, random.Random(seed))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("sign(-0.1)", -1),
        ("sign(0)", 0),
        ("sign(9)", 1),
        ("clamp(5, 1, 3)", 3),
        ("clamp(0.5, 1, 3)", 1),
        ("copysign(90, -0.0)", -90.0),
        ("len(items)", 3),
        ("round(2.345, 2)", 2.35),
        ("degrees(pi)", 180.0),
        ("tan(0)", 0.0),
    ],
)
def test_functions_compute(text, value):
    """One line each."""
    assert value_of(text, items=[1, 2, 3]) == value


@pytest.mark.parametrize("digits", ["-1000000000", "1e300", "401", "-401"])
def test_nothing_is_rounded_to_digits_without_end(digits):
    """Python would compute as large a power of ten."""
    with pytest.raises(ExpressionError, match="round: expected -400 to 400 digits, got"):
        value_of(f"round(5, {digits})")
    assert value_of("round(5, -400)") == 0


def draws(text, count=2000):
    """Evaluate an expression many times with one generator."""
    rng = random.Random(1)
    expression = Expression(text)
    return [expression.evaluate({}, rng) for _ in range(count)]


def test_uniform_stays_between_its_limits():
    """In either order."""
    assert all(60 <= x < 120 for x in draws("uniform(60, 120)"))
    assert all(-1 < x <= 1 for x in draws("uniform(1, -1)"))


def test_choice_takes_every_value():
    """And no other; the values may come as one list."""
    assert set(draws("choice('a', 'b', 'c')")) == {"a", "b", "c"}
    assert {value_of("choice(items)", seed, items=[1, 2]) for seed in range(20)} == {1, 2}


def test_levy_is_heavy_tailed_within_its_limits():
    """With density falling as 1/x^2, half of the steps are shorter than twice the shortest."""
    steps = draws("levy(0.1, 1000)", 4000)
    assert all(0.1 <= x <= 1000 for x in steps)
    assert math.isclose(sum(x < 0.2 for x in steps) / 4000, 0.5, abs_tol=0.03)
    assert math.isclose(sum(x > 1.0 for x in steps) / 4000, 0.1, abs_tol=0.02)


def test_every_function_says_how_it_is_used():
    """Messages and documentation show the usage, which begins with the name."""
    for name, function in FUNCTIONS.items():
        assert function.usage.startswith(f"{name}(")
        assert 1 <= function.least <= function.most
