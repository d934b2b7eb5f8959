"""Variables that follow topics, over real rclpy on a virtual clock."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces.msg import MissionDetails
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Int32, String

from bt_mission.base.errors import BtMissionError
from bt_mission.ros import status_publisher
from bt_mission.ros.status_publisher import DETAILS

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NUMBER = "{topic: n, type: std_msgs/msg/Int32, field: data, as: n}"
GUARD = f"mission: m\nfollow: {NUMBER}\ntree:\n  guard: n < 5\n  do: {{wait: 60}}\n"


@pytest.mark.parametrize("qos", [10, qos_profile_sensor_data, LATCHED])
def test_a_value_reaches_the_tree_from_every_publisher(ros: Any, qos: Any) -> None:
    """Reliable or not; the guard ends its node at the tick after the message."""
    numbers = ros.client.create_publisher(Int32, "n", qos)
    run = ros.mission(GUARD)
    ros.run(0.1)
    numbers.publish(Int32(data=4))
    ros.run(1.0)
    assert run.executive.status == "running"
    numbers.publish(Int32(data=5))
    ros.until(lambda: run.is_done, 1.0)
    assert run.executive.reason == "'m' does not hold (n = 5)"


def test_what_was_said_before_of_a_latched_topic_counts(ros: Any) -> None:
    """Also where its publisher comes after the mission."""
    run = ros.mission(GUARD)
    ros.run(0.5)
    ros.client.create_publisher(Int32, "n", LATCHED).publish(Int32(data=7))
    ros.until(lambda: run.is_done, 3.0)
    assert run.executive.reason == "'m' does not hold (n = 7)"


def test_names_lie_in_the_namespace_of_the_robot(ros: Any) -> None:
    """Two robots follow two topics."""
    runs = [ros.mission(GUARD, namespace=name) for name in ("r1", "r2")]
    ros.client.create_publisher(Int32, "/r2/n", LATCHED).publish(Int32(data=7))
    ros.until(lambda: runs[1].is_done, 3.0)
    assert runs[1].executive.reason == "'m' does not hold (n = 7)"
    ros.until(lambda: runs[0].is_done, 6.0)
    assert "no message of /r1/n yet, it has no publisher" in runs[0].executive.reason


def test_an_array_comes_as_a_list(ros: Any) -> None:
    """An element of it is read by index."""
    follow = "{topic: scan, type: sensor_msgs/msg/LaserScan, field: ranges, as: ranges}"
    tree = "log: '${len(ranges)} ${ranges[0]} ${ranges[-1]}'"
    run = ros.mission(f"mission: m\nfollow: {follow}\ntree:\n  {tree}\n")
    ros.client.create_publisher(LaserScan, "scan", LATCHED).publish(LaserScan(ranges=[0.5, 2.0]))
    ros.until(lambda: run.is_done, 3.0)
    assert ros.logged == ["2 0.5 2"]


def test_a_charge_that_was_not_measured_is_no_value(ros: Any) -> None:
    """ROS says so with a number that is none."""
    follow = "topic: b, type: sensor_msgs/msg/BatteryState, field: percentage, as: charge"
    text = f"mission: m\nfollow: {{{follow}, default: 0}}\ntree:\n  check: charge > 20\n"
    run = ros.mission(text)
    message = BatteryState(percentage=float("nan"))
    ros.client.create_publisher(BatteryState, "b", LATCHED).publish(message)
    ros.until(lambda: run.is_done, 3.0)
    assert run.executive.reason == "'check charge > 20' does not hold (charge = 0)"


def test_a_type_that_is_not_installed(ros: Any) -> None:
    """It is told with its place when the mission is set up."""
    with pytest.raises(BtMissionError, match=r"<text>:2:9: the message type no_such/msg/Thing"):
        ros.mission(GUARD.replace("std_msgs/msg/Int32", "no_such/msg/Thing"))


def test_a_topic_of_another_type(ros: Any) -> None:
    """So is this."""
    ros.client.create_publisher(String, "n", 10)
    ros.run(0.1)
    with pytest.raises(BtMissionError, match=r"<text>:2:9: /n is published as std_msgs/msg/String"):
        ros.mission(GUARD)


def test_who_watches_sees_its_value(ros: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also that it has none; each change once."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 0.0)
    seen: list[str] = []

    def hear(message: MissionDetails) -> None:
        seen.extend(variable.value for variable in message.variables if variable.name == "n")

    ros.client.create_subscription(MissionDetails, "/bt_mission/details", hear, DETAILS)
    numbers = ros.client.create_publisher(Int32, "n", 10)
    ros.mission(GUARD, has_controls=True)
    ros.run(0.5)
    for number in (3, 3, 4):
        numbers.publish(Int32(data=number))
        ros.run(0.2)
    assert list(dict.fromkeys(seen)) == ['"no value: no message of /n yet"', "3", "4"]
