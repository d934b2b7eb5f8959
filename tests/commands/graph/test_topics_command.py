"""``bt-mission topics echo`` and ``hz``, and ``bt-mission services call``."""

from __future__ import annotations

import json
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool

from bt_mission.commands.graph.topic_messages import RateMeter
from bt_mission.ros.subscriber import matching_qos

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def talking(ros: Any, topic: str, message: Any, period_s: float, qos: Any = 10) -> None:
    """Say something again and again."""
    node = ros.node(f"talker_{topic}")
    publisher = node.create_publisher(type(message), topic, qos)
    node.create_timer(period_s, lambda: publisher.publish(message))


@pytest.mark.parametrize("qos", [10, BEST_EFFORT])
def test_messages_are_printed_as_yaml(ros: Any, type_in: Any, qos: Any) -> None:
    """Whether they are sent reliably or not; so many as are wanted."""
    talking(ros, "scan", LaserScan(range_max=3.5, ranges=[1.0] * 360), 0.1, qos)
    done = type_in("topics", "echo", "/scan", "--count", "2")
    first, second, rest = done.out.split("---\n")
    assert (done.code, rest) == (0, "")
    assert yaml.safe_load(first) == yaml.safe_load(second)
    assert yaml.safe_load(first)["range_max"] == 3.5
    assert "  # 344 more\n" in first


def test_one_field_can_be_picked(ros: Any, type_in: Any) -> None:
    """By its dotted name; a wrong one is an error with what there is."""
    talking(ros, "scan", LaserScan(), 0.1)
    done = type_in("topics", "echo", "/scan", "--once", "--field", "header.stamp.sec")
    assert done.out == "0\n---\n"
    wrong = type_in("topics", "echo", "/scan", "--once", "--field", "header.stam")
    assert wrong.code == 2
    assert "--field: no field 'stam' in std_msgs/Header" in wrong.err
    assert "did you mean 'stamp'?" in wrong.err


def test_programs_get_whole_messages_a_line_each(ros: Any, type_in: Any) -> None:
    """Lists are not cut."""
    talking(ros, "scan", LaserScan(ranges=[float("inf")] * 360), 0.1)
    done = type_in("topics", "echo", "/scan", "--once", "--json")
    assert json.loads(done.out)["ranges"] == ["Infinity"] * 360


def test_what_was_said_before_of_a_latched_topic_is_asked_for(ros: Any) -> None:
    """Only if every publisher is latched: a volatile one would not match such a subscription."""

    def fitting(topic: str) -> QoSProfile:
        publishers_info = ros.client.get_publishers_info_by_topic(topic)
        return matching_qos([publisher.qos_profile for publisher in publishers_info], 1)

    ros.node("one").create_publisher(String, "map", LATCHED)
    assert fitting("/map").durability is DurabilityPolicy.TRANSIENT_LOCAL
    ros.node("two").create_publisher(String, "map", BEST_EFFORT)
    qos = fitting("/map")
    assert qos.durability is DurabilityPolicy.VOLATILE
    assert qos.reliability is ReliabilityPolicy.BEST_EFFORT
    assert fitting("/nobody").reliability is ReliabilityPolicy.BEST_EFFORT


def test_a_publisher_that_comes_back_with_another_offer_is_heard(
    ros: Any, hand: Any, type_in: Any
) -> None:
    """A reliable one left, and one that is not has come."""
    first = ros.node("first")
    reliable = first.create_publisher(String, "speech", 10)
    hand.at(0.1, lambda: reliable.publish(String(data="one")))
    hand.at(0.2, lambda: ros.drop(first))
    hand.at(0.3, lambda: talking(ros, "speech", String(data="two"), 0.1, BEST_EFFORT))
    done = type_in("topics", "echo", "/speech", "--count", "2")
    assert done.out == "data: one\n---\ndata: two\n---\n"


def test_what_is_said_cannot_command_the_terminal(ros: Any, type_in: Any) -> None:
    """Escapes are shown, not obeyed."""
    talking(ros, "speech", String(data="\x1b]0;owned\x07"), 0.1)
    done = type_in("topics", "echo", "/speech", "--once")
    assert "\x1b" not in done.out
    assert "\x07" not in done.out
    assert "owned" in done.out


