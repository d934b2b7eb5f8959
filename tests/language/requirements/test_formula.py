"""Requirements as they are written: what is refused, where, and what to write instead."""

from __future__ import annotations

import re

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.requirements.formula import Formula
from bt_mission.sessions.load import load

MISSION = """\
mission: tour
inputs: {{most: 0.2}}
requirements:
  {}
tree:
  sequence:
    - turn: {{angle: 90}}
      name: look around
    - wait: 1
      name: visit A
"""


@pytest.mark.parametrize(
    "text",
    [
        "always clearance > 0.10",
        "never collisions > 0",
        'eventually within 60 s: succeeded("visit A")',
        'whenever running("drive"): previously succeeded("look around")',
        'whenever age("scan") > 500 ms then speed < 0.01 m/s within 0.6',
        "always for 5 s speed < 0.2",
        "always (clearance > 20 cm or speed < 0.05)",
        'speed < 0.1 until succeeded("look around")',
        "whenever turn_rate > 1: always for 0.5 s: speed < 0.1",
        'always abs(turn_rate) < 90 deg/s and topic("battery_state", "voltage") > 10.5',
        'whenever failed("drive"): eventually between 0.5 s and 2 s: open_goals == 0',
        'always feedback("drive", "current_distance_travelled") <= distance + 0.1',
        'always speed < 0.3 since running("drive") within 2 min implies battery > 20',
        "not eventually nearest == 'table'",
        'always count(starts(failed("drive"))) within 10 s <= 3',
        "always mean(abs(turn_rate)) over 10 s so far < 20 deg/s",
        "always abs(rate(speed)) < 0.5",
        'whenever ends(running("drive")): outcome("drive") = canceled',
        'never outcome("drive") == "canceled by timeout"',
        'whenever starts(running("drive")): accepted("drive") within 2 s',
        'always abs(yaw - value(yaw) at last starts(running("drive"))) < 5 deg',
        "never rate(mean(speed) over 1 s) > 0.1",
        "whenever starts(historically for 1 s speed < 0.1): clearance > 0.2",
    ],
)
def test_a_requirement_that_reads_aloud_is_one(text: str) -> None:
    """Each of these is parsed and checked without a complaint."""
    assert Formula(text).text == text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("clearance > 1", "this speaks of the start alone; write 'always ...'"),
        ("always clearence > 1", "unknown signal 'clearence'"),
        ("always clearence > 1", "did you mean 'clearance'?"),
        ("always clearance > speed", "units do not fit: m and m/s"),
        ("always clearance > 2 s", "units do not fit: m and s"),
        ("eventually within 2 m: speed > 0", "expected a time (s, ms, min), got 'm'"),
        ("always within 5 s speed > 0", "expected 'always for ...', got 'always within'"),
        ("always for 10 ms speed > 0", "shorter than a control step of 0.05 s"),
        ("eventually between 5 s and 2 s speed > 0", "the window ends before it begins"),
        ("always eventually speed > 0", "'eventually' inside 'always' needs a window"),
        ("previously speed > 0", "'previously' looks back from the start alone"),
        ("never collisions < 0", "this cannot be violated: 'collisions' is 0 or more"),
        ("eventually distance < 0", "this cannot hold: 'distance' is 0 or more"),
        ("always speed", "expected a boolean, got a number"),
        ("always speed < uniform(0, 1)", "cannot draw random numbers"),
        ("always age(scan) < 1", "expected age(\"topic\"), got 'scan'; quote names"),
        ("always running", "expected running(\"node\"), got 'running' alone"),
        ("when speed > 1: speed < 2", "unknown word 'when'; write 'whenever'"),
        ("whenever speed > 1, speed < 2", "expected ':' or 'then' after 'whenever ...'"),
        ("always speed < (1 if always speed > 2 else 3)", "cannot stand inside a calculation"),
        ("always for 5 s so far speed > 0", "'so far' belongs behind a window that looks back"),
        ("always previously so far speed > 0", "'so far' belongs behind a window that looks back"),
        ("always previously within 1 s so speed > 0", "expected 'far' after 'so', got 'speed'"),
        ("starts(speed > 1)", "'starts' compares the start with what was before"),
        ("eventually starts(always for 1 s speed > 1)", "'always' looks ahead, which 'starts'"),
        ("always x < (1 if starts(speed > 1) else 2)", "'starts' cannot stand inside"),
        ("always count(speed > 1) > 2", "expected starts(...) or ends(...) in count(...)"),
        ("always count(starts(eventually within 1 s speed > 1)) > 2", "'eventually' looks ahead"),
        ("always count(starts(speed)) > 2", "expected a boolean, got a number"),
        ("never count(starts(speed > 1)) < 0", "this cannot be violated"),
        ("always mean(speed) > 2", "expected 'over' and a time: mean(speed) over 10 s, got '>'"),
        ("always mean(speed) over 10 ms > 2", "shorter than a control step of 0.05 s"),
        ("always mean(nearest) over 1 s > 2", "expected a number, got a string"),
        ("always mean(speed) over 1 s > 2 m", "units do not fit: m/s and m"),
        ("always rate(x) > 2 m", "units do not fit: m/s and m"),
        ("always value(x) > 2", "expected 'at' and an edge: value(yaw) at last starts(...)"),
        ("always value(x) at last x > 2", "expected starts(...) or ends(...) in 'at last'"),
        ("always outcome('a') = cancelled", "unknown outcome 'cancelled'"),
        ("always outcome('a') = cancelled", "did you mean 'canceled'?"),
        ("always outcome('a') and speed > 1", 'expected outcome("node") = and an outcome'),
        ("always speed = 1", "unexpected token '='; write '=='"),
        ("always (speed > 1 and collisions = 1)", "unexpected token '='; write '=='"),
        ("always speed => 1", "write '>='"),
        ("always rises(speed > 1)", "unknown word 'rises'; write 'starts'"),
        ("always speed < 0,5", "decimals are written with a point: 0.5"),
    ],
)
def test_what_is_no_requirement_says_what_to_write(text: str, message: str) -> None:
    """Words, units, windows and verdicts that cannot be are refused."""
    with pytest.raises(ExpressionError) as refused:
        Formula(text)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("line", "column", "message"),
    [
        ("a: 'eventually within 9 s: succeeded(\"visit B\")'", 30, "no node is named 'visit B'"),
        ("a: always $most > 1 and $least > 1", 27, "'$least' is an undefined variable"),
        ('a: always feedback("visit A", "x") > 1', 13, "no node has a goal and is named 'visit A'"),
        ("a: 5", 6, "expected a requirement such as 'always clearance > 0.1', got the number 5"),
        ("a: {whenever: speed > 1, thn: speed < 2}", 28, "unknown key 'thn'"),
        ("a: {whenever: speed > 1}", 6, "expected 'formula', or 'whenever' and 'then'"),
        ("a: {whenever: speed > 1, then: speed > 2 m}", 6, "units do not fit: m/s and m"),
        ("a: {formula: always speed > 1, on_violation: hlt}", 48, "did you mean 'halt'?"),
        ("a: always speed > > 1", 21, "expected a number, a name or a '(', got '>'"),
    ],
)
def test_a_fault_in_a_requirement_has_its_place(line: str, column: int, message: str) -> None:
    """Line, column and remedy stand in the error of the mission file."""
    with pytest.raises(InputError) as refused:
        load(MISSION.format(line))
    (fault,) = refused.value.faults
    assert (fault.line, fault.column) == (4, column)
    assert message in fault.headline


