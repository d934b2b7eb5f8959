"""Facts about watching for a colour."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from action_servers.camera.find_colour import FindColour, plan
from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import SUCCEEDED, ZERO, Finished, Image, Observation

BLUE = (0x1F, 0x4F, 0xE0)


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
        rgb[:, columns] = BLUE
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
