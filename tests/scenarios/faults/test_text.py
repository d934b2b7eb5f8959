"""Faults as text: what is read, what it comes to, and what is wrong with it."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.formula import Condition
from bt_mission.scenarios.faults import FAULTS, PlannedFault, parse_fault
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.located import fault_in_text
from bt_mission.scenarios.faults.parameters import Parameter
from bt_mission.scenarios.faults.planned import AfterStep, AtTime, Beginning, Value, WhenTrue


def refusal(text: str) -> tuple[int, str]:
    """Return column and message of what is wrong with a text, its hint included."""
    with pytest.raises(ExpressionError) as caught:
        parse_fault(text)
    error = caught.value
    return error.column, f"{error.message}; {error.hint}" if error.hint else error.message


def test_a_time_a_fault_and_its_end() -> None:
    """The first argument stands without its name."""
    fault = parse_fault("at 5.0: drop scan lasting 2")
    assert fault == PlannedFault(AtTime(5.0), "drop", {"topic": "scan"}, 2)
    assert fault.text == "at 5.0: drop scan lasting 2"


@pytest.mark.parametrize(
    "arguments", ["scan share 0.5", "scan share=0.5", "topic=scan share=0.5", "topic scan share .5"]
)
def test_arguments_have_places_and_names(arguments: str) -> None:
    """With or without a sign between name and value."""
    fault = parse_fault(f"at 1: drop {arguments}")
    assert fault.arguments == {"topic": "scan", "share": 0.5}


def test_the_name_of_a_field_behind_a_number_is_no_unit() -> None:
    """With or without a unit of the number."""
    for every in ("0.05", "50 ms"):
        fault = parse_fault(f"at 1: publish load every {every} data=3.0")
        assert fault.arguments == {"topic": "load", "every": 0.05, "data": 3.0}


@pytest.mark.parametrize(
    ("text", "begins"),
    [
        ("at 500 ms: imu_dead", AtTime(0.5)),
        ("after 2 s: imu_dead", AfterStep(2.0)),
        ("when distance > 0.5: imu_dead", WhenTrue(Condition("distance > 0.5"))),
        (
            'when running("drive") for 2 s: imu_dead',
            WhenTrue(Condition('running("drive")'), held_s=2.0),
        ),
        (
            "when previously within 5 s: speed > 0.1: imu_dead",
            WhenTrue(Condition("previously within 5 s: speed > 0.1")),
        ),
        ('when running("a: b"): imu_dead', WhenTrue(Condition('running("a: b")'))),
    ],
)
def test_a_fault_begins_at_a_time_after_a_step_or_on_a_condition(text: str, begins: object) -> None:
    """A colon in quotes, or of a word of time, belongs to the condition."""
    assert parse_fault(text).begins == begins


def test_numbers_are_turned_into_the_units_of_their_arguments() -> None:
    """A number without a unit is in the argument's own, and stays as it is written."""
    fault = parse_fault("at 1: spawn_box at (1.0, 50 cm) size (10 cm, 200mm, 1) yaw 3.2 rad")
    assert fault.arguments == {
        "at": (1.0, 0.5),
        "size": (0.1, 0.2, 1),
        "yaw": pytest.approx(math.degrees(3.2)),
    }
    assert parse_fault("at 1: delay odom 200 ms jitter 1").arguments["by"] == 0.2
    assert repr(parse_fault("at 1: delay odom 2").arguments["by"]) == "2"


def test_a_flag_needs_no_value() -> None:
    """Where it is on by default, `false` puts it off."""
    assert parse_fault("at 1: freeze scan fresh_stamps").arguments["fresh_stamps"] is True
    assert parse_fault("at 1: delay scan 1 in_order false").arguments["in_order"] is False


def test_texts_with_blanks_are_quoted() -> None:
    """In either kind of quotes."""
    fault = parse_fault("at 1: corrupt scan 'old stamp'")
    assert fault.arguments["how"] == "old stamp"
    assert fault.text == 'at 1.0: corrupt scan "old stamp"'


