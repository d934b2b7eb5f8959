"""Numbers with units in missions: converted into the unit of their field, or refused."""

from __future__ import annotations

import copy
import random
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.units import UNITS, converted, in_base, near_unit
from bt_mission.language.expressions.expression import Expression, Text
from bt_mission.language.expressions.units import Measured
from bt_mission.language.inputs import overridden
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

RNG = random.Random(0)


def node(text: str, head: str = "") -> Any:
    """Return the only node of a mission."""
    return load(f"mission: m\n{head}tree:\n  {text}\n").tree


def problems(text: str, head: str = "") -> list[str]:
    """Return everything that is said of a mission of one node."""
    _, faults = examine(f"mission: m\n{head}tree:\n  {text}\n")
    return [f"{fault.line}:{fault.column} {fault.message}; {fault.hint}" for fault in faults]


def test_every_unit_is_converted_there_and_back() -> None:
    """Within rounding."""
    for unit, (_, base) in UNITS.items():
        assert converted(in_base(3.7, unit), base, unit) == pytest.approx(3.7)
    assert near_unit("sec") == "write 's'"
    assert near_unit("degs") == "did you mean 'deg'?"


def test_times_of_nodes_may_have_units() -> None:
    """A quantity alone is a constant; a limit that is no time is refused."""
    assert node("wait: 500 ms").seconds == 0.5
    assert node("{timeout: 2 min, do: {wait: 1 s + 250 ms}}").seconds == 120.0
    turn = node("{turn: {angle: 90}, timeout: 30 s}", "limits: {acceptance_timeout: 1500 ms}\n")
    assert (turn.timeout, turn.acceptance_timeout) == (30.0, 1.5)
    with pytest.raises(InputError, match=r"the field is in s \(s, ms, min\), got 3 m"):
        node("wait: 3 m")
    with pytest.raises(InputError, match="expected an operator or the end, got 'sec'; write 's'"):
        node("wait: 30 sec")
    with pytest.raises(InputError, match="expected seconds above 0, got the number -5"):
        node("{turn: {angle: 90}, timeout: -5 s}")


def test_fields_of_goals_take_units_by_their_interface() -> None:
    """`turn` is in degrees, `spin` in radians, and a pose has metres and degrees."""

    def value(field: Any) -> Any:
        assert isinstance(field, Text)
        assert isinstance(field.expression, Expression)
        return field.expression.evaluate({}, RNG)

    assert value(node("turn: {angle: 1 rad}").sent["angle"]) == pytest.approx(57.29578)
    assert value(node("spin: {target_yaw: 90 deg}").sent["target_yaw"]) == pytest.approx(1.5707963)
    assert value(node("spin: {time_allowance: 1 min}").sent["time_allowance"]) == 60.0
    pose = node("navigate_to_pose: {pose: [50 cm, 1 m, 1 rad]}").sent["pose"]
    assert [value(number) for number in pose] == [0.5, 1.0, pytest.approx(57.29578)]
    poses = node("follow_waypoints: {poses: [[0, 10 cm, 90 deg]]}").sent["poses"]
    assert [value(number) for number in poses[0][1:]] == [0.1, 90.0]
    twist = "publish: {topic: t, type: geometry_msgs/msg/Twist, message: {angular: {z: 90 deg/s}}}"
    assert value(node(twist).sent["angular"]["z"]) == pytest.approx(1.5707963)
    # A text stays a text.
    assert node("find_colour: {colour: 3 m}").sent["colour"].template.text == "3 m"


def test_conditions_on_messages_take_units() -> None:
    """Each comparison is in the unit of the field in it."""
    turn = node(
        "{turn: {angle: 90}, cancel_when: current_angle > 1 rad or remaining_angle < 5 deg}"
    )
    condition = turn.cancel_when
    assert condition.text.startswith("current_angle > 1 rad")

    def met(current: float, remaining: float) -> Any:
        fields = {"current_angle": current, "remaining_angle": remaining}
        return condition.evaluate({}, RNG, fields)

    assert [met(57, 33), met(58, 32), met(0, 4.9)] == [False, True, True]
    topic = "wait_for: {topic: scan, type: sensor_msgs/msg/LaserScan, until: range_min > 10 cm}"
    wait = node(f"{{{topic}, timeout: 5 s}}")
    assert wait.condition.evaluate({}, RNG, {"range_min": 0.12}) is True


