"""Pictures, rendered and drawn ray by ray: what they show, noise, and errors without EGL."""

import colorsys
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bt_mission.robots.model import SensorsModel
from sim.sensors import canvas
from sim.sensors.camera import Camera, RaycastCamera
from sim.sensors.canvas import NoCameraError
from sim.sensors.sensor import PictureNoise
from sim.world.loader import load_world
from sim.world.shapes import rgba
from tests.support.simulated import alone
from tests.support.thorough import sample

RED = {"name": "red", "x": 1.5, "y": -0.047, "radius": 0.15, "height": 0.5, "colour": "red"}
BLUE = {"name": "blue", "x": 1.2, "y": -0.4, "radius": 0.1, "height": 0.4, "colour": "blue"}
PILLARS = [RED | {"y": 0.3}, BLUE]


def picture_of(simulation, camera) -> np.ndarray:
    """What a camera of the robot shows."""
    spec = simulation.robot.camera
    picture = np.zeros((spec.height, spec.width, 3), dtype=np.uint8)
    camera.draw(simulation.physics.data, picture)
    return picture


@pytest.fixture
def photograph(simulate, render):
    """Takes a rendered picture at the start, in a world of these fields."""

    def photograph(**fields: object) -> np.ndarray:
        simulation = simulate(**fields)
        return picture_of(simulation, render(simulation.physics))

    return photograph


def dominant(pixels: np.ndarray, channel: int) -> np.ndarray:
    """Where one colour is at least twice each of the others."""
    others = [pixels[..., c].astype(int) for c in range(3) if c != channel]
    return (pixels[..., channel] > 60) & (pixels[..., channel] > 2 * np.maximum(*others))


def columns_of(pixels: np.ndarray, channel: int = 0) -> np.ndarray:
    """Columns of a picture that have a colour."""
    return np.flatnonzero(dominant(pixels, channel).any(axis=0))


@pytest.mark.egl
def test_what_stands_ahead_is_in_the_middle(photograph):
    """A red pillar 1.5 m ahead of the lens: a column in the middle, as wide as it should be."""
    columns = columns_of(photograph(cylinders=[RED]))
    assert (columns.min() + columns.max()) / 2 == pytest.approx(159.5, abs=2)
    # Focal length 283 pixels; 0.15 m at the tangent of a circle 1.431 m away.
    assert columns.max() - columns.min() + 1 == pytest.approx(2 * 283 * 0.15 / 1.423, abs=3)


@pytest.mark.egl
def test_left_is_left_and_up_is_up(photograph):
    """A pillar on the left is left in the picture; the sky is in the first rows."""
    picture = photograph(cylinders=[{**RED, "y": 0.35}])
    assert columns_of(picture).max() < 160
    sky, floor = picture[0].mean(axis=0), picture[-1].mean(axis=0)
    assert sky.sum() > floor.sum()
    assert sky[2] > sky[0]


@pytest.mark.egl
def test_it_does_not_see_the_robot_that_carries_it(photograph):
    """On an empty floor there are tiles below and sky above, nothing black."""
    assert photograph().min() > 60


@pytest.mark.egl
def test_cameras_share_a_context_and_not_their_pictures(make_world, waffle, render):
    """Two worlds drawn in turns, in pictures of two sizes: each as if it were alone, each time."""
    large = waffle.camera.model_copy(update={"width": 640, "height": 480})
    views: list[tuple[Any, Camera, np.ndarray]] = []
    for robot in (waffle, waffle.model_copy(update={"camera": large})):
        simulation = alone(make_world(cylinders=[RED] if views else []), robot, seed=1)
        camera = render(simulation.physics, robot.camera)
        views.append((simulation, camera, picture_of(simulation, camera)))
    for simulation, camera, picture in (*views, *views):
        assert np.array_equal(picture_of(simulation, camera), picture)
    views[1][1].close()
    simulation, camera, picture = views[0]
    assert np.array_equal(picture_of(simulation, camera), picture)


BEACONS = ("red", "green", "blue", "yellow", "turquoise")


def hue(colour: np.ndarray) -> float:
    """Degrees on the colour circle: 0 red, 120 green, 240 blue."""
    return 360 * colorsys.rgb_to_hsv(*(float(channel) / 255 for channel in colour))[0]