def test_sectors_repeat_and_fields_have_any_name() -> None:
    """As the method of `stage.faults` takes them."""
    fault = parse_fault("at 1: lidar_blind (-20, 20) (160, -160)")
    assert fault.arguments == {"sectors": ((-20, 20), (160, -160))}
    fault = parse_fault('at 1: fail_service stop success=false message="worn out"')
    assert fault.arguments == {"service": "stop", "success": False, "message": "worn out"}


@pytest.mark.parametrize(
    "value",
    [(), (0.5, math.nan), (math.inf, -math.inf), ("a", "b c"), (True, False), math.nan, "nan"],
    ids=repr,
)
def test_fields_take_lists_and_numbers_that_are_not_finite(value: Value) -> None:
    """They are read as they are written."""
    text = PlannedFault(AtTime(1.0), "publish", {"topic": "scan", "x": value}, 2).text
    assert repr(parse_fault(text).arguments["x"]) == repr(value)


def test_a_word_before_another_name_is_a_value() -> None:
    """The box is called `box`, as the argument is."""
    fault = parse_fault("at 1: move_box box ahead 1")
    assert fault.arguments == {"box": "box", "ahead": 1}


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "expected a fault such as 'at 5.0: drop scan lasting 2', got nothing in place"),
        ("att 5: imu_dead", 1, "got 'att' in place of at, after or when; did you mean 'at'?"),
        ("at 5 imu_dead", 14, "expected ':' between when a fault begins and what it is"),
        ("at five: imu_dead", 4, "expected a time such as '5.0', in seconds, got 'five'"),
        ("at -1: imu_dead", 4, "expected a number in s from 0 up for 'time', got the number -1"),
        ("at 5 m: imu_dead", 6, "'time' is in s (s, ms, min), got 'm'"),
        ("at 5: imu_ded", 7, "unknown fault 'imu_ded'; did you mean 'imu_dead'?"),
        ("at 5: 3", 7, "expected the name of a fault, got '3'"),
        ("at 5: drop", 7, "drop needs topic; write 'drop TOPIC [share N]"),
        ("at 5: drop scan shar 0.3", 17, "unexpected string 'shar'; did you mean 'share'?"),
        ("at 5: drop scan shar=0.3", 17, "drop has no argument 'shar' (known: topic, share"),
        (
            "at 5: drop scan share 3",
            23,
            "expected a number above 0 and at most 1 for 'share', got the number 3",
        ),
        ("at 5: drop scan share .nan", 23, "at most 1 for 'share', got the number nan"),
        ("at 5: spawn_box at (a, 2) size (1, 1, 1)", 20, "for 'at', got string 'a'"),
        ("at 5: publish scan ranges=(1 2)", 30, "expected ',' or ')', got '2'"),
        ("at 5: publish scan ranges=(1,)", 30, "expected a value, got ')'"),
        ("at 5: drop scan share x", 23, "for 'share', got string 'x'"),
        ("at 5: drop scan share 1 share 1", 25, "'share' is given twice"),
        ("at 5: drop scan lasting 2 m", 27, "'lasting' is in s (s, ms, min), got 'm'"),
        ("at 5: drop scan lasting 2 sec", 27, "'lasting' is in s (s, ms, min), got 'sec'"),
        ("at 1e300: imu_dead", 4, "expected at most 2,147,483,647 s for 'time', got 1e+300"),
        ("at 5: drop scan lasting 1e300", 25, "expected at most 2,147,483,647 s for 'lasting'"),
        ("when speed > 1 for 1e300: imu_dead", 20, "a time of at most 2,147,483,647 s"),
        ("at 5: drop scan lasting 20 ms", 25, "0.02 s is shorter than a control step of 0.05 s"),
        ("at 5: drop scan lasting", 24, "expected a value, got the end"),
        ("at 5: shove 1 lasting 2", 15, "shove has no duration, so no 'lasting'"),
        ("at 5: block_wheel lft", 19, "expected one of left, right, both for 'wheel', got 'lft'"),
        ("at 5: spawn_box at (1, 2, 3)", 20, "expected 2 numbers in m, such as (0.5, 0.5)"),
        ("at 5: push 1e999", 12, "'1e999' is too large"),
        ("at 5: drop scan; imu_dead", 16, "unexpected ';'"),
        ("when always speed > 1: imu_dead", 6, "'always' looks ahead; a condition covers only"),
        ("when spee > 1: imu_dead", 6, "unknown signal 'spee'"),
        ("when speed > 1 s: imu_dead", 12, "units do not match: m/s and s"),
        ("when collisions >= 0: imu_dead", 17, "this is always true"),
        ("when speed > 1 for 1 ms: imu_dead", 16, "0.001 s is shorter than a control step"),
    ],
)
def test_what_is_wrong_has_its_place(text: str, column: int, message: str) -> None:
    """And tells what to write instead."""
    result, output = refusal(text)
    assert message in output
    assert result == column


