"""What our expressions say, Python says too: properties, with Python as the oracle."""

import math
import random
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.parser import MAX_LENGTH
from bt_mission.language.expressions.values import MAX_MAGNITUDE, ExpressionError

NAMES = {"a": 3, "b": -2.5, "c": 0, "d": 0.1}
FUNCTIONS = {
    "abs": abs,
    "min": min,
    "max": max,
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "atan2": math.atan2,
    "hypot": math.hypot,
    "floor": math.floor,
    "ceil": math.ceil,
    "round": round,
    "degrees": math.degrees,
    "radians": math.radians,
    "copysign": math.copysign,
}

numbers = st.one_of(
    st.integers(0, 20).map(str),
    st.floats(0, 50, allow_nan=False).map(lambda x: f"{x:.3f}"),
    st.sampled_from(sorted(NAMES)),
)


def _arithmetic(inner):
    binary = st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "//", "%", "**"]), inner)
    call = st.tuples(st.sampled_from(["abs", "sqrt", "sin", "cos", "floor", "round"]), inner)
    two = st.tuples(st.sampled_from(["min", "max", "atan2", "hypot", "copysign"]), inner, inner)
    return st.one_of(
        binary.map(" ".join),
        inner.map("-{}".format),
        inner.map("({})".format),
        call.map(lambda part: f"{part[0]}({part[1]})"),
        two.map(lambda part: f"{part[0]}({part[1]}, {part[2]})"),
    )


arithmetic = st.recursive(numbers, _arithmetic, max_leaves=8)
comparisons = st.lists(
    st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), min_size=1, max_size=3
).flatmap(
    lambda symbols: st.tuples(*[arithmetic] * (len(symbols) + 1)).map(
        lambda sides: (
            sides[0] + "".join(f" {s} {x}" for s, x in zip(symbols, sides[1:], strict=True))
        )
    )
)
conditions = st.recursive(
    comparisons,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["and", "or"]), inner).map(" ".join),
        inner.map("not {}".format),
        inner.map("({})".format),
    ),
    max_leaves=4,
)


def python(text):
    """Return what Python says: a value, or None for any error."""
    try:
        return eval(text, {"__builtins__": {}}, {**FUNCTIONS, **NAMES})  # noqa: S307 - the oracle
    except (ArithmeticError, ValueError, TypeError):
        return None


def ours(text):
    """Return what we say: a value, or None for any error."""
    try:
        return Expression(text).evaluate(NAMES, random.Random(0))
    except ExpressionError:
        return None


def is_bounded(value):
    """Whether a number is one that our expressions may reach."""
    if isinstance(value, complex) or value is None:
        return False
    return math.isfinite(value) and (not isinstance(value, int) or abs(value) <= MAX_MAGNITUDE)


@settings(max_examples=200)
@given(arithmetic)
@example("-2 ** 2")
@example("2 ** -1")
@example("2 ** 3 ** 2")
@example("7 // -2 + 7 % -2")
@example("- - 3")
@example("round(2.5) + round(-0.5)")
def test_arithmetic_is_pythons(text):
    """Same value and same type, wherever Python's value is within our bounds."""
    expected, got = python(text), ours(text)
    if got is None:
        # Refused: by Python too, or for a bound somewhere inside.
        assert expected is None or not is_bounded(expected) or "**" in text or "/" in text
        return
    assert got == expected
    assert type(got) is type(expected)


@settings(max_examples=200)
@given(conditions)
@example("1 < 2 < 3 == 3")
@example("not 1 > 2 or 1 / 0 > 1")
@example("not 1 == 1 and 2 == 2")
def test_conditions_are_pythons(text):
    """Chains, precedence of not, and, or, and what is never looked at."""
    got = ours(text)
    if got is not None:
        assert got is python(text)


@settings(max_examples=150)
@given(st.text(alphabet="0123456789.eE+-*/%()<>=!&|$'\" abcsinmxrodt,{}\n\té²", max_size=60))
@example("(" * 10_000)
@example("-" * 10_000 + "1")
@example("1" * MAX_LENGTH)
@example("9**" * 300 + "9")
@example("not " * 240 + "true")
@example("+".join("1" * 400))
@example("choice(" + "1," * 400 + "1)")
def test_no_text_does_more_than_an_expression_error(text):
    """Whatever is typed: an expression, or an error with a column in the text."""
    try:
        Expression(text).evaluate({}, random.Random(0))
    except ExpressionError as error:
        column = error.column
    else:
        column = 1
    assert 1 <= column <= len(text) + 1


@settings(max_examples=150)
@given(arithmetic)
def test_inferred_types_hold(text):
    """What is called a whole number beforehand is one when evaluated."""
    kinds: dict[str, Any] = {"a": "integer", "b": "number", "c": "integer", "d": "number"}
    expression = Expression(text)
    kind, value = expression.infer(lambda name: kinds[name.name]), ours(text)
    if value is not None:
        assert kind in ("integer", "number", None)
        if kind is not None:
            assert isinstance(value, int) == (kind == "integer") or kind == "number"


@pytest.mark.parametrize("text", ["9 ** 9 ** 9", "2 ** 64 * 2", "10.0 ** 308 * 100", "99 ** 99"])
def test_numbers_are_bounded(text):
    """A large power is refused before it is computed."""
    with pytest.raises(ExpressionError, match="the result is too large"):
        Expression(text).evaluate({}, random.Random(0))
