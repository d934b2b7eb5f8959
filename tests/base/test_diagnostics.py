"""Faults as a person reads them."""

import pytest

from bt_mission.base.diagnostics import (
    CUT,
    LIKENED_NAMES,
    SHOWN_DIAGNOSTICS,
    SHOWN_WIDTH,
    Diagnostic,
    InputError,
    describe,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.base.errors import BtMissionError

ANGEL = Diagnostic("BT-1", "no 'angel'", "a.yaml", 7, 12, "    turn: {angel: 90}", "write 'angle'")


@pytest.mark.parametrize(
    ("diagnostic", "lines"),
    [
        (
            ANGEL,
            [
                "a.yaml:7:12: error: no 'angel'; write 'angle' [BT-1]",
                "        turn: {angel: 90}",
                "               ^",
            ],
        ),
        (
            Diagnostic("BT-1", "never read", "a.yaml", 1, 1, "x: 1", severity="warning"),
            ["a.yaml:1:1: warning: never read [BT-1]", "    x: 1", "    ^"],
        ),
        (Diagnostic("BT-1", "no such file", "a.yaml"), ["a.yaml: error: no such file [BT-1]"]),
    ],
    ids=["place, words, hint, code, line and caret", "a warning", "a whole file has no place"],
)
def test_a_diagnostic_is_shown_as_compilers_do(diagnostic, lines):
    """The first line can be clicked in an editor; the caret stands under the column."""
    assert str(diagnostic).splitlines() == lines


@pytest.mark.parametrize("column", [1, 400, 1000])
def test_a_long_line_is_cut_around_the_caret(column):
    """What is shown is the part that the diagnostic is about, and the caret stays under it."""
    source = "".join(str(i % 10) for i in range(1000))
    _, shown, caret = str(Diagnostic("BT-100", "wrong", "a.yaml", 1, column, source)).splitlines()
    assert len(shown) <= SHOWN_WIDTH + len("    ...  ...")
    assert shown[caret.index("^")] == source[column - 1]


def test_wide_and_control_characters_keep_the_caret_in_place():
    """A CJK character takes two cells; a tab is shown as one blank."""
    _, shown, caret = str(Diagnostic("BT-100", "wrong", "a.yaml", 1, 4, "\t前x: 1")).splitlines()
    assert shown == "     前x: 1"
    assert caret.index("^") == len("     ") + len("前x") + 1


def test_an_input_error_joins_its_diagnostics_and_counts_what_it_leaves_out():
    """A file with a thousand mistakes does not fill a thousand screens."""
    diagnostics = [
        Diagnostic("BT-100", f"mistake {i}", "a.yaml") for i in range(SHOWN_DIAGNOSTICS + 7)
    ]
    error = InputError(diagnostics)
    assert isinstance(error, BtMissionError)
    assert error.diagnostics == tuple(diagnostics)
    lines = str(error).splitlines()
    assert lines[0] == "a.yaml: error: mistake 0 [BT-100]"
    assert lines[-1] == "... and 7 more"
    assert len(lines) == SHOWN_DIAGNOSTICS + 1


def test_diagnostics_are_put_in_the_order_of_the_file_each_once():
    """What two passes find is reported once."""
    late, early = Diagnostic("BT-100", "late", "a", 2, 1), Diagnostic("BT-100", "early", "a", 1, 9)
    assert in_order([late, early, late]) == (early, late)


def test_the_rest_of_a_text_that_a_comma_cuts_off_has_no_diagnostics():
    """Up to the next value: what is wrong behind it, or in another line, stays."""
    source = "{a: max(1, 2) > 1, b: 3 +}"
    cut = Diagnostic("BT-100", "cut", "m.yaml", 3, 10, source, CUT)
    in_rest = [Diagnostic("BT-100", "rest", "m.yaml", 3, column, source) for column in (12, 18)]
    others = [
        Diagnostic("BT-100", "other", "m.yaml", 3, 20, source),
        Diagnostic("BT-100", "other", "m.yaml", 4, 12),
    ]
    assert in_order([*in_rest, *others, cut]) == (cut, *others)
    alone = Diagnostic("BT-100", "cut", "m.yaml", 3, 8, "a: max(1", CUT)
    assert in_order([alone, *others]) == (alone, *others)


def test_the_nearest_name_is_offered_only_when_it_is_near():
    """A wild guess would mislead."""
    assert did_you_mean("trun", ["turn", "wait"]) == "did you mean 'turn'?"
    assert did_you_mean("xyz", ["turn", "wait"]) is None
    assert did_you_mean("turn", ["tu\nrn"]) == "did you mean 'tu\\nrn'?"


@pytest.mark.parametrize(
    ("names", "most", "words"),
    [
        ([], 40, "none"),
        (["a", "b"], 40, "a, b"),
        ((str(i) for i in range(45)), 3, "0, 1, 2, and 42 more"),
        (["a\nb", "c"], 40, "a\\nb, c"),
    ],
)
def test_lists_of_names_are_cut_and_stay_on_one_line(names, most, words):
    """The reader gets the first ones, and how many there are beside."""
    assert listed(names, most=most) == words


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "nothing"),
        (True, "true"),
        (3, "the number 3"),
        (0.5, "the number 0.5"),
        ("fast", "string 'fast'"),
        ([], "an empty list"),
        ([1, 2], "a list of 2"),
        ({}, "an empty mapping"),
        ({"a": 1, "b": 2}, "a mapping with a, b"),
        (object(), "a value of type object"),
    ],
)
def test_values_are_described_in_words(value, words):
    """Messages speak of texts and mappings, not of str and dict."""
    assert describe(value) == words


def test_quoted_text_stays_on_one_short_line():
    """Line breaks and length of what a user wrote do not break a message."""
    assert quoted("a\nb") == "'a\\nb'"
    assert quoted("x" * 100) == "'" + "x" * 57 + "...'"


def test_a_name_is_compared_with_some_hundreds_only():
    """Twenty thousand comparisons for each of two hundred diagnostics would take a minute."""
    names = [f"other{i}" for i in range(LIKENED_NAMES)]
    assert did_you_mean("turn", [*names, "turm"]) is None
    assert did_you_mean("turn", ["turm", *names]) == "did you mean 'turm'?"
