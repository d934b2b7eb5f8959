"""Values against the shapes of messages, without any ROS."""

import math
from typing import Any

import pytest

from bt_mission.language.expressions.expression import Text
from bt_mission.language.message_types import (
    ListOf,
    MessageShape,
    Scalar,
    Unknowable,
    UnknownField,
    conform,
    field_at,
    value_type,
)

INT8 = Scalar("int8", "integer", -128, 127)
FLOAT = Scalar("float32", "number", -3.4e38, 3.4e38)
POSE = MessageShape("geometry_msgs/PoseStamped", {})
GOAL = MessageShape(
    "the goal of a/action/B",
    {
        "count": INT8,
        "speed": FLOAT,
        "on": Scalar("bool", "bool"),
        "label": Scalar("string<=5", "text", most=5),
        "three": ListOf(FLOAT, size=3),
        "few": ListOf(INT8, most=2),
        "poses": ListOf(POSE),
        "inner": MessageShape("a/Inner", {"x": FLOAT}),
        "at": MessageShape("geometry_msgs/Point", {"x": FLOAT, "y": FLOAT, "z": FLOAT}),
        "limit": MessageShape("builtin_interfaces/Duration", {"sec": INT8, "nanosec": INT8}),
    },
)


def conformed(values: Any) -> Any:
    """Return what values become, and the problems in them."""
    problems: list[Any] = []

    def read(path, shape, text):
        if text.text == "?":
            raise Unknowable
        return text.text

    return conform(GOAL, values, read, problems.append), [str(problem) for problem in problems]


def test_three_numbers_are_a_pose_on_the_map():
    """X and y in metres, yaw in degrees, left positive."""
    values, problems = conformed({"poses": [[1, 2.5, 90]]})
    assert problems == []
    (pose,) = values["poses"]
    assert pose["header"] == {"frame_id": "map"}
    assert pose["pose"]["position"] == {"x": 1.0, "y": 2.5}
    turn = pose["pose"]["orientation"]
    assert math.degrees(2 * math.atan2(turn["z"], turn["w"])) == pytest.approx(90)


def test_a_text_is_read_as_its_field_wants_it():
    """What cannot be known yet is passed over, also in the middle of a pose."""
    values, problems = conformed(
        {"label": Text("hi"), "speed": Text("?"), "poses": [[1, Text("?"), 0]]}
    )
    assert problems == []
    assert (values["label"], values["speed"], values["poses"]) == ("hi", None, [None])


def test_fields_are_found_by_dotted_names():
    """Or told with those that are there."""
    assert field_at(GOAL, "inner.x") is FLOAT
    with pytest.raises(UnknownField, match="no field 'z' in a/Inner"):
        field_at(GOAL, "inner.z")
    with pytest.raises(UnknownField, match=r"'count\.x': int8 has no fields"):
        field_at(GOAL, "count.x")


def test_types_of_fields_in_expressions():
    """A nested message has none."""
    assert value_type(INT8) == "integer"
    assert value_type(GOAL.fields["few"]) == "list"
    assert value_type(POSE) is None
