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


def test_values_become_what_the_fields_want():
    """Whole numbers become floats in float fields; lists and mappings are gone through."""
    values, problems = conformed(
        {
            "count": -128,
            "speed": 1,
            "on": True,
            "label": "abcde",
            "three": (1, 2, 3.5),
            "few": [],
            "inner": {"x": 2},
        }
    )
    assert problems == []
    assert values["speed"] == 1.0
    assert isinstance(values["speed"], float)
    assert values["three"] == [1.0, 2.0, 3.5]
    assert values["inner"] == {"x": 2.0}


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"count": 1.5}, "count: expected an integer (int8), got 1.5; round(...)"),
        ({"count": 128}, "count: the number 128 is outside int8, -128 to 127"),
        ({"count": True}, "count: expected an integer (int8), got true"),
        ({"speed": "x"}, "speed: expected a number (float32), got string 'x'"),
        ({"speed": math.nan}, "speed: expected a finite number (float32), got nan"),
        ({"speed": 1e39}, "speed: the number 1e+39 is outside float32, -3.4e+38 to 3.4e+38"),
        ({"on": 1}, "on: expected a boolean (bool), got the number 1"),
        ({"label": 5}, "label: expected a string (string<=5), got the number 5"),
        ({"label": "abcdef"}, "label: expected at most 5 characters, got 6"),
        ({"three": [1, 2]}, "three: expected 3 items (float32[3]), got 2"),
        ({"three": 1}, "three: expected a list (float32[3]), got the number 1"),
        ({"three": [1, "x", 3]}, "three.1: expected a number (float32), got string 'x'"),
        ({"few": [1, 2, 3]}, "few: expected at most 2 items (int8[<=2]), got 3"),
        ({"inner": 3}, "inner: expected a mapping (a/Inner), got the number 3"),
        ({"inner": {"y": 1}}, "inner.y: no field 'y' in a/Inner (its fields: x)"),
        ({"cuont": 1}, "cuont: no field 'cuont' in the goal of a/action/B (its fields: count, "),
        ({"poses": [[1, 2]]}, "poses.0: expected a pose [x m, y m, yaw deg], got a list of 2"),
        ({"poses": [[1, 2, "x"]]}, "poses.0.2: expected a number (float64), got string 'x'"),
        ({"at": [1, 2]}, "at: expected a point [x m, y m, z m], got a list of 2"),
        ({"at": [1, 2, True]}, "at.2: expected a number (float64), got true"),
        ({"at": 3}, "at: expected a mapping (geometry_msgs/Point), got the number 3"),
        ({"limit": True}, "limit: expected a mapping (builtin_interfaces/Duration), got true"),
        ({"limit": math.inf}, "limit: expected a finite number of seconds, got inf"),
        ({"limit": 3e9}, "limit: 3e+09 s are outside builtin_interfaces/Duration, -2147483647"),
        ({"poses": [5]}, "poses.0: expected a mapping (geometry_msgs/PoseStamped), got the"),
    ],
)
def test_what_does_not_fit_is_told_with_its_path(values, problem):
    """And with what would fit."""
    _, (found,) = conformed(values)
    assert found.startswith(problem)


def test_all_problems_come_at_once():
    """In the order of the values."""
    _, problems = conformed({"count": "x", "what": 1, "three": ["a", "b"]})
    assert [problem.partition(":")[0] for problem in problems] == [
        "count",
        "what",
        "three",
        "three.0",
        "three.1",
    ]


def test_three_numbers_are_a_pose_on_the_map():
    """X and y in metres, yaw in degrees, left positive."""
    values, problems = conformed({"poses": [[1, 2.5, 90]]})
    assert problems == []
    (pose,) = values["poses"]
    assert pose["header"] == {"frame_id": "map"}
    assert pose["pose"]["position"] == {"x": 1.0, "y": 2.5}
    turn = pose["pose"]["orientation"]
    assert math.degrees(2 * math.atan2(turn["z"], turn["w"])) == pytest.approx(90)


def test_three_numbers_are_a_point():
    """Where the field is one; field by field as well."""
    assert conformed({"at": [1, 2, 3.5]}) == ({"at": {"x": 1.0, "y": 2.0, "z": 3.5}}, [])
    assert conformed({"at": {"z": 1}}) == ({"at": {"z": 1.0}}, [])


@pytest.mark.parametrize(
    ("seconds", "sec", "nanosec"),
    [(2, 2, 0), (0.25, 0, 250_000_000), (-0.25, -1, 750_000_000), (0.9999999999, 1, 0)],
)
def test_a_number_is_a_duration(seconds, sec, nanosec):
    """Of seconds; the nanoseconds are never negative."""
    assert conformed({"limit": seconds}) == ({"limit": {"sec": sec, "nanosec": nanosec}}, [])


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
    with pytest.raises(UnknownField, match=r"'count\.x': int8 has no fields of its own"):
        field_at(GOAL, "count.x")


def test_types_of_fields_in_expressions():
    """A nested message has none."""
    assert value_type(INT8) == "integer"
    assert value_type(GOAL.fields["few"]) == "list"
    assert value_type(POSE) is None
