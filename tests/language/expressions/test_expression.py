"""Expressions, templates, and texts that may be either; see also transcripts/."""

import math
import random
from contextlib import nullcontext
from typing import Any

import pytest

from bt_mission.language.expressions.expression import (
    MAX_TEMPLATE,
    Expression,
    Template,
    Text,
    names_in,
    resolve,
)
from bt_mission.language.expressions.functions import FUNCTIONS
from bt_mission.language.expressions.outcomes import evaluate_constants
from bt_mission.language.expressions.parser import MAX_DEPTH, MAX_LENGTH, parse
from bt_mission.language.expressions.values import (
    ExpressionError,
    LooseText,
)


def value_of(text, seed=0, fields=None, **names):
    """Evaluate an expression."""
    return Expression(text).evaluate(names, random.Random(seed), fields or {})


def error_of(text, **names):
    """Return column and message of what goes wrong."""
    with pytest.raises(ExpressionError) as caught:
        value_of(text, **names)
    return caught.value.column, caught.value.message


def test_names_are_read_with_and_without_a_dollar():
    """`$x` and `x` are the same variable."""
    assert value_of("$x + x", x=2) == 4
    assert Expression("$x + y * $x").names == {"x", "y"}


def test_a_bare_name_is_a_field_first_and_a_dollar_name_never():
    """In a condition on the feedback both kinds of names meet."""
    assert value_of("speed > $speed", fields={"speed": 0.3}, speed=0.2) is True
    assert value_of("limit > 1", fields={"speed": 0.3}, limit=2) is True
    assert value_of("pose.x", fields={"pose.x": 1.5}) == 1.5


def test_a_name_without_a_value_is_told_with_those_that_have():
    """The run says what the check could not know."""
    column, message = error_of("1 + $obstacle", speed=1)
    assert column == 5
    assert message == "'$obstacle' has no value (values: speed)"


def test_the_same_seed_draws_the_same_numbers():
    """All randomness comes from the generator that is handed in."""
    text = "uniform(0, 1) + levy(1, 9) + choice(1, 2, 3)"
    assert value_of(text, seed=3) == value_of(text, seed=3) != value_of(text, seed=4)
    assert Expression(text).draws
    assert not Expression("sign(2)").draws


def test_equal_texts_are_equal_expressions():
    """Steps can be compared."""
    assert Expression("1 + 1") == Expression("1 + 1")
    assert hash(Template("$x")) == hash(Template("$x"))


def test_the_length_of_a_template_is_bounded():
    """That of a text without holes is not."""
    Template("$x " + "x" * (MAX_TEMPLATE - 3))
    with pytest.raises(ExpressionError, match="10,001 characters; the limit is 10,000"):
        Template("$x " + "x" * (MAX_TEMPLATE - 2))
    assert Template("x" * 20_000).evaluate({}, random.Random(0)) == "x" * 20_000


def test_equal_holes_are_told_once_and_filled_each():
    """What is wrong with one is wrong with all."""
    template = Template("$x, ${x} and ${x}, $x")
    assert [(hole.offset, hole.expression.text) for hole in template.holes] == [(0, "$x"), (6, "x")]
    assert template.evaluate({"x": 1}, random.Random(0)) == "1, 1 and 1, 1"
    drawn = Template("${uniform(0, 1)} ${uniform(0, 1)}").evaluate({}, random.Random(0))
    assert len(set(drawn.split())) == 2


def test_resolving_computes_what_is_nested():
    """Constants stay, lists and mappings keep their form."""
    value = {"a": 1, "b": [Expression("x + 1"), 2.5], "c": (Template("$x!"), True)}
    assert resolve(value, {"x": 1}, random.Random(0)) == {
        "a": 1,
        "b": [2, 2.5],
        "c": ["1!", True],
    }
    assert names_in(value) == {"x"}


def test_a_text_in_a_goal_keeps_both_readings_until_its_field_is_known():
    """A text field takes the template, a number field the expression."""
    late = resolve(Text("$x"), {"x": 3}, random.Random(0))
    assert (late.as_text(), late.as_value()) == ("3", 3)


def test_a_reading_that_is_impossible_fails_only_where_it_is_wanted():
    """`tree number $n` is no expression, and need not be one."""
    late = resolve(Text("tree number $n"), {"n": 2}, random.Random(0))
    assert late.as_text() == "tree number 2"
    with pytest.raises(ExpressionError, match="expected an operator or the end"):
        late.as_value()
    with pytest.raises(ExpressionError, match=r"expected a name or '\{' after '\$'"):
        resolve(Text("5 $"), {}, random.Random(0)).as_text()


def test_both_readings_draw_only_once():
    """The value of a field does not depend on its type."""
    late = resolve(Text("uniform(0, 1)"), {}, random.Random(5))
    assert late.as_value() == random.Random(5).random()


@pytest.mark.parametrize("levels", [MAX_DEPTH - 1, MAX_DEPTH])
@pytest.mark.parametrize("opening", ["(", "-", "not ", "abs("])
def test_nesting_is_bounded(opening, levels):
    """One level less than the limit is read, the limit is not passed."""
    closing = ")" if "(" in opening else ""
    inner = "true" if "not" in opening else "1"
    text = opening * levels + inner + closing * levels
    if levels < MAX_DEPTH:
        parse(text)
    else:
        with pytest.raises(ExpressionError, match="nested too deeply"):
            parse(text)


def test_length_is_bounded():
    """A thousand characters are a program, not an expression."""
    with pytest.raises(ExpressionError, match="has 1,001 characters; the limit is 1,000"):
        parse(" " * MAX_LENGTH + "1")


def test_an_error_is_as_new_each_time():
    """It is remembered, and neither its traceback nor a change of it is."""
    errors = []
    for _ in range(2):
        with pytest.raises(ExpressionError) as caught:
            parse("1 +")
        errors.append(caught.value)
    first, second = errors
    assert first is not second
    assert str(first) == str(second)
    with pytest.raises(LooseText):
        parse("two words")


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


def test_an_error_prints_with_hint_and_column():
    """Where it is not located in a file."""
    assert str(ExpressionError("BT-401", "wrong", 4, "write 'x'")) == "wrong; write 'x' (column 4)"


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
    names: dict[str, Any] = {"n": 2, "list": [1]}
    with pytest.raises(ExpressionError) if is_refused else nullcontext():
        evaluate_constants(Expression(text).root, names, lambda name: name.name in names)
