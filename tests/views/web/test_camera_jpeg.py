"""Pictures of a camera for a page."""

from __future__ import annotations

import io

import pytest
from PIL import Image

from bt_mission.executive.events.messages import CameraImage
from bt_mission.views.web.camera_jpeg import jpeg_of


@pytest.mark.parametrize(
    ("encoding", "pixel", "colour"),
    [
        ("rgb8", (240, 10, 10), (240, 10, 10)),
        ("bgr8", (10, 10, 240), (240, 10, 10)),
        ("rgba8", (240, 10, 10, 255), (240, 10, 10)),
        ("bgra8", (10, 10, 240, 255), (240, 10, 10)),
        ("mono8", (120,), (120, 120, 120)),
    ],
)
def test_each_encoding_keeps_its_colours(
    encoding: str, pixel: tuple[int, ...], colour: tuple[int, int, int]
):
    """Also where rows are longer than their pixels."""
    row = bytes(pixel) * 16 + b"\0\0"
    jpeg = jpeg_of(CameraImage(16, 16, len(row), encoding, row * 16))
    assert jpeg is not None
    with Image.open(io.BytesIO(jpeg)) as picture:
        assert picture.size == (16, 16)
        seen = picture.convert("RGB").getpixel((8, 8))
    assert seen == pytest.approx(colour, abs=8)


@pytest.mark.parametrize(
    "image",
    [
        CameraImage(2, 2, 6, "yuv422", bytes(12)),
        CameraImage(2, 2, 6, "rgb8", bytes(11)),
        CameraImage(2, 2, 5, "rgb8", bytes(10)),
        CameraImage(0, 0, 0, "rgb8", b""),
    ],
)
def test_what_is_no_picture_is_passed_over(image: CameraImage):
    """An encoding that is not known, or data of another size."""
    assert jpeg_of(image) is None


def test_a_large_picture_is_made_smaller():
    """A page needs no more."""
    jpeg = jpeg_of(CameraImage(1920, 1080, 5760, "rgb8", bytes(5760 * 1080)))
    assert jpeg is not None
    with Image.open(io.BytesIO(jpeg)) as picture:
        assert picture.size == (640, 360)
