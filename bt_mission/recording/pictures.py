"""Pictures of a run: those that it saves, and those of a camera's topic made small."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CompressedImage, Image

JPEG_QUALITY = 85
PNG_END = b"IEND\xaeB`\x82"
MOST_BYTES = 50_000_000
"""Saved pictures of a run that a recording takes in, all together."""


class PictureFolder:
    """A folder into which a run saves pictures, in folders of its own.

    :param folder: may come into being later; None is no folder.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._known: set[Path] = set()
        self._bytes = 0

    def take_new(self) -> Iterator[tuple[str, bytes]]:
        """The pictures that have come since the last time, each with its name in the folder.

        One that is still being written is left for the next time.
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
