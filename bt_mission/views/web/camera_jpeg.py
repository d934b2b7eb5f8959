"""Pictures of a robot's camera as JPEG, small enough for a panel of a page."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from bt_mission.executive.events.messages import CameraImage

CHANNELS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1}
"""Encodings that are shown, with the bytes of a pixel."""

LARGEST = (640, 480)
QUALITY = 75


def jpeg_of(image: CameraImage) -> bytes | None:
    """Return an image as JPEG; None for another encoding, or if its size and its data disagree."""
    channels = CHANNELS.get(image.encoding)
    if channels is None or image.width < 1 or image.height < 1:
        return None
    if image.step < image.width * channels or len(image.data) != image.step * image.height:
        return None
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    pixels = rows[:, : image.width * channels].reshape(image.height, image.width, channels)
    if channels == 1:
        pixels = np.repeat(pixels, 3, axis=2)
    if image.encoding.startswith("bgr"):
        pixels = pixels[:, :, 2::-1]
    picture = Image.fromarray(np.ascontiguousarray(pixels[:, :, :3]))
    picture.thumbnail(LARGEST)
    made = io.BytesIO()
    picture.save(made, "JPEG", quality=QUALITY)
    return made.getvalue()