def test_a_fault_of_python_is_told_apart_from_an_unknown_one() -> None:
    """What only Python can give, such as an exception, is no argument here."""
    _, output = refusal('at 5: raise_in_leaf drive error="worn out"')
    assert output.startswith("raise_in_leaf has no argument 'error' (known: leaf, method, on")


# ---- there and back ----------------------------------------------------------------------

_TEXTS = st.text(
    st.characters(codec="utf-8", exclude_characters="\n\r\x85\u2028\u2029"), max_size=9
)
_NUMBERS = st.floats(0.05, 1.0) | st.integers(1, 9)


def _values(parameter: Parameter) -> st.SearchStrategy[Any]:
    values: dict[str, st.SearchStrategy[Any]] = {
        "number": _NUMBERS,
        "integer": st.integers(2, 9),
        "flag": st.booleans(),
        "text": st.sampled_from(parameter.choices)
        if parameter.choices
        else _TEXTS | st.just(parameter.name),
        "numbers": st.tuples(*[_NUMBERS] * parameter.count),
    }
    return values[parameter.form]


@st.composite
def planned_faults(draw: st.DrawFn) -> PlannedFault:
    """Any fault with any of its arguments, those included that it refuses."""
    kind = FAULTS[draw(st.sampled_from(sorted(FAULTS)))]
    arguments: dict[str, Value] = {}
    for parameter in kind.parameters.values():
        if parameter.is_required or draw(st.booleans()):
            values = _values(parameter)
            arguments[parameter.name] = draw(
                st.lists(values, min_size=1, max_size=2).map(tuple) if parameter.repeats else values
            )
    beginnings: tuple[Beginning, ...] = (
        AtTime(1.5),
        AfterStep(2.0),
        WhenTrue(Condition("speed > 0.1"), 1.0),
    )
    begins = draw(st.sampled_from(beginnings))
    lasting = draw(st.none() | _NUMBERS) if kind.lasts else None
    return PlannedFault(begins, kind.name, arguments, lasting)


@pytest.mark.thorough
@given(planned_faults())
def test_what_is_written_of_a_fault_is_read_as_the_same(fault: PlannedFault) -> None:
    """Unless the fault itself refuses the figures."""
    try:
        fault.make()
    except ScenarioError:
        with pytest.raises(ExpressionError):
            parse_fault(fault.text)
    else:
        assert parse_fault(fault.text) == fault


@pytest.mark.parametrize(
    ("text", "doubts"),
    [
        ("at 1.0: delay odom 200", ["'by' is in seconds: 200 s; 200 ms?"]),
        ("at 1.0: delay odom 0.2 jitter 50", ["'jitter' is in seconds: 50 s; 50 ms?"]),
        ("at 1.0: delay odom 200 s", []),
        ("at 1.0: delay odom 200 ms", []),
        ("at 1.0: delay odom 2", []),
        ("at 1.0: drop odom lasting 200", []),
    ],
)
def test_a_long_delay_without_a_unit_is_doubted(text, doubts):
    """It looks as if it was in milliseconds."""
    results = list(fault_in_text(text).doubts())
    assert [result.message for result in results] == doubts
    assert all(result.severity == "warning" for result in results)
