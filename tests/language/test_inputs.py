"""Values for inputs from outside that are no texts; texts are in transcripts/inputs.txt."""

from typing import Any

import pytest

from bt_mission.language.inputs import overridden

INPUTS: dict[str, Any] = {"speed": 0.2, "place": "A"}


def test_a_number_is_taken_as_it_is():
    """Other inputs keep their defaults."""
    assert overridden(INPUTS, {"speed": 0.4}) == ({"speed": 0.4, "place": "A"}, [])


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("speed", float("nan"), "input 'speed' expects a number, got the number nan"),
        ("place", 3, "input 'place' expects a string, got the number 3"),
    ],
)
def test_a_value_of_another_type_is_refused_with_a_caret(name, value, message):
    """The default says which type is expected."""
    values, (fault,) = overridden(INPUTS, {name: value})
    assert (values, fault.message) == (INPUTS, message)
    assert (fault.file, fault.source, fault.column) == ("--set", f"{name}={value}", len(name) + 2)
