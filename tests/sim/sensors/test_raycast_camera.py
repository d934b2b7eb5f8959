"""Without EGL, pictures show the same things in the same places."""

import numpy as np
import pytest

from sim.sensors.camera import Camera, RaycastCamera
from sim.sensors.canvas import NoCameraError

PILLARS = [
    {"name": "red", "x": 1.5, "y": 0.3, "radius": 0.15, "height": 0.5, "colour": "red"},
    {"name": "blue", "x": 1.2, "y": -0.4, "radius": 0.1, "height": 0.4, "colour": "blue"},
]


@pytest.fixture
def picture(waffle):
    """Draws a simulation's first picture with one of the two cameras."""

    def draw(kind, simulation):
        camera = kind(simulation.physics.model, waffle.camera)
        out = np.zeros((waffle.camera.height, waffle.camera.width, 3), dtype=np.uint8)
        camera.draw(simulation.physics.data, out)
        camera.close()
        return out

    return draw


def dominant(pixels, channel):
    """Where one colour is at least twice each of the others."""
    others = [pixels[..., c].astype(int) for c in range(3) if c != channel]
    return (pixels[..., channel] > 60) & (pixels[..., channel] > 2 * np.maximum(*others))


@pytest.mark.parametrize("channel", [0, 2])
def test_a_pillar_stands_where_its_geometry_says(simulate, picture, channel):
    """Each colour fills one block of columns, on the right side of the picture."""
    columns = np.flatnonzero(
        dominant(picture(RaycastCamera, simulate(cylinders=PILLARS)), channel).any(axis=0)
    )
    assert len(columns) == columns.max() - columns.min() + 1 > 30
    assert (columns.max() < 160) == (channel == 0), "red is left, blue is right"


@pytest.mark.egl
@pytest.mark.parametrize("channel", [0, 2])
def test_it_agrees_with_the_renderer(simulate, picture, channel):
    """Of the pixels that either camera gives a pillar's colour, 97 in a hundred are the same."""
    simulation = simulate(cylinders=PILLARS)
    try:
        rendered = dominant(picture(Camera, simulation), channel)
    except NoCameraError as error:
        pytest.skip(str(error))
    cast = dominant(picture(RaycastCamera, simulation), channel)
    assert (rendered & cast).sum() / (rendered | cast).sum() > 0.97


def test_the_same_view_gives_the_same_picture(simulate, picture):
    """Byte for byte."""
    first, second = (picture(RaycastCamera, simulate(cylinders=PILLARS)) for _ in range(2))
    assert np.array_equal(first, second)
