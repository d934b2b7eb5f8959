"""Real ROS types, filled and read by name."""

import random
import sys

import pytest
from sensor_msgs.msg import Image, Imu
from std_msgs.msg import Byte, ByteMultiArray

from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.expressions.expression import Expression, Text, resolve
from bt_mission.language.message_types import ListOf, Scalar, UnknownType
from bt_mission.ros.interface_types import (
    FillError,
    action_type,
    fields,
    fill,
    installed,
    message_type,
    read,
    service_type,
    shape_of,
    shapes,
)

TURN = action_type("bt_mission_interfaces/action/Turn")
NAVIGATE = action_type("nav2_msgs/action/NavigateToPose")
FOLLOW = action_type("nav2_msgs/action/FollowWaypoints")


def test_every_short_name_has_an_installed_type():
    """And its goal has fields."""
    types = {short.type for short in ACTION_NAMES.values()}
    assert types <= set(installed("action"))
    for name in types:
        assert shapes(name).sends.fields


@pytest.mark.parametrize(
    ("find", "name", "message"),
    [
        (
            action_type,
            "bt_mission_interfaces/action/Tern",
            (
                "the action type bt_mission_interfaces/action/Tern is not installed; did you mean "
                "'bt_mission_interfaces/action/Turn'?"
            ),
        ),
        (
            service_type,
            "std_srvs/srv/SetBol",
            "the service type std_srvs/srv/SetBol is not installed; did you mean 'std_srvs/srv/Set",
        ),
        (
            message_type,
            "std_msgs/msg/Bol",
            "the message type std_msgs/msg/Bol is not installed; did you mean 'std_msgs/msg/Bool'",
        ),
        (
            action_type,
            "no_such_package/action/X",
            "the action type no_such_package/action/X is not",
        ),
        (action_type, "antigravity/action/X", "the action type antigravity/action/X is not insta"),
        (action_type, "x" * 5000 + "/action/X", "the action type xxxxx"),
        (action_type, "../../etc/action/X", "expected a type such as nav2_msgs/action/Spin, got "),
        (action_type, "std_msgs/msg/String", "expected a type such as nav2_msgs/action/Spin, got "),
        (action_type, "", "expected a type such as nav2_msgs/action/Spin, got ''"),
        (shapes, "Turn", "expected a type such as nav2_msgs/action/Spin"),
        (
            message_type,
            "std_srvs/srv/SetBool",
            "expected a type such as std_msgs/msg/String, got '",
        ),
    ],
)
def test_a_type_that_is_not_installed_is_refused(find, name, message):
    """Nothing is imported that the ament index does not list."""
    with pytest.raises(UnknownType) as caught:
        find(name)
    assert str(caught.value).startswith(message)
    assert "antigravity" not in sys.modules


def test_shapes_of_every_kind_of_type():
    """A service has two messages, a topic one, everything else is an action."""
    result = shapes("std_srvs/srv/SetBool")
    assert result.sends.name == "the request of std_srvs/srv/SetBool"
    assert list(result.keeps.fields) == ["success", "message"]
    assert result.asks is None
    message = shapes("std_msgs/msg/Bool")
    assert message.sends is message.keeps is message.asks
    turn = shapes("bt_mission_interfaces/action/Turn")
    assert turn.asks is not None
    parts = [part.name.split()[1] for part in (turn.sends, turn.keeps, turn.asks)]
    assert parts == ["goal", "result", "feedback"]


def test_seconds_and_points_are_filled():
    """A number is a duration, three numbers are a point."""
    goal = fill(action_type("nav2_msgs/action/BackUp").Goal(),
                {"target": [0.5, 0, 0], "time_allowance": 2.25})  # fmt: skip
    time = goal.time_allowance
    assert (goal.target.x, time.sec, time.nanosec) == (0.5, 2, 250_000_000)


def test_fields_have_their_names_in_interface_files():
    """As `ros2 interface show` says them."""
    assert fields(TURN.Goal) == {"angle": "float32", "angular_velocity": "float32"}
    assert fields(FOLLOW.Goal)["poses"] == "geometry_msgs/PoseStamped[]"


def test_shapes_know_limits_and_sizes():
    """From the generated classes, nested messages included."""
    imu = shape_of(Imu)
    assert imu.fields["angular_velocity_covariance"] == ListOf(Scalar("float64", "number"), size=9)
    loops = shape_of(FOLLOW.Goal).fields["number_of_loops"]
    assert loops == Scalar("uint32", "integer", 0, 2**32 - 1)
    assert shape_of(TURN.Goal).name == "the goal of bt_mission_interfaces/action/Turn"


def test_a_goal_is_filled_from_resolved_values():
    """Expressions have been computed; texts are read as their fields want them."""
    goal = {"angle": Text("-2 * x"), "angular_velocity": Expression("x / 10")}
    message = fill(TURN.Goal(), resolve(goal, {"x": 5}, random.Random(0)))
    assert (message.angle, message.angular_velocity) == (-10.0, 0.5)


def test_lists_of_three_numbers_become_poses():
    """In a single field and in a list, with texts among the numbers, or from a variable."""
    message = fill(FOLLOW.Goal(), {"poses": [[1.5, 0.5, 180], {"header": {"frame_id": "odom"}}]})
    first, second = message.poses
    assert (first.header.frame_id, first.pose.position.x) == ("map", 1.5)
    assert (first.pose.orientation.z, second.header.frame_id) == (pytest.approx(1.0), "odom")
    goal = resolve({"pose": Text("$place"), "behavior_tree": Text("a-$n.xml")},
                   {"place": [1, 2, 0], "n": 3}, random.Random(0))  # fmt: skip
    message = fill(NAVIGATE.Goal(), goal)
    assert (message.pose.pose.position.y, message.behavior_tree) == (2.0, "a-3.xml")


def test_what_does_not_fit_is_told_by_field():
    """All of it, and nothing is set; so is a variable without a value, such as an output."""
    goal = resolve({"angle": Text("$obstacle")}, {"n": 1}, random.Random(0))
    with pytest.raises(FillError, match=r"angle: '\$obstacle' has no value \(values: n\)"):
        fill(TURN.Goal(), goal)
    message = TURN.Goal()
    with pytest.raises(FillError) as caught:
        fill(message, {"angle": float("nan"), "speed": 1})
    assert str(caught.value) == (
        "angle: expected a finite number (float32), got nan; "
        "speed: no field 'speed' in the goal of bt_mission_interfaces/action/Turn "
        "(its fields: angle, angular_velocity)"
    )
    assert message == TURN.Goal()


def test_bytes_and_arrays_are_filled_and_read():
    """Whatever a message may hold comes back as plain values."""
    assert read(fill(Byte(), {"data": 7}), "data") == 7
    assert fill(ByteMultiArray(), {"data": [1, 2]}).data == [b"\x01", b"\x02"]
    image = fill(Image(), {"data": [1, 2, 255]})
    assert read(image, "data") == [1, 2, 255]
    imu = fill(Imu(), {"orientation_covariance": [1] * 9})
    assert read(imu, "orientation_covariance") == [1.0] * 9


def test_nested_fields_are_read_by_dotted_names():
    """Messages come as mappings."""
    feedback = NAVIGATE.Feedback()
    assert read(feedback, "current_pose.pose.orientation.w") == 1.0
    assert read(feedback, "navigation_time") == {"sec": 0, "nanosec": 0}
    missed = FOLLOW.Result()
    assert read(missed, "missed_waypoints") == []