@pytest.mark.egl
def test_a_beacon_is_seen_in_its_own_colour(photograph):
    """Its hue is that of the name, to 3 degrees, and strong; two differ by more than 25 degrees."""
    hues = []
    for colour in BEACONS:
        beacon = {"x": 1.0, "y": -0.047, "radius": 0.1, "height": 0.25, "colour": colour}
        seen = photograph(cylinders=[beacon])[130, 160]
        named = np.array(rgba(colour)[:3]) * 255
        assert abs((hue(seen) - hue(named) + 180) % 360 - 180) < 3, colour
        assert colorsys.rgb_to_hsv(*(float(channel) / 255 for channel in seen))[1] > 0.5, colour
        hues.append(hue(seen))
    ordered = sorted(hues)
    assert np.diff([*ordered, ordered[0] + 360]).min() > 25


# ---- ray by ray --------------------------------------------------------------------------


@pytest.mark.parametrize("channel", [0, 2])
def test_a_pillar_stands_where_its_geometry_says(simulate, waffle, channel):
    """Each colour fills one block of columns, on its side; the same view is the same picture."""

    def picture() -> np.ndarray:
        simulation = simulate(cylinders=PILLARS)
        return picture_of(simulation, RaycastCamera(simulation.physics.model, waffle.camera))

    first = picture()
    columns = columns_of(first, channel)
    assert len(columns) == columns.max() - columns.min() + 1 > 30
    assert (columns.max() < 160) == (channel == 0), "red is left, blue is right"
    assert np.array_equal(first, picture())


@pytest.mark.egl
@pytest.mark.parametrize("channel", [0, 2])
def test_it_agrees_with_the_renderer(simulate, waffle, render, channel):
    """Of the pixels that either camera gives a pillar's colour, 97 in a hundred are the same."""
    simulation = simulate(cylinders=PILLARS)
    rendered, cast = (
        dominant(picture_of(simulation, camera), channel)
        for camera in (
            render(simulation.physics),
            RaycastCamera(simulation.physics.model, waffle.camera),
        )
    )
    assert (rendered & cast).sum() / (rendered | cast).sum() > 0.97


# ---- a machine without EGL ---------------------------------------------------------------


def refuse(*_: object) -> None:
    """What the bindings do where there is no display device."""
    raise ImportError("Cannot initialize a EGL device display.\nSecond line")


@pytest.mark.parametrize(
    ("module", "expected"),
    [
        (None, r"EGL cannot be used .*apt-get install libegl1 libgl1"),
        (SimpleNamespace(GLContext=refuse), "ImportError: Cannot "),
    ],
    ids=["no library", "a driver that refuses"],
)
def test_without_egl_the_error_names_what_to_install(
    simulate, waffle, monkeypatch, module, expected
):
    """In one line: only the first of what the driver says."""
    canvas._gl_context.cache_clear()  # the process keeps one
    monkeypatch.setitem(sys.modules, "mujoco.egl", module)
    with pytest.raises(NoCameraError, match=expected) as caught:
        Camera(simulate().physics.model, waffle.camera)
    canvas._gl_context.cache_clear()
    assert "\n" not in str(caught.value)


# ---- noise -------------------------------------------------------------------------------


def pictures(make_stage, waffle, seed: int, *, noise: bool) -> list[bytes]:
    """What the camera shows on a drive of 2 s through stage 3."""
    robot = waffle.with_sensors(SensorsModel.model_validate({"camera": {"noise": noise}}))
    here = make_stage(load_world("dqn_stage3"), "camera/image_raw", robot=robot, seed=seed)
    for step in range(40):
        here.run(1_000_000_000 + step * 50_000_000)
        here.command(0.2, 0.6)
    images = [bytes(message.data) for message in here.messages("camera/image_raw")]
    here.close()
    return images


@pytest.mark.egl
@pytest.mark.parametrize("noise", sample([False, True], 2))
def test_a_repeated_run_gives_the_same_pictures(make_stage, waffle, noise):
    """Pixel for pixel, 20 of them, past moving obstacles; the seed decides the noise alone."""
    first = pictures(make_stage, waffle, 1, noise=noise)
    assert len(first) == len(set(first)) == 20
    assert pictures(make_stage, waffle, 1, noise=noise) == first
    assert (pictures(make_stage, waffle, 2, noise=noise) == first) == (not noise)


def test_noise_is_7_thousandths_of_full_scale():
    """1.8 of 255, in every channel, and nothing wraps round."""
    noisy, white = np.full((60, 80, 3), 128, dtype=np.uint8), np.full((60, 80, 3), 255, np.uint8)
    for picture in (noisy, white):
        PictureNoise(1, "camera").add(picture, 3)
    assert noisy.astype(float).std() == pytest.approx(255 * 0.007, rel=0.05)
    assert white.min() > 240
