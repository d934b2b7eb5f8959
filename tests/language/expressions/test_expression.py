"""Expressions, templates, and texts that may be either."""

import random
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
from bt_mission.language.expressions.values import ExpressionError


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
    assert message == "'$obstacle' has no value (those that have: speed)"


def test_references_have_columns():
    """Faults point at the name itself."""
    references = Expression("-sign($a) * b.c").references
    assert [(name.shown, name.column) for name in references] == [("$a", 7), ("b.c", 13)]


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


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain", "plain"),
        ("", ""),
        ("at $x m", "at 0.5 m"),
        ("$x.", "0.5."),
        ("${x * 2 + 1} and $n", "2 and 3"),
        ("$$5", "$5"),
        ("${'}'}", "}"),
        ("${1 / 3}", "0.333333"),
        ("${x > 1}", "false"),
        ("$all", "1, 2, x"),
        ("$word", "hello"),
    ],
)
def test_templates_are_filled(text, shown):
    """Numbers with six digits, truth in words, lists with commas."""
    names: dict[str, Any] = {"x": 0.5, "n": 3, "all": [1, 2.0, "x"], "word": "hello"}
    assert Template(text).evaluate(names, random.Random(0)) == shown


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("costs $ 5", 7, "expected a name or '{' after '$'"),
        ("a ${x", 3, "this '${' is never closed with '}'"),
        ("a ${1 +} b", 8, "expected a number, a name or a '(', got the end"),
        ("a ${} b", 5, "the expression is empty"),
    ],
)
def test_templates_that_cannot_be_read(text, column, message):
    """The column counts in the whole text."""
    with pytest.raises(ExpressionError) as caught:
        Template(text)
    assert (caught.value.column, caught.value.message) == (column, message)


def test_the_length_of_a_template_is_bounded():
    """That of a text without holes is not."""
    Template("$x " + "x" * (MAX_TEMPLATE - 3))
    with pytest.raises(ExpressionError, match="10,001 characters; at most 10,000 are read"):
        Template("$x " + "x" * (MAX_TEMPLATE - 2))
    assert Template("x" * 20_000).evaluate({}, random.Random(0)) == "x" * 20_000


def test_equal_holes_are_told_once_and_filled_each():
    """What is wrong with one is wrong with all."""
    template = Template("$x, ${x} and ${x}, $x")
    assert [(hole.offset, hole.expression.text) for hole in template.holes] == [(0, "$x"), (6, "x")]
    assert template.evaluate({"x": 1}, random.Random(0)) == "1, 1 and 1, 1"
    drawn = Template("${uniform(0, 1)} ${uniform(0, 1)}").evaluate({}, random.Random(0))
    assert len(set(drawn.split())) == 2


def test_references_of_a_template_have_columns_in_the_whole_text():
    """So that a caret can stand under the name."""
    template = Template("at $x, ${2 * y}")
    assert [(name.shown, name.column) for name in template.references] == [("$x", 4), ("y", 14)]


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


def test_names_in_a_text_are_those_of_either_reading():
    """Which one it will be is not known yet."""
    assert names_in([Text("x + $y"), {"k": Text("a word $z")}]) == {"x", "y", "z"}
    assert names_in(None) == frozenset()
