"""Values for inputs from outside."""

from typing import Any

import pytest

from bt_mission.language.inputs import overridden

INPUTS: dict[str, Any] = {
    "speed": 0.2,
    "legs": 6,
    "quiet": False,
    "place": "A",
    "zones": ["A", "B"],
}


@pytest.mark.parametrize(
    ("name", "given", "value"),
    [
        ("speed", "0.15", 0.15),
        ("speed", "1", 1),
        ("legs", "2.5", 2.5),
        ("speed", 0.4, 0.4),
        ("quiet", "true", True),
        ("place", "B", "B"),
        ("place", "12", "12"),
        ("place", "", ""),
        ("zones", "[C, 1]", ["C", 1]),
    ],
)
def test_a_value_is_read_as_the_default_asks(name, given, value):
    """A number from digits, a text from anything, a list from brackets."""
    values, faults = overridden(INPUTS, {name: given})
    assert faults == []
    assert values == {**INPUTS, name: value}


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("speed", "fast", "input 'speed' expects a number, got string 'fast'"),
        ("speed", "", "input 'speed' expects a number, got string ''"),
        ("speed", ".nan", "input 'speed' expects a number, got string '.nan'"),
        ("speed", "nan", "input 'speed' expects a number, got string 'nan'"),
        ("speed", "true", "input 'speed' expects a number, got string 'true'"),
        ("speed", "{a: [", "input 'speed' expects a number, got string '{a: ['"),
        ("legs", "[1]", "input 'legs' expects a number, got string '[1]'"),
        ("quiet", "yes", "input 'quiet' expects a boolean, got string 'yes'"),
        ("zones", "A", "input 'zones' expects a list, got string 'A'"),
        ("zones", "[{a: 1}]", "input 'zones' expects a list, got string '[{a: 1}]'"),
        ("zones", "[null]", "input 'zones' expects a list, got string '[null]'"),
        ("speed", float("nan"), "input 'speed' expects a number, got the number nan"),
        ("place", 3, "input 'place' expects a string, got the number 3"),
    ],
)
def test_a_value_of_another_type_is_refused_with_a_caret(name, given, message):
    """The default says what is wanted."""
    values, (fault,) = overridden(INPUTS, {name: given})
    assert values == INPUTS
    assert fault.message == message
    assert (fault.file, fault.source, fault.column) == ("--set", f"{name}={given}", len(name) + 2)


def test_an_unknown_input_is_told_with_the_known_ones():
    """And with the nearest."""
    _, (fault,) = overridden(INPUTS, {"sped": "1"})
    assert str(fault).splitlines() == [
        (
            "--set:1:1: error: no input 'sped' (the mission's inputs: speed, legs, quiet, place, "
            "zones); did you mean 'speed'?"
        ),
        "    sped=1",
        "    ^",
    ]