def test_what_does_not_fit_is_reported_at_its_place() -> None:
    """With the column in the text."""
    assert problems("{turn: {angle: 10 cm}, timeout: 9}") == [
        "3:18 the field is in deg (rad, deg), got 10 cm; None"
    ]
    assert problems("{turn: {angle: 9}, timeout: 9, cancel_when: current_angle > 3 s}") == [
        "3:61 units do not match: rad and s; None"
    ]
    problem = problems("set: {a: 90 deg}")[0]
    assert problem.startswith("3:12 90 deg: the unit cannot be converted")


def test_inputs_keep_their_units() -> None:
    """An angle as it is written, everything else in metres and seconds."""
    head = "inputs: {a: 90 deg, gap: 50 cm, pose: [1 m, 20 cm, 1 rad], word: 3 apples}\n"
    mission = load(f"mission: m\n{head}tree: {{wait: 1}}\n")
    assert mission.inputs == {
        "a": 90.0,
        "gap": 0.5,
        "pose": [1.0, 0.2, pytest.approx(57.29578)],
        "word": "3 apples",
    }
    angle = mission.inputs["a"]
    assert isinstance(angle, Measured)
    again = copy.deepcopy(angle)
    assert (again, again.unit) == (90.0, "deg")
    with pytest.raises(InputError, match="an angle in a list is the yaw of a pose"):
        load("mission: m\ninputs: {a: [90 deg]}\ntree: {wait: 1}\n")


def test_an_input_in_degrees_is_not_for_a_field_in_radians() -> None:
    """Nothing is converted behind the author's back."""
    head = "inputs: {angle: 90 deg}\n"
    assert problems("{turn: {angle: $angle}, timeout: 9}", head) == []
    assert problems("{spin: {target_yaw: radians($angle)}, timeout: 9}", head) == []
    output = problems("{spin: {target_yaw: -$angle}, timeout: 9}", head)
    assert "4:24 '$angle' is in deg, the field is in rad; write 'radians($angle)'" in output
    output = problems("{move: {secs: angle}, timeout: 9}", head)
    assert "4:17 'angle' is in deg, the field is in s; None" in output


@pytest.mark.parametrize(
    ("given", "value"),
    [("45", 45.0), ("1 rad", pytest.approx(57.29578)), ("0.5 deg", 0.5), (30, 30.0)],
)
def test_a_value_for_an_input_is_in_the_unit_of_its_default(given: Any, value: Any) -> None:
    """Or is converted into it."""
    values, faults = overridden({"a": Measured(90, "deg")}, {"a": given})
    assert (values, faults) == ({"a": value}, [])
    assert isinstance(values["a"], Measured)
    assert values["a"].unit == "deg"


@pytest.mark.parametrize(
    ("default", "given", "message"),
    [
        (Measured(90, "deg"), "3 s", "the input is in deg, got s"),
        (90, "3 deg", "the default of the input has no unit, got deg"),
        (Measured(90, "deg"), "fast", "input 'a' expects a number, got string 'fast'"),
        (Measured(90, "deg"), ".inf", "input 'a' expects a number, got string '.inf'"),
        (0.2, float("nan"), "input 'a' expects a number, got the number nan"),
        ("A", 3, "input 'a' expects a string, got the number 3"),
    ],
)
def test_a_value_of_another_type_or_unit_is_refused(default: Any, given: Any, message: str) -> None:
    """The default says which it is; a caret stands under the value."""
    values, (fault,) = overridden({"a": default, "b": 1}, {"a": given})
    assert (values, fault.message) == ({"a": default, "b": 1}, message)
    assert (fault.file, fault.source, fault.column) == ("--set", f"a={given}", 3)
