"""The facts of a run in a recording, besides the messages of its topics."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CompressedImage, Image

from bt_mission.base.versions import versions
from bt_mission.language.mission import Mission
from bt_mission.sessions.session import MissionRun

Camera = Literal["none", "compressed", "raw"]


@dataclass(frozen=True)
class RecordingOptions:
    """The parts of a recording that are optional.

    Args:
        camera: Pictures: none, each as a JPEG, or as they are. A simulated camera draws only while
            somebody wants its pictures, so with them a run takes far longer.
        raw_actions: Keep the type names that rosidl makes of actions and services, such as
            ``Turn_FeedbackMessage`` and ``CancelGoal_Event``. The messages are the same;
            mcap-ros2-support and rosbags refuse such names.
    """

    camera: Camera = "none"
    raw_actions: bool = False


JPEG_QUALITY = 85
PNG_END = b"IEND\xaeB`\x82"
MOST_BYTES = 50_000_000
"""Saved pictures of a run that a recording takes in, all together."""


def facts_of(run: MissionRun, start_ns: int) -> dict[str, str]:
    """Return the facts of a mission's run at its start."""
    mission, node = run.mission, run.node
    return {
        "mission": mission.name,
        "file": mission.portable_name(mission.file),
        "seed": str(mission.seed),
        "robot": mission.robot,
        **({"observe": f"{mission.observe:g}"} if mission.observe else {}),
        "node": node.get_fully_qualified_name(),
        "namespace": node.get_namespace(),
        "start_ns": str(start_ns),
        "inputs": json.dumps(dict(mission.inputs)),
        "versions": json.dumps(versions()),
    }


def files_of(mission: Mission) -> Iterator[tuple[str, str]]:
    """The mission's file and those that it includes, each with its name and text."""
    for document in mission.documents:
        yield mission.portable_name(document.file), document.text


class PictureFolder:
    """A folder in which a run saves images, in subfolders.

    Args:
        folder: May be created later; None is no folder.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._known: set[Path] = set()
        self._bytes = 0

    def take_new(self) -> Iterator[tuple[str, bytes]]:
        """Return the new images since the last call, each with its name in the folder.

        An image that is still being written is returned by a later call.
        """
        if self._folder is None or not self._folder.is_dir():
            return
        for path in sorted(self._folder.rglob("*.png")):
            if path in self._known:
                continue
            data = path.read_bytes()
            if not data.endswith(PNG_END):
                continue
            self._known.add(path)
            self._bytes += len(data)
            if self._bytes <= MOST_BYTES:
                yield path.relative_to(self._folder).as_posix(), data


def compressed(data: bytes) -> bytes:
    """A serialized ``sensor_msgs/msg/CompressedImage`` of a serialized ``Image``, as a JPEG."""
    image = deserialize_message(data, Image)
    pixels: Any = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, -1)
    if image.encoding == "rgb8":
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    _, encoded = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    message = CompressedImage(header=image.header, format=f"{image.encoding}; jpeg compressed bgr8")
    message.data = encoded.tobytes()
    return bytes(serialize_message(message))


_LENGTH: Callable[[int], bytes] = struct.Struct("<I").pack


def string_message(text: str) -> bytes:
    """A ``std_msgs/msg/String``, serialized (little-endian CDR)."""
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + _LENGTH(len(data)) + data
