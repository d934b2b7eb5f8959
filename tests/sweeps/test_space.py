"""Parameters of a sweep, as the command line and files have them."""

from __future__ import annotations

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.sweeps.space import (
    Choices,
    Interval,
    parse_parameter,
    read_parameters,
    refuse_repeated,
)


@pytest.mark.parametrize(
    ("text", "parameter"),
    [
        ("speed=0.1,0.2", Choices("speed", (0.1, 0.2))),
        ("world=dqn_stage1,dqn_stage4", Choices("world", ("dqn_stage1", "dqn_stage4"))),
        ("zones=[a, b],[c]", Choices("zones", (["a", "b"], ["c"]))),
        ("say='a,b',c", Choices("say", ("a,b", "c"))),
        ("speed=0.1..0.26", Interval("speed", 0.1, 0.26)),
        ("legs=1..3", Interval("legs", 1, 3, is_whole=True)),
        ("start.x=-1e0..+2.5", Interval("start.x", -1.0, 2.5)),
        ("on=true", Choices("on", (True,))),
    ],
)
def test_parameters_are_read(text: str, parameter: Choices | Interval):
    """Values as those of a YAML list, or two ends."""
    assert parse_parameter(text) == parameter


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("speed", "expected NAME=VALUES, such as 'speed=0.1,0.2'"),
        ("=1", "expected NAME=VALUES"),
        ("speed=", "'speed': expected values"),
        ("speed=0.1,0.1", "the value 0.1 stands there twice"),
        ("speed=0.3..0.1", "expected the lower end first, got 0.3..0.1"),
        ("speed=[", "expected values"),
        ("speed={a: 1}", "expected values"),
        ("world=1..2", "'world' has names"),
    ],
)
def test_what_is_wrong_with_a_parameter_is_told(text: str, message: str):
    """With the option that it stands in."""
    with pytest.raises(InputError) as error:
        parse_parameter(text)
    assert message in str(error.value)
    assert "--vary" in str(error.value)


def test_truth_and_one_are_different_values():
    """Python takes them for equal."""
    assert parse_parameter("x=1,true") == Choices("x", (1, True))


def test_intervals_give_values_of_six_digits_within_their_ends():
    """So that the command that repeats a run can be typed."""
    one = Interval("speed", 0.1, 0.26)
    assert [one.at(share) for share in (0.0, 0.123456789, 0.999999999)] == [0.1, 0.119753, 0.26]
    whole = Interval("legs", 1, 3, is_whole=True)
    assert [whole.at(share) for share in (0.0, 0.33, 0.34, 0.67, 0.99)] == [1, 1, 2, 3, 3]


def test_a_file_has_parameters_as_a_mapping():
    """Lists, or texts of intervals."""
    assert read_parameters({"speed": "0.1..0.2", "legs": [1, 2]}, "ranges.yaml") == (
        Interval("speed", 0.1, 0.2),
        Choices("legs", (1, 2)),
    )


def test_a_parameter_is_varied_once():
    """Twice is a mistake."""
    with pytest.raises(InputError, match="'speed' is given twice"):
        refuse_repeated([Choices("speed", (1,)), Choices("speed", (2,))])
