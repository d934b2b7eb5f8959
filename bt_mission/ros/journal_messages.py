"""ROS messages as JSON, for variables that hold one."""

from __future__ import annotations

import base64
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.ros.interface_types import message_type


def pack(value: Any) -> dict[str, str] | None:
    """A message with its type; None for what is no message."""
    if not hasattr(type(value), "get_fields_and_field_types"):
        return None
    package, folder = type(value).__module__.split(".")[:2]
    data = base64.b64encode(serialize_message(value)).decode()
    return {"type": f"{package}/{folder}/{type(value).__name__}", "data": data}


def unpack(packed: dict[str, str]) -> Any:
    """The message.

    :raises BtMissionError: when its type is not installed.
    """
    data = base64.b64decode(packed["data"])
    return deserialize_message(data, message_type(packed["type"]))
