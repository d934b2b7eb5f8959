"""Facts about colours in a picture, and about watching for one."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from action_servers.camera.find_colour import HUES_DEG, FindColour, largest_patch, plan
from action_servers.core.maneuver import SUCCEEDED, ZERO, ErrorCode, Finished, Image, Observation

BEACONS = {
    "red": (0xD6, 0x20, 0x2A),
    "yellow": (0xF2, 0xCF, 0x1D),
    "green": (0x1F, 0x9D, 0x3A),
    "turquoise": (0x19, 0xC5, 0xC9),
    "blue": (0x1F, 0x4F, 0xE0),
}
"""Of the worlds that are shipped."""
OTHERS = [
    (0xF0, 0x8A, 0x1D),
    (0x8A, 0x3F, 0xC0),
    (0x9A, 0xA0, 0xA6),
    (0xF0, 0xF0, 0xEC),
    (9, 9, 30),
]
"""Orange, purple, grey, white, and almost black."""


def picture(colour, *, light=1.0, tint=(1.0, 1.0, 1.0), noise=0.0):
    """A grey picture of 80 x 60 with a patch of 20 x 30 whose middle is at a quarter."""
    rgb = np.full((60, 80, 3), 150.0)
    rgb[15:45, 10:30] = colour
    rgb = rgb * light * np.array(tint)
    rgb += np.random.default_rng(1).normal(0.0, 1.0, rgb.shape) * noise
    return np.clip(rgb, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("light", [0.35, 0.7, 1.0, 1.1])
@pytest.mark.parametrize("colour", HUES_DEG)
def test_each_beacon_is_found_in_any_light(colour, light):
    """And is no other colour: in shade, and where the light is so strong that it clips."""
    seen = picture(BEACONS[colour], light=light)
    result = {name: largest_patch(seen, name) for name in HUES_DEG}
    patch = result.pop(colour)
    assert patch is not None
    assert patch.share == pytest.approx(600 / 4800)
    assert patch.across == pytest.approx(-0.5)
    assert set(result.values()) == {None}


@pytest.mark.parametrize("tint", [(1.1, 1.0, 0.85), (0.85, 1.0, 1.1)])
@pytest.mark.parametrize("colour", HUES_DEG)
def test_warm_and_cold_light_and_noise_are_borne(colour, tint):
    """A patch of nearly its size, and nothing in the grey around it."""
    patch = largest_patch(picture(BEACONS[colour], tint=tint, noise=4.0), colour)
    assert patch is not None
    assert patch.share == pytest.approx(600 / 4800, rel=0.1)


@pytest.mark.parametrize("other", OTHERS)
def test_other_colours_are_none_of_them(other):
    """Neither neighbours in hue nor what has none."""
    seen = picture(other)
    assert {largest_patch(seen, name) for name in HUES_DEG} == {None}


def test_of_two_patches_the_larger_counts():
    """They do not touch, and so do not add up."""
    rgb = np.zeros((60, 80, 3), dtype=np.uint8)
    rgb[10:20, 5:15] = BEACONS["blue"]
    rgb[10:30, 60:80] = BEACONS["blue"]
    patch = largest_patch(rgb, "blue")
    assert patch is not None
    assert patch.share == pytest.approx(400 / 4800)
    assert patch.across == pytest.approx(0.75)


def test_single_pixels_are_noise():
    """Two wide is too little, too."""
    rgb = np.zeros((60, 80, 3), dtype=np.uint8)
    rgb[::5, ::5] = BEACONS["red"]
    rgb[:, 40:42] = BEACONS["red"]
    assert largest_patch(rgb, "red") is None


class Camera:
    """Notes whether it is on."""

    is_on = False

    def on(self):
        self.is_on = True

    def off(self):
        self.is_on = False


def image(stamp_s, columns=None):
    """A black picture of 320 x 240 with blue columns."""
    rgb = np.zeros((240, 320, 3), dtype=np.uint8)
    if columns:
        rgb[:, columns] = BEACONS["blue"]
    return Image(stamp_s, 240, 320, rgb)


NOW = Observation(9.0)


def goal(colour="blue", min_share=0.0):
    """A goal of FindColour."""
    return SimpleNamespace(colour=colour, min_share=min_share)


@pytest.fixture
def looking(waffle):
    """A maneuver that looks for blue, and its camera, after its first step at 10 s."""
    camera = Camera()
    maneuver = plan(goal(), NOW, waffle, camera)
    assert isinstance(maneuver, FindColour)
    assert maneuver.step(Observation(10.0, image=image(9.9, slice(0, 320)))) == ZERO
    return maneuver, camera


def test_it_ends_with_the_first_picture_that_has_the_colour(looking):
    """Taken since it began; until then each picture is told of."""
    maneuver, camera = looking
    assert camera.is_on
    assert maneuver.feedback() is None
    assert maneuver.step(Observation(10.1, image=image(10.1))) == ZERO
    reported = maneuver.feedback()
    assert math.isnan(reported["angle"])
    assert reported["share"] == 0.0
    assert maneuver.feedback() is None
    assert maneuver.step(Observation(10.2, image=image(10.2, slice(280, 320)))) == SUCCEEDED
    assert maneuver.result()["share"] == pytest.approx(40 / 320)


@pytest.mark.parametrize(
    ("columns", "angle"),
    [(slice(150, 170), 0.0), (slice(0, 20), 27.94), (slice(300, 320), -27.94)],
)
def test_the_bearing_is_that_of_a_pinhole(looking, columns, angle):
    """The Waffle's field of view is 59 degrees; left is positive."""
    maneuver, _ = looking
    maneuver.step(Observation(10.1, image=image(10.1, columns)))
    assert maneuver.result()["angle"] == pytest.approx(angle, abs=0.01)


def test_a_patch_that_is_too_small_is_told_and_not_taken(waffle):
    """Half the picture was asked for."""
    maneuver = plan(goal(min_share=0.5), NOW, waffle, Camera())
    assert isinstance(maneuver, FindColour)
    maneuver.step(Observation(10.0))
    assert maneuver.step(Observation(10.1, image=image(10.1, slice(0, 100)))) == ZERO
    assert (maneuver.feedback() or {})["share"] == pytest.approx(100 / 320)


def test_a_camera_that_stops_ends_it(looking):
    """Two seconds after the last picture; the same picture again is none."""
    maneuver, _ = looking
    same = image(10.5)
    maneuver.step(Observation(10.5, image=same))
    assert maneuver.step(Observation(12.45, image=same)) == ZERO
    assert maneuver.step(Observation(12.5, image=same)) == Finished(
        "aborted", ErrorCode.NO_IMAGE, "no image from the camera for 2 s"
    )
