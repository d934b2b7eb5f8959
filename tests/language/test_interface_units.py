"""The units of fields of interfaces."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from bt_mission.language.interface_units import SI, unit_of_field

OURS = "bt_mission_interfaces/action"


@pytest.mark.parametrize(
    ("interface", "part", "path", "unit"),
    [
        (f"{OURS}/Turn", "goal", ["angle"], "deg"),
        (f"{OURS}/Turn", "feedback", ["current_angle"], "deg"),
        (f"{OURS}/FindColour", "goal", ["colour"], None),
        ("nav2_msgs/action/NavigateToPose", "goal", ["pose", 2], "deg"),
        ("nav2_msgs/action/NavigateToPose", "goal", ["pose", "pose", "position", "x"], SI),
        ("nav2_msgs/action/FollowWaypoints", "goal", ["poses", 0, 2], "deg"),
        ("nav2_msgs/action/FollowWaypoints", "goal", ["poses", 0, 1], "m"),
        ("nav2_msgs/action/BackUp", "goal", ["target", 0], "m"),
        ("nav2_msgs/action/BackUp", "goal", ["time_allowance"], "s"),
        ("geometry_msgs/msg/Twist", "message", ["angular", "z"], SI),
        ("sensor_msgs/msg/LaserScan", "message", ["angle_min"], SI),
        ("sensor_msgs/msg/NavSatFix", "message", ["latitude"], "deg"),
        ("control_msgs/action/GripperCommand", "goal", ["command", "position"], SI),
        ("std_msgs/msg/Float64", "message", ["data"], ""),
        ("std_msgs/msg/String", "message", ["data"], None),
        ("nobody_msgs/msg/Nothing", "message", ["data"], ""),
        ("nonsense", "goal", ["a", 3, "b"], ""),
        (f"{OURS}/Turn", "goal", ["nothing", "here"], ""),
    ],
)
def test_the_unit_of_a_field(
    interface: str, part: str, path: Sequence[str | int], unit: str | None
) -> None:
    """From our comment, by what it is, or by REP 103; none where nothing is known."""
    assert unit_of_field(interface, part, tuple(path)) == unit
