"""The table of faults: every row can be written, called, drawn and read."""

from __future__ import annotations

import inspect

import pytest

from bt_mission.base.units import UNITS
from bt_mission.scenarios.faults import FAULTS, Faults
from bt_mission.scenarios.faults.drawing import DEFAULT_KINDS, GRAPH_FAULTS, GROUPS
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.kind import FaultKind
from bt_mission.scenarios.faults.world import OF_THE_WORLD

KINDS = pytest.mark.parametrize("kind", FAULTS.values(), ids=FAULTS)


@KINDS
def test_a_row_says_what_it_is(kind: FaultKind) -> None:
    """A number has a unit, or it is a share, a count or a code."""
    bare = {"share", "every", "times", "goals", "on", "code", "grip"}
    relative = {"left_radius", "right_radius", "separation"}
    assert kind.text.endswith(".")
    assert kind.area
    for parameter in kind.parameters.values():
        assert parameter.unit in ("", *UNITS)
        if parameter.form in ("number", "integer", "numbers") and not parameter.unit:
            assert parameter.name in bare | relative or kind.name == "camera_noise", parameter


@KINDS
def test_a_row_is_a_method_of_the_fixture(kind: FaultKind) -> None:
    """With its parameters, so that `help` shows them."""
    method = getattr(Faults(), kind.name)
    assert kind.name in dir(Faults())
    assert list(inspect.signature(method).parameters)[: len(kind.declared)] == [
        parameter.name for parameter in kind.declared
    ]
    assert method.__doc__ == kind.text


@KINDS
def test_a_row_has_a_group_but_for_those_of_the_world(kind: FaultKind) -> None:
    """Obstacles have ranges of their own; of a fleet, each is for one robot."""
    assert bool(kind.group) == (kind.name not in OF_THE_WORLD)


def test_groups_that_are_named_are_there() -> None:
    """The default ones."""
    assert set(DEFAULT_KINDS) < set(GROUPS)
    assert set(GRAPH_FAULTS) < set(FAULTS)


def test_an_unknown_fault_is_no_method() -> None:
    """As of any object."""
    with pytest.raises(AttributeError, match="unknown fault 'dorp'"):
        Faults().dorp  # noqa: B018 - it raises


def test_how_a_fault_is_written_shows_units_and_choices() -> None:
    """Arguments by position stand without their names."""
    assert FAULTS["delay"].usage == (
        "delay TOPIC <by s> [jitter s] [in_order false] [receiver RECEIVER] [lasting s]"
    )
    assert FAULTS["push"].usage == "push [<ahead N>] [<left N>] [seconds s] [torque Nm]"
    assert FAULTS["block_wheel"].usage == "block_wheel left|right|both [lasting s]"
    assert FAULTS["fail_service"].usage == "fail_service SERVICE [FIELD=VALUE]... [lasting s]"


def test_what_only_python_can_give_is_left_out() -> None:
    """Exceptions and functions."""
    assert list(FAULTS["raise_in_leaf"].parameters) == ["leaf", "method", "on"]
    assert list(FAULTS["abort_goal"].parameters) == ["action", "code", "message"]
    assert FAULTS["corrupt"].parameters["how"].choices[0] == "nan"


@pytest.mark.parametrize(
    ("name", "arguments", "options", "message"),
    [
        ("drop", ("scan",), {"share": 1.5}, "a number above 0 and at most 1 for 'share', got 1.5"),
        ("drop", ("scan",), {"share": 0.5, "every": 2}, "give 'share' or 'every', not both"),
        ("drop", ("scan",), {"lasting": -1}, "a number in s above 0 for 'lasting', got -1"),
        ("drop", (5,), {}, "the name of a topic for 'topic', got 5"),
        ("delay", ("scan", -0.1), {}, "a number in s from 0 up for 'by', got -0.1"),
        ("delay", ("scan", float("nan")), {}, "a number in s from 0 up for 'by', got nan"),
        ("duplicate", ("scan",), {"times": 1}, "an integer from 2 up for 'times', got 1"),
        ("corrupt", ("scan", "wrong"), {}, "expected one of nan, inf, zeros"),
        ("corrupt", ("scan", max), {"field": "ranges"}, "'field' needs a named corruption"),
        ("set_fields", ("odom",), {}, "give fields, such as error_code=906"),
        ("set_result", ("turn",), {}, "give fields, such as error_code=906"),
        ("reject_goals", ("turn", 0), {}, "an integer from 1 up for 'goals', got 0"),
        ("reject_goals", ("turn", 1.5), {}, "an integer from 1 up for 'goals', got 1.5"),
        ("repeat_answers", ("turn", "feedback"), {}, "one of goal, cancel, result for 'part'"),
        ("raise_in_leaf", ("turn",), {"method": "x"}, "one of initialise, update, terminate"),
        ("raise_in_maneuver", ("turn",), {"method": "x"}, "one of step, feedback, result"),
        ("raise_in_leaf", ("turn", "no error"), {}, "an object of Python for 'error'"),
        ("lidar_noise", (-1,), {}, "a number in m from 0 to 10 for 'sigma', got -1"),
        ("lidar_blind", (), {}, "give sectors, such as (-20, 20), or a share"),
        ("lidar_blind", ((1, 2, 3),), {}, "2 numbers in deg from -360 to 360"),
        ("odometry_error", (), {}, "give left_radius, right_radius or separation"),
        ("slip_wheel", ("left", 2), {}, "a number from 0 to 1 for 'grip', got 2"),
        ("slip_wheel", ("front",), {}, "one of left, right, both for 'wheel', got 'front'"),
        ("battery_charge", (2,), {}, "a number from 0 to 1 for 'share', got 2"),
        ("push", (1,), {"seconds": 0}, "a number in s above 0 for 'seconds', got 0"),
        ("spawn_box", (), {}, "give a place, as ahead=1.0 (and left=) or at=(x, y)"),
        ("spawn_box", (1,), {"at": (1, 2)}, "give a place, as ahead=1.0"),
        ("move_box", ("box", 1), {"speed": 3}, "a number in m/s above 0 and at most 2"),
        ("jump_clock", (0,), {}, "expected seconds other than 0"),
    ],
)
def test_what_a_fault_does_not_take_is_refused_when_it_is_made(
    name: str, arguments: tuple[object, ...], options: dict[str, object], message: str
) -> None:
    """With what it takes."""
    with pytest.raises(ScenarioError) as caught:
        FAULTS[name].make(*arguments, **options)
    assert str(caught.value).startswith(f"{name}: ")
    assert message in str(caught.value)


def test_a_call_that_python_refuses_is_a_type_error() -> None:
    """As of any function."""
    with pytest.raises(TypeError, match="missing a required argument: 'topic'"):
        Faults().drop()
    with pytest.raises(TypeError, match="unexpected keyword argument 'shar'"):
        Faults().drop("scan", shar=1)
