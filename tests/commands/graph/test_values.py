"""Messages as plain values, and as text that is safe to show."""

from __future__ import annotations

import json
import math

import pytest
import yaml  # type: ignore[import-untyped]
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import ByteMultiArray, String

from bt_mission.base.text import escape_control
from bt_mission.commands.graph.values import as_json, as_yaml, flat, plain, short


def test_a_float32_is_the_shortest_decimal_that_is_the_same() -> None:
    """Within messages and lists."""
    scan = plain(LaserScan(range_max=3.5, angle_min=0.1, ranges=[0.1, 2.5, math.inf]))
    assert scan["angle_min"] == 0.1
    assert scan["ranges"] == [0.1, 2.5, math.inf]


def test_long_lists_are_cut_for_people() -> None:
    """The text says how much is missing, and is still YAML."""
    text = as_yaml(plain(Image(data=bytes(range(200))), 16))
    assert "data: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]  # 184 more\n" in text
    assert yaml.safe_load(text)["data"] == list(range(16))
    assert len(plain(Image(data=bytes(200)))["data"]) == 200
    words = [String(data=letter) for letter in "abc"]
    assert as_yaml(plain(words, 2)) == "- data: a\n- data: b\n  # 1 more\n"


def test_bytes_are_numbers() -> None:
    """Octets come one by one."""
    assert plain(ByteMultiArray(data=[b"\x01", b"\xff"]))["data"] == [1, 255]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain", "plain"),
        ("grün ✓ 漢", "grün ✓ 漢"),
        ("\x1b[31mred", "\\x1b[31mred"),
        ("a\nb\tc\rd", "a\\nb\\tc\\rd"),
        ("\x9b2J", "\\x9b2J"),
        ("\u202eevil", "\\u202eevil"),
        ("\x00\x07", "\\x00\\x07"),
    ],
)
def test_no_sign_reaches_a_terminal_that_it_would_obey(text: str, shown: str) -> None:
    """In lines, in YAML and in JSON; what YAML escapes is the same value."""
    assert escape_control(text) == shown
    for written in (as_yaml({"a": text}), as_json({"a": text}), short({"a": text})):
        assert all(c.isprintable() or c == "\n" for c in written), written
    assert yaml.safe_load(as_yaml({"a": text})) == {"a": text}


def test_numbers_that_are_not_finite_are_texts_in_json() -> None:
    """JSON has none."""
    text = as_json({"a": [math.inf, -math.inf, math.nan, 1.5]})
    assert json.loads(text) == {"a": ["Infinity", "-Infinity", "NaN", 1.5]}


def test_a_time_is_one_number_of_seconds() -> None:
    """In lines for people."""
    message = PointStamped()
    message.header.stamp.sec, message.header.stamp.nanosec = 3, 250_000_000
    assert list(flat(plain(message))) == [
        ("header.stamp", 3.25),
        ("header.frame_id", ""),
        ("point.x", 0.0),
        ("point.y", 0.0),
        ("point.z", 0.0),
    ]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (1.23456789, "1.23457"),
        (7, "7"),
        ("", "''"),
        ([1.5, "a"], "[1.5, a]"),
        ({"a": 1, "b": [True]}, "{a 1, b [true]}"),
        ("x" * 3000, "x" * 2000 + "..."),
    ],
)
def test_values_on_one_line(value: object, text: str) -> None:
    """As people read them."""
    assert short(value) == text
