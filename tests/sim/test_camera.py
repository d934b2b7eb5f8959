"""Pictures: what they show, and what a machine without EGL is told."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from sim.camera import Camera, NoCameraError

RED = {"name": "red", "x": 1.5, "y": -0.047, "radius": 0.15, "height": 0.5, "colour": "red"}


@pytest.fixture
def photograph(simulate, waffle):
    """Takes a picture at the start, in a world of these fields; skips where there is no EGL."""

    def photograph(**fields: object) -> np.ndarray:
        simulation = simulate(**fields)
        try:
            camera = Camera(simulation.model, waffle.camera)
        except NoCameraError as error:
            pytest.skip(str(error))
        picture = np.zeros((waffle.camera.height, waffle.camera.width, 3), dtype=np.uint8)
        camera.draw(simulation.data, picture)
        camera.close()
        return picture

    return photograph


def is_red(pixels: np.ndarray) -> np.ndarray:
    """Where a picture is red."""
    red, green, blue = (pixels[..., channel].astype(int) for channel in range(3))
    return (red > 90) & (green < red / 2) & (blue < red / 2)


@pytest.mark.egl
def test_what_stands_ahead_is_in_the_middle(photograph):
    """A red pillar 1.5 m ahead of the lens: a column in the middle, as wide as it should be."""
    columns = np.flatnonzero(is_red(photograph(cylinders=[RED])).any(axis=0))
    assert (columns.min() + columns.max()) / 2 == pytest.approx(159.5, abs=2)
    # Focal length 283 pixels; 0.15 m at the tangent of a circle 1.431 m away.
    assert columns.max() - columns.min() + 1 == pytest.approx(2 * 283 * 0.15 / 1.423, abs=3)


@pytest.mark.egl
def test_left_is_left_and_up_is_up(photograph):
    """A pillar on the left is left in the picture; the sky is in the first rows."""
    picture = photograph(cylinders=[{**RED, "y": 0.35}])
    columns = np.flatnonzero(is_red(picture).any(axis=0))
    assert columns.max() < 160
    sky, floor = picture[0].mean(axis=0), picture[-1].mean(axis=0)
    assert sky.sum() > floor.sum()
    assert sky[2] > sky[0]


@pytest.mark.egl
def test_it_does_not_see_the_robot_that_carries_it(photograph):
    """On an empty floor there are tiles below and sky above, nothing black."""
    assert photograph().min() > 60


@pytest.mark.egl
def test_the_same_view_gives_the_same_picture(photograph):
    """Byte for byte."""
    assert np.array_equal(photograph(cylinders=[RED]), photograph(cylinders=[RED]))


def refuse(*_: object) -> None:
    """What the bindings do where there is no display device."""
    raise ImportError("Cannot initialize a EGL device display.\nSecond line")


def test_a_machine_without_egl_is_told_what_to_install(simulate, waffle, monkeypatch):
    """One error of ours, with the cause in a few words."""
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    with pytest.raises(NoCameraError, match=r"EGL cannot be used .*apt-get install libegl1 libgl1"):
        Camera(simulate().model, waffle.camera)


def test_a_driver_that_refuses_is_told_in_one_line(simulate, waffle, monkeypatch):
    """Only the first line of what the driver says."""
    monkeypatch.setitem(sys.modules, "mujoco.egl", SimpleNamespace(GLContext=refuse))
    with pytest.raises(NoCameraError) as caught:
        Camera(simulate().model, waffle.camera)
    assert "ImportError: Cannot " in str(caught.value)
    assert "\n" not in str(caught.value)
