"""The grammar's refusals: each with its column, and what to write instead."""

import pytest

from bt_mission.language.expressions.parser import MAX_DEPTH, MAX_LENGTH, RESERVED, parse
from bt_mission.language.expressions.values import ExpressionError, LooseText

CUT = "inside {} or [] a comma ends the text: put it in quotes"


@pytest.mark.parametrize(
    ("text", "column", "message", "hint"),
    [
        ("", 1, "the expression is empty", None),
        ("1 +", 4, "expected a number, a name or a '(', got the end", None),
        ("1 + * 2", 5, "expected a number, a name or a '(', got '*'", None),
        ("1 2", 3, "expected an operator or the end, got '2'", None),
        ("2mu", 2, "expected an operator or the end, got 'mu'", "did you mean 'm'?"),
        ("(1", 3, "expected ')' for the '(' in '(1'", CUT),
        ("sin(1", 6, "expected ')' for the '(' in 'sin(1'", CUT),
        ("1)", 2, "expected an operator or the end, got ')'", None),
        ("a = 1", 3, "unexpected token '='", "write '=='"),
        ("a && b", 3, "unexpected token '&&'", "write 'and'"),
        ("a || b", 3, "unexpected token '||'", "write 'or'"),
        ("!a", 1, "unexpected token '!'", "write 'not'"),
        ("2 ^ 3", 3, "unexpected token '^'", "write '**'"),
        ("a @ b", 3, "unexpected token '@'", None),
        ("'abc", 1, "this quoted text is never closed", None),
        ("1 + $", 5, "expected a name after '$'", None),
        ("sin", 4, "expected '(' after the function sin", None),
        ("and 1", 1, "expected a number, a name or a '(', got 'and'", None),
        ("atan2(1)", 1, "expected atan2(y, x), got 1 arguments", None),
        ("1e999", 1, "the number '1e999' is too large", None),
        ("99999999999999999999", 1, "the number '99999999999999999999' is too large", None),
    ],
)
def test_what_is_no_expression_is_refused_where_it_ceases_to_be_one(text, column, message, hint):
    """Words of other languages get the word of ours."""
    with pytest.raises(ExpressionError) as caught:
        parse(text)
    error = caught.value
    assert (error.column, error.message, error.hint) == (column, message, hint)


def test_an_unknown_function_is_told_with_the_known_ones():
    """And with the nearest."""
    with pytest.raises(ExpressionError, match=r"no function 'sgn' \(known: abs, atan2") as caught:
        parse("1 + sgn(2)")
    assert caught.value.column == 5
    assert caught.value.hint == "did you mean 'sign'?"


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
    with pytest.raises(ExpressionError, match="has 1,001 characters; at most 1,000 are read"):
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


def test_reserved_words_are_those_the_grammar_takes():
    """They cannot be variables."""
    assert {"true", "false", "pi", "and", "or", "not", "sin", "uniform"} <= RESERVED