def test_the_rate_is_told_each_second(ros: Any, hand: Any, type_in: Any) -> None:
    """By the times of receipt."""
    talking(ros, "speech", String(data="x"), 0.05)
    done = type_in("topics", "hz", "/speech", "--count", "2")
    assert done.code == 0
    assert done.lines[1].startswith("   20.00 Hz   every 0.0500 s (0.0500 to 0.0500, deviation 0.0")
    assert len(done.lines) == 2


def test_silence_is_told_too(ros: Any, hand: Any, type_in: Any) -> None:
    """And Ctrl-C ends it."""
    publisher = ros.client.create_publisher(String, "speech", 10)
    hand.at(0.5, lambda: publisher.publish(String()))
    hand.at(2.5, hand.press_ctrl_c)
    done = type_in("topics", "hz", "/speech")
    assert done.code == 130
    assert done.lines == ["1 message so far", "no message for a second; 1 messages so far"]


def test_rates_for_programs(ros: Any, type_in: Any) -> None:
    """An object a line, in ROS time if wanted."""
    talking(ros, "speech", String(data="x"), 0.1)
    done = type_in("topics", "hz", "/speech", "--count", "1", "--json", "--sim-time")
    data = json.loads(done.out)
    assert data["topic"] == "/speech"
    assert data["hz"] == pytest.approx(10.0)
    assert data["silent"] is False


@pytest.mark.parametrize(
    ("times_ms", "hz"),
    [((), None), ((5, 5), None), ((900, 1000, 50, 100), 20.0)],
    ids=["no message", "several at one instant", "a simulation that was reset"],
)
def test_a_rate_needs_times_that_go_on(times_ms: tuple[int, ...], hz: float | None) -> None:
    """Where time goes back, it begins anew."""
    meter = RateMeter(10)
    for at in times_ms:
        meter.note(at * 1_000_000)
    rate = meter.read()
    assert (rate and rate.hz) == (hz and pytest.approx(hz))


def test_a_rate_is_that_of_the_window() -> None:
    """Mean, least, most, deviation; all messages are counted."""
    meter = RateMeter(3)
    for at in (0, 1000, 1100, 1200, 1350):
        meter.note(at * 1_000_000)
    rate = meter.read()
    assert rate is not None
    assert rate.hz == pytest.approx(3 / 0.35)
    assert (rate.least_s, rate.most_s) == pytest.approx((0.1, 0.15))
    assert rate.deviation_s == pytest.approx(0.02357, abs=1e-5)
    assert (rate.count, meter.total) == (3, 5)


# ---- services ----------------------------------------------------------------------------------


def test_the_answer_is_printed(ros: Any, type_in: Any) -> None:
    """As YAML, or as an object."""

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "done\x1b[2J"
        return response

    ros.client.create_service(SetBool, "switch", answer)
    done = type_in("services", "call", "/switch", "data: true")
    assert (done.code, done.out) == (0, 'success: true\nmessage: "done\\e[2J"\n')
    done = type_in("services", "call", "/switch", "--json")
    assert done.code == 1, "no success is no success"
    assert json.loads(done.out)["success"] is False


def test_a_request_that_does_not_fit_is_shown_its_place(ros: Any, type_in: Any) -> None:
    """Nothing is asked."""
    ros.client.create_service(SetBool, "switch", lambda _, response: response)
    done = type_in("services", "call", "/switch", "data: 3")
    assert done.code == 2
    assert "request:1:7: error: expected a boolean (bool), got the number 3" in done.err


def test_a_service_that_is_not_there_exits_with_5(ros: Any, type_in: Any) -> None:
    """With what there is."""
    ros.client.create_service(SetBool, "switch", lambda _, response: response)
    done = type_in("services", "call", "/swich", "--wait", "1")
    assert done.code == 5
    assert "no service /swich in the graph (looked for 1 s)" in done.err
    assert "did you mean '/switch'?" in done.err
    done = type_in("services", "call", "/x", "--type", "std_srvs/srv/SetBool", "--wait", "1")
    assert (done.code, done.err) == (5, "no server of /x after 1 s [BT-901]\n")


def test_a_server_that_does_not_answer_exits_with_6(ros: Any, type_in: Any) -> None:
    """After --timeout."""

    async def never(_: Any, response: Any) -> Any:
        await Future()
        return response

    ros.node("silent").create_service(SetBool, "switch", never)
    done = type_in("services", "call", "/switch", "--timeout", "1")
    assert (done.code, done.err) == (6, "/switch did not answer within 1 s\n")
