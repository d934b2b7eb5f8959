"""Lines of a form, and the values typed into them."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.commands.graph.form_fields import FormField, lines_of, texts
from bt_mission.commands.graph.interface_description import describe_interface
from bt_mission.language.message_types import ListOf, MessageShape, Scalar, nested
from bt_mission.ros.interface_types import fill


def line(shape: Any, default: Any = 0) -> FormField:
    """A line for one field."""
    return FormField("name", shape, "", default, "what it is")


@pytest.mark.parametrize(
    ("type_name", "names"),
    [
        ("nav2_msgs/action/BackUp", ["target", "speed", "time_allowance"]),
        ("nav2_msgs/action/FollowWaypoints", ["number_of_loops", "goal_index", "poses"]),
        ("bt_mission_interfaces/action/Turn", ["angle", "angular_velocity"]),
    ],
)
def test_every_field_of_a_goal_has_one_line(type_name: str, names: list[str]) -> None:
    """A point, a duration and a list are one."""
    assert [field.name for field in lines_of(describe_interface(type_name).part("goal"))] == names


def test_messages_without_a_short_form_are_unfolded() -> None:
    """By dotted names, which come together again."""
    lines = lines_of(describe_interface("geometry_msgs/msg/TwistStamped").part("message"))
    header = [f"header.{name}" for name in ("stamp.sec", "stamp.nanosec", "frame_id")]
    twist = [f"twist.{part}.{axis}" for part in ("linear", "angular") for axis in "xyz"]
    assert [field.name for field in lines] == header + twist
    assert nested({"a.b.c": 1, "a.d": 2, "e": 3}) == {"a": {"b": {"c": 1}, "d": 2}, "e": 3}


@pytest.mark.parametrize(
    ("shape", "text", "value", "fault"),
    [
        (Scalar("int8", "integer", -128, 127), "7", 7, ""),
        (Scalar("int8", "integer", -128, 127), "300", None, "the number 300 is outside int8"),
        (Scalar("int8", "integer", -128, 127), "1.5", None, "expected an integer (int8)"),
        (Scalar("float64", "number"), "1e3", 1000.0, ""),
        (Scalar("float64", "number"), ".nan", None, "expected a finite number"),
        (Scalar("string", "text"), "7: [", "7: [", ""),
        (Scalar("string<=3", "text", most=3), "long", "long", "expected at most 3 characters"),
        (ListOf(Scalar("int8", "integer", 0, 9)), "[1, 2]", [1, 2], ""),
        (ListOf(Scalar("int8", "integer", 0, 9)), "[1, 22]", None, "1: the number 22 is outside"),
        (MessageShape("geometry_msgs/Point", {}), "[1, 2, 3]", {"x": 1.0, "y": 2.0, "z": 3.0}, ""),
        (
            MessageShape("builtin_interfaces/Duration", {}),
            "1.5",
            {"sec": 1, "nanosec": 5 * 10**8},
            "",
        ),
    ],
)
def test_what_is_typed_is_read_as_the_field_wants_it(
    shape: Any, text: str, value: Any, fault: str
) -> None:
    """A text as it stands, the rest as YAML; what is wrong is said in the words of faults."""
    result, output = line(shape).read(text)
    assert output.startswith(fault)
    assert bool(output) == bool(fault)
    if not fault:
        assert result == value


def test_notes_say_how_to_write_it_and_its_limits() -> None:
    """Before what the author says; limits of 32 bits and more are left to the type's name."""
    assert line(Scalar("uint8", "integer", 0, 255)).note == "0 to 255; what it is"
    assert line(Scalar("int32", "integer", -(2**31), 2**31 - 1)).note == "what it is"
    assert line(ListOf(Scalar("bool", "bool"), size=3)).note == "a list: [...]; 3 items; what it is"
    assert (
        line(MessageShape("geometry_msgs/Point", {})).note == "a point [x m, y m, z m]; what it is"
    )


def test_a_goal_that_is_given_fills_the_lines() -> None:
    """In a form in which it can be read back."""
    part = describe_interface("nav2_msgs/action/FollowWaypoints").part("goal")
    lines = lines_of(part)
    given = {"goal_index": 2, "poses": [{"header": {"frame_id": "it's"}}]}
    typed = texts(lines, given)
    assert typed == {"goal_index": "2", "poses": "[{header: {frame_id: 'it''s'}}]"}
    read = {field.name: field.read(typed[field.name])[0] for field in lines if field.name in typed}
    assert fill(part.cls(), nested(read)) == fill(part.cls(), given)
