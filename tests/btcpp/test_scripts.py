"""Scripts of BehaviorTree.CPP and expressions of ours, where both mean the same."""

import pytest

from bt_mission.btcpp.scripts import (
    ScriptError,
    assignments,
    from_script,
    to_script,
    written_assignments,
)


@pytest.mark.parametrize(
    ("ours", "script"),
    [
        ("x > 1 and y", "x > 1 && y"),
        ("(a or b) and not (c == d)", "(a || b) && !(c == d)"),
        ("not a or b", "!a || b"),
        ("-x + 2 * 3.5 / y", "-x + 2 * 3.5 / y"),
        ("word == 'a && not b'", "word == 'a && not b'"),
        ("true", "true"),
    ],
)
def test_what_both_can_say_goes_there_and_back(ours, script):
    """With the same blanks."""
    assert to_script(ours) == script
    assert from_script(script) == ours


@pytest.mark.parametrize(
    "ours",
    [
        "$x > 1",
        "a.b > 1",
        "x ** 2",
        "x // 2",
        "x % 2",
        "abs(x) > 1",
        "pi",
        'word == "a"',
        "a or b and c",
        "not a == b",
        "+x",
        "--x",
        ".5 < x",
        "5. < x",
        "007",
        "99999999999999999999",
        "a  &&",
    ],
)
def test_what_only_we_can_say_has_no_script(ours):
    """Nor what would come back with other blanks."""
    assert to_script(ours) is None


@pytest.mark.parametrize(
    ("script", "ours"), [("a&&b||!c", None), ("a&&!b", "a and not b"), ("(a)||b", "(a) or b")]
)
def test_a_script_need_not_have_blanks(script, ours):
    """They are put in; both kinds of logic need parentheses."""
    if ours is None:
        with pytest.raises(ScriptError, match="by precedence"):
            from_script(script)
    else:
        assert from_script(script) == ours


@pytest.mark.parametrize(
    ("script", "column", "words"),
    [
        ("a ? b : c", 3, "'?' has no counterpart"),
        ("a & b", 3, "'&' has no counterpart"),
        ("0xFF", 1, "'0' has no counterpart"),
        ("!a == b", 1, "'!' is for the next name only"),
        ("sin > 1", 1, "'sin' is a word of our expressions"),
        ("a ** b", 4, "'**' is no operator of a script"),
        ("a b", 1, "expected an operator or the end"),
        ("", 1, "the expression is empty"),
        ("99999999999999999999", 1, "is too large"),
    ],
)
def test_what_only_a_script_can_say_is_refused(script, column, words):
    """At its column."""
    with pytest.raises(ScriptError) as caught:
        from_script(script)
    assert caught.value.column == column
    assert words in caught.value.message


def test_assignments_are_read_with_their_places():
    """Numbers and truth are constants, anything else is an expression; `+=` is written out."""
    assert assignments(" a := 1; b=true ;c += a;d := 'x; y'; e:=-2.5;") == [
        ("a", 2, 1),
        ("b", 10, True),
        ("c", 18, "c + (a)"),
        ("d", 25, "'x; y'"),
        ("e", 38, -2.5),
    ]


@pytest.mark.parametrize(
    ("script", "column", "words"),
    [
        ("1 + 2", 1, "expected 'name := value', got '1 + 2'"),
        ("a == 2", 1, "expected 'name := value'"),
        ("a := 1; a := 2", 9, "'a' is set twice in one Script"),
        ("a := 1; b := c ? 1 : 2", 16, "'?' has no counterpart"),
        ("a := 'x", 6, "this quoted text is never closed"),
        ("a := ", 6, "the expression is empty"),
    ],
)
def test_what_is_no_assignment_is_refused(script, column, words):
    """At its column in the whole script."""
    with pytest.raises(ScriptError) as caught:
        assignments(script)
    assert (caught.value.column, words in caught.value.message) == (column, True)


@pytest.mark.parametrize(
    ("values", "script"),
    [
        ({"a": 1, "b": "a * 2", "c": True}, "a := 1; b := a * 2; c := true"),
        ({"a": "'it'", "b": -0.5}, "a := 'it'; b := -0.5"),
        ({"a": "1"}, None),
        ({"a": "true"}, None),
        ({"a": [1, 2]}, None),
        ({"a": "$b"}, None),
        ({"a": 1e300, "b": 1e-7}, "a := 1e+300; b := 1e-07"),
    ],
)
def test_values_become_a_script_if_they_come_back_the_same(values, script):
    """A text that looks like a number is an expression, and would come back as a number."""
    assert written_assignments(values) == script