def test_a_colon_in_a_requirement_wants_quotes() -> None:
    """As for any reader of YAML; the error has the line to write."""
    line = 'gets on: eventually within 60 s: succeeded("visit A")'
    with pytest.raises(InputError) as refused:
        load(MISSION.format(f"{line}  # soon"))
    written = "gets on: 'eventually within 60 s: succeeded(\"visit A\")'"
    assert f"quote the text: {written}" in refused.value.faults[0].headline
    (one,) = load(MISSION.format(f"{written}  # soon")).requirements
    assert (one.name, one.text) == ("gets on", 'eventually within 60 s: succeeded("visit A")')


def test_a_requirement_in_parts_is_one_formula() -> None:
    """The keys of a mapping come to the same as the sentence."""
    form = "a: {whenever: age('scan') > 0.5, then: speed < 0.01, within: 0.6, on_violation: halt}"
    (one,) = load(MISSION.format(form)).requirements
    assert one.text == "whenever age('scan') > 0.5: speed < 0.01 within 0.6 s"
    assert one.on_violation == "halt"


@pytest.mark.parametrize(
    "then", ["speed < 1", "a or b", "x > 0 until y > 0", "running('a') implies x > 0 until y > 0"]
)
def test_a_mapping_reads_back_from_its_text(then: str) -> None:
    """Recordings hold requirements as texts; a window stays with what it belongs to."""
    then = then.replace("a or b", "running('a') or x > 2")
    text = f'{{whenever: speed > 0.5, then: "{then}", within: 0.5}}'
    if "until" in then:
        text = text.replace("y > 0", "y > 0 within 1 s")
    mission = load(f"mission: it\nrequirements:\n  one: {text}\ntree: {{wait: 1, name: a}}\n")
    (one,) = mission.requirements
    again = Formula(one.text).root
    columns = re.compile(r"column=\d+|(?<=[<>=]', )\d+")
    assert columns.sub("", repr(again)) == columns.sub("", repr(one.root))
