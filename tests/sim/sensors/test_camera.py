"""Pictures: what they show, and what a machine without EGL is told."""

import colorsys
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from bt_mission.core.robot.model import SensorsModel
from sim.sensors import canvas
from sim.sensors.camera import Camera
from sim.sensors.canvas import NoCameraError
from sim.sensors.noise import PictureNoise
from sim.world.colours import rgba
from sim.world.loader import load_world
from tests.support.simulated import alone

RED = {"name": "red", "x": 1.5, "y": -0.047, "radius": 0.15, "height": 0.5, "colour": "red"}


@pytest.fixture
def photograph(simulate, waffle):
    """Takes a picture at the start, in a world of these fields; skips where there is no EGL."""

    def photograph(**fields: object) -> np.ndarray:
        simulation = simulate(**fields)
        try:
            camera = Camera(simulation.physics.model, waffle.camera)
        except NoCameraError as error:
            pytest.skip(str(error))
        picture = np.zeros((waffle.camera.height, waffle.camera.width, 3), dtype=np.uint8)
        camera.draw(simulation.physics.data, picture)
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


@pytest.mark.egl
def test_cameras_share_a_context_and_not_their_pictures(make_world, waffle):
    """Two worlds drawn in turns, in pictures of two sizes: each as if it were alone."""
    large = waffle.camera.model_copy(update={"width": 640, "height": 480})
    views = []
    for robot in (waffle, waffle.model_copy(update={"camera": large})):
        spec = robot.camera
        simulation = alone(make_world(cylinders=[RED] if spec is large else []), robot, seed=1)
        try:
            camera = Camera(simulation.physics.model, spec)
        except NoCameraError as error:
            pytest.skip(str(error))
        picture = np.zeros((spec.height, spec.width, 3), dtype=np.uint8)
        camera.draw(simulation.physics.data, picture)
        views.append((camera, simulation.physics.data, picture))
    for camera, data, picture in (*views, *views):
        again = np.zeros_like(picture)
        camera.draw(data, again)
        assert np.array_equal(again, picture)
    (first, data, picture), (second, *_) = views
    second.close()
    again = np.zeros_like(picture)
    first.draw(data, again)
    assert np.array_equal(again, picture)
    first.close()


@pytest.fixture
def no_context_yet():
    """The process has not made the context that it keeps."""
    canvas._gl_context.cache_clear()
    yield
    canvas._gl_context.cache_clear()


def refuse(*_: object) -> None:
    """What the bindings do where there is no display device."""
    raise ImportError("Cannot initialize a EGL device display.\nSecond line")


@pytest.mark.usefixtures("no_context_yet")
def test_a_machine_without_egl_is_told_what_to_install(simulate, waffle, monkeypatch):
    """One error of ours, with the cause in a few words."""
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    with pytest.raises(NoCameraError, match=r"EGL cannot be used .*apt-get install libegl1 libgl1"):
        Camera(simulate().physics.model, waffle.camera)


@pytest.mark.usefixtures("no_context_yet")
def test_a_driver_that_refuses_is_told_in_one_line(simulate, waffle, monkeypatch):
    """Only the first line of what the driver says."""
    monkeypatch.setitem(sys.modules, "mujoco.egl", SimpleNamespace(GLContext=refuse))
    with pytest.raises(NoCameraError) as caught:
        Camera(simulate().physics.model, waffle.camera)
    assert "ImportError: Cannot " in str(caught.value)
    assert "\n" not in str(caught.value)


BEACONS = ("red", "green", "blue", "yellow", "turquoise")


def hue(colour: np.ndarray) -> float:
    """Degrees on the colour circle: 0 red, 120 green, 240 blue."""
    return 360 * colorsys.rgb_to_hsv(*(float(channel) / 255 for channel in colour))[0]


@pytest.mark.egl
@pytest.mark.parametrize("colour", BEACONS)
def test_a_beacon_is_seen_in_its_own_colour(photograph, colour):
    """Its hue in the picture is that of the name, to 3 degrees; strong enough to be told."""
    beacon = {"x": 1.0, "y": -0.047, "radius": 0.1, "height": 0.25, "colour": colour}
    seen = photograph(cylinders=[beacon])[130, 160]
    named = np.array(rgba(colour)[:3]) * 255
    assert abs((hue(seen) - hue(named) + 180) % 360 - 180) < 3
    assert colorsys.rgb_to_hsv(*(float(channel) / 255 for channel in seen))[1] > 0.5


@pytest.mark.egl
def test_beacons_differ_in_hue_by_more_than_25_degrees(photograph):
    """The nearest two are told apart by colour alone."""
    hues = []
    for colour in BEACONS:
        beacon = {"x": 1.0, "y": -0.047, "radius": 0.1, "height": 0.25, "colour": colour}
        hues.append(hue(photograph(cylinders=[beacon])[130, 160]))
    ordered = sorted(hues)
    gaps = np.diff([*ordered, ordered[0] + 360])
    assert gaps.min() > 25


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
@pytest.mark.parametrize("noise", [False, True])
def test_a_repeated_run_gives_the_same_pictures(make_stage, waffle, noise):
    """Pixel for pixel, 20 of them, past moving obstacles; the seed decides the noise alone."""
    first = pictures(make_stage, waffle, 1, noise=noise)
    assert len(first) == 20
    assert len(set(first)) == 20
    assert pictures(make_stage, waffle, 1, noise=noise) == first
    assert (pictures(make_stage, waffle, 2, noise=noise) == first) == (not noise)


def test_noise_is_7_thousandths_of_full_scale():
    """1.8 of 255, in every channel, and nothing wraps round."""
    plain = np.full((60, 80, 3), 128, dtype=np.uint8)
    noisy, again, white = plain.copy(), plain.copy(), np.full_like(plain, 255)
    PictureNoise(1, "camera").add(noisy, 3)
    PictureNoise(1, "camera").add(again, 3)
    PictureNoise(1, "camera").add(white, 3)
    assert noisy.astype(float).std() == pytest.approx(255 * 0.007, rel=0.05)
    assert np.array_equal(noisy, again)
    assert white.min() > 240
