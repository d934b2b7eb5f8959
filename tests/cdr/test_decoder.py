"""Serialized messages, read by their definitions."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import Empty, String
from tf2_msgs.msg import TFMessage

from bt_mission.cdr.decoder import Decoder, DecodingError, decoder_of
from tests.support.thorough import sample

TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=9)
DOUBLES = st.floats(allow_nan=False)
VALUES: dict[str, st.SearchStrategy[Any]] = {
    "double": DOUBLES,
    "float": st.floats(width=32, allow_nan=False),
    "int32": st.integers(-(2**31), 2**31 - 1),
    "uint32": st.integers(0, 2**32 - 1),
    "string": TEXTS,
    "sequence<float>": st.lists(st.floats(width=32), max_size=9),
    "sequence<geometry_msgs/TransformStamped>": st.lists(st.builds(TransformStamped), max_size=3),
}
"""What each field may hold, by its type."""

MIXED = (
    "uint8 small\nfloat64 wide\nstring<=9 word 'x'\nint16 X=3\nbool[2] pair\nInner[] inner\n"
    "int64 last\n" + "=" * 80 + "\nMSG: a/Inner\nfloat32 x\nstring s\n"
)


def type_of(message: Any) -> str:
    """Return the name of its type."""
    package, _, _ = type(message).__module__.partition(".")
    return f"{package}/msg/{type(message).__name__}"


def fill(message: Any, draw: Any) -> dict[str, Any]:
    """Draw a value for each field of a message; return them as a reader gives them."""
    fields: dict[str, Any] = {}
    for name, type_name in message.get_fields_and_field_types().items():
        if type_name in VALUES:
            setattr(message, name, draw(VALUES[type_name]))
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            fields[name] = fill(value, draw)
        elif "TransformStamped" in type_name:
            fields[name] = [fill(part, draw) for part in value]
        else:
            if type_name == "double[36]":
                value[35] = draw(DOUBLES)
            fields[name] = value
    return fields


@pytest.mark.parametrize("message_type", sample([Odometry, TwistStamped, TFMessage, LaserScan], 4))
@given(data=st.data())
def test_messages_of_sensors_are_those_that_rclpy_unpacks(message_type: Any, data: Any) -> None:
    """Number for number, with texts, arrays and lists of any length."""
    message = message_type()
    fields = fill(message, data.draw)
    read = decoder_of(type_of(message)).decode(serialize_message(message))
    np.testing.assert_equal(read, fields)


def test_values_lie_where_their_size_wants_them() -> None:
    """Aligned from the end of the head on; constants and defaults take no room."""
    data = b"\0\1\0\0" + struct.pack("<B7xdI", 7, 0.5, 3) + b"hi\0" + b"\1\0" + b"\0\0\0"
    data += struct.pack("<I", 2) + struct.pack("<fI", 1.5, 2) + b"a\0\0\0"
    data += struct.pack("<fI", 2.5, 1) + b"\0" + b"\0" * 3
    data += b"\0" * (-(len(data) - 4) % 8) + struct.pack("<q", -1)
    value = Decoder("a/msg/Mixed", MIXED).decode(data)
    assert value["inner"] == [{"x": 1.5, "s": "a"}, {"x": 2.5, "s": ""}]
    assert (value["small"], value["wide"], value["word"], value["last"]) == (7, 0.5, "hi", -1)
    assert list(value["pair"]) == [True, False]


def test_bytes_may_come_in_the_other_order() -> None:
    """The head says which."""
    data = b"\0\0\0\0" + struct.pack(">I", 5) + struct.pack(">I", 2) + b"a\0"
    assert Decoder("a/msg/B", "uint32 n\nstring s\n").decode(data) == {"n": 5, "s": "a"}


def test_a_field_may_be_called_as_a_method_of_dict() -> None:
    """Such as the values of a DiagnosticStatus: the attribute is the field."""
    status = DiagnosticStatus(name="motor", values=[KeyValue(key="load", value="3")])
    value: Any = decoder_of("diagnostic_msgs/msg/DiagnosticStatus").decode(
        serialize_message(status)
    )
    assert [(pair.key, pair.value) for pair in value.values] == [("load", "3")]
    data = b"\0\1\0\0" + struct.pack("<ff", 1.5, 2.5)
    row: Any = Decoder("a/msg/Row", "float32 items\nfloat32 keys\n").decode(data)
    assert (row.items, row.keys) == (1.5, 2.5)


def test_messages_that_ros_has_written() -> None:
    """Arrays of numbers, nested messages, no fields at all."""
    scan = LaserScan(ranges=[1.0, 2.0, float("inf")], angle_min=0.5)
    scan.header.frame_id = "base_scan"
    value = decoder_of("sensor_msgs/msg/LaserScan").decode(serialize_message(scan))
    assert value["header"]["frame_id"] == "base_scan"
    np.testing.assert_array_equal(value["ranges"], [1.0, 2.0, np.inf])
    assert (value["ranges"].dtype, value["intensities"].size) == (np.float32, 0)
    joints = JointState(name=["left", "right"], position=[1.0, 2.0])
    value = decoder_of("sensor_msgs/msg/JointState").decode(serialize_message(joints))
    assert (value["name"], list(value["position"])) == (["left", "right"], [1.0, 2.0])
    assert decoder_of("std_msgs/msg/Empty").decode(serialize_message(Empty())) == {}
    assert decoder_of("tf2_msgs/msg/TFMessage").decode(serialize_message(TFMessage())) == {
        "transforms": []
    }


@given(st.binary(max_size=80))
def test_any_bytes_give_values_or_an_error(data: bytes) -> None:
    """Never a traceback of another kind, and never more memory than the message has bytes."""
    for name, text in (("a/msg/Mixed", MIXED), ("a/msg/S", "string[] s\n")):
        try:
            Decoder(name, text).decode(data)
        except DecodingError as error:
            assert name in str(error)  # noqa: PT017 - both ways are right


@pytest.mark.parametrize(
    "message",
    [
        Odometry(child_frame_id="base"),
        TFMessage(transforms=[TransformStamped(child_frame_id="odom")]),
        LaserScan(ranges=[1.0, 2.0]),
        TwistStamped(),
        String(data="hello"),
    ],
    ids=type_of,
)
def test_a_message_that_ends_too_early_is_an_error(message: Any) -> None:
    """Wherever it ends."""
    whole, decode = serialize_message(message), decoder_of(type_of(message)).decode
    needed = len(whole)
    while needed and whole[needed - 1 : needed] == b"\0" and needed % 8:
        needed -= 1  # DDS pads a message to its alignment
    for length in range(needed - 8 if needed > 16 else 12):
        with pytest.raises(DecodingError, match=f"invalid message of type {type_of(message)}"):
            decode(whole[:length])
    assert decode(whole)


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\7\0\0" + bytes(99), b"\1\1\0\0" + bytes(99)])
def test_what_has_no_header_is_no_message(data: bytes) -> None:
    """Also one of an encoding that is not known here."""
    with pytest.raises(DecodingError, match="no CDR head"):
        decoder_of("nav_msgs/msg/Odometry").decode(data)


def test_a_definition_that_lacks_a_part_is_an_error() -> None:
    """Named."""
    with pytest.raises(DecodingError, match="definition of a/Gone is missing"):
        Decoder("a/msg/Top", "Gone gone\n").decode(b"\0\1\0\0")


def test_a_message_of_known_length_is_left_alone() -> None:
    """Nothing is even looked at."""
    taken: list[bytes] = []
    take = taken.append
    assert decoder_of("sensor_msgs/msg/Imu").trimming(take, has_fixed_shape=False) is take
    assert len(serialize_message(Imu())) == 4 + 8 + 4 + 1 + 3 + 8 * (4 + 9 + 3 + 9 + 3 + 9)


def test_room_for_a_sequence_that_is_empty_is_taken_away() -> None:
    """ROS reckons with its first element."""
    message = JointState(name=["left", "right"], position=[1.0, 2.0], velocity=[3.0, 4.0])
    data = serialize_message(message)
    for has_fixed_shape in (True, False):
        taken: list[bytes] = []
        joints = decoder_of("sensor_msgs/msg/JointState")
        take = joints.trimming(taken.append, has_fixed_shape=has_fixed_shape)
        take(data)
        take(data)
        assert taken == [data[:-4], data[:-4]]


def test_a_length_that_no_array_has_is_an_error_of_the_definition() -> None:
    """Python would not even read the number."""
    with pytest.raises(DecodingError, match="an array of a length of 5000 digits"):
        Decoder("a/msg/B", f"uint8[{'9' * 5000}] data\n")


def test_empty_messages_take_as_long_as_the_data_that_they_are_sent_with() -> None:
    """Arrays of arrays of them would take for ever."""
    part = "=" * 80 + "\nMSG: a/{}\n{}\n"
    nested = "".join(part.format(f"C{n}", f"C{n + 1}[50] inner") for n in range(8))
    definition = "C0[50] outer\n" + nested + part.format("C8", "")
    with pytest.raises(DecodingError, match="it ends too early"):
        Decoder("a/msg/B", definition).decode(b"\0\1\0\0" + bytes(60))
