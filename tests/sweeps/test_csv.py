"""All rows as CSV."""

from __future__ import annotations

import csv
import io

import pytest

from bt_mission.sweeps.store import write_csv
from tests.sweeps.rows import failed, margin, row


def table(*rows):
    """The lines of the CSV of rows, by the names of the columns."""
    file = io.StringIO(newline="")
    write_csv(lambda: rows, file)
    return list(csv.DictReader(io.StringIO(file.getvalue(), newline="")))


def test_each_parameter_and_requirement_has_columns():
    """Also where only some of the rows have it; those of the others are empty."""
    lines = table(
        row(0, parameters={"speed": 0.1}, requirements={"clear": margin(0.25)}),
        row(1, parameters={"world": "hall"}, requirements={"calm": margin(None, "open")}),
    )
    assert lines[0]["parameter.speed"] == "0.1"
    assert (lines[0]["verdict.clear"], lines[0]["margin.clear"]) == ("holds", "0.25")
    assert (lines[1]["verdict.calm"], lines[1]["margin.calm"]) == ("open", "")
    assert (lines[1]["parameter.speed"], lines[1]["verdict.clear"]) == ("", "")


def test_lines_end_as_rfc_4180_says():
    """With carriage return and line feed; a text with quotes and commas comes back."""
    file = io.StringIO(newline="")
    write_csv(lambda: [failed(0, reason='he said "no", twice')], file)
    assert file.getvalue().endswith("\r\n")
    assert '"he said ""no"", twice"' in file.getvalue()


@pytest.mark.parametrize("text", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\tx", "\rx"])
def test_no_text_becomes_a_formula(text):
    """A spreadsheet shows what begins with an apostrophe, and reckons nothing."""
    (line,) = table(failed(0, reason=text, parameters={"name": text}))
    assert line["reason"].startswith("'")
    assert line["parameter.name"].startswith("'")


def test_the_names_of_columns_are_texts_of_others_too():
    """They begin with a word of ours, so that none is a formula."""
    (line,) = table(row(0, parameters={"=x": 1}, requirements={"=y": margin(1.0)}))
    assert {"parameter.=x", "margin.=y"} <= line.keys()


@pytest.mark.parametrize("value", [-0.25, -3, 1e-7, -1.5e300])
def test_numbers_stay_numbers(value):
    """A negative margin, and a negative number that is a text, begin with no apostrophe."""
    (line,) = table(
        row(0, parameters={"x": value, "t": str(value)}, requirements={"c": margin(value)})
    )
    assert [float(line[name]) for name in ("parameter.x", "parameter.t", "margin.c")] == [value] * 3


def test_what_commands_a_terminal_is_escaped():
    """The rows may be printed."""
    (line,) = table(failed(0, reason="\x1b[2Jgone\u202e"))
    assert line["reason"] == "\\x1b[2Jgone\\u202e"


def test_truth_and_lists_are_as_json_has_them():
    """So that every program reads them alike."""
    (line,) = table(row(0, faults=("at 2: x",), parameters={"quiet": False}))
    assert (line["passed"], line["parameter.quiet"], line["faults"]) == (
        "true",
        "false",
        '["at 2: x"]',
    )
