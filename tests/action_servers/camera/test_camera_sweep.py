"""Facts about turning and taking pictures, and where the pictures go."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from PIL import Image as Picture

from action_servers.camera.camera_sweep import CameraSweep, ImageFolder
from action_servers.core.maneuver import SUCCEEDED, ErrorCode, Image
from bt_mission.base.geometry import Twist2D


class FakeCamera:
    """Sends pictures while it is on, if it works."""

    def __init__(self, base: Any) -> None:
        self.base = base
        self.works = True
        self.switched: list[str] = []

    def on(self) -> None:
        self.switched.append("on")
        self.base.sees_images = self.works

    def off(self) -> None:
        self.switched.append("off")
        self.base.sees_images = False


class FakeStore:
    """Keeps pictures in memory, with the angle at which each was saved."""

    def __init__(self, base: Any) -> None:
        self.base = base
        self.camera = FakeCamera(base)
        self.name = ""
        self.folder = ""
        self.saved: list[tuple[int, float, float]] = []
        self.fails_at: int | None = None

    def open(self) -> None:
        if self.fails_at == 0:
            raise PermissionError(13, "Permission denied", "/images")
        self.folder = "/images/sweep"

    def save(self, number: int, image: Image) -> str:
        if number == self.fails_at:
            raise OSError(28, "No space left on device")
        self.saved.append((number, image.stamp_s, math.degrees(self.base.yaw)))
        return f"{self.folder}/image_{number:02d}.png"


@pytest.fixture
def base(fake, waffle):
    """A robot with a camera."""
    return fake(waffle)


@pytest.fixture
def store(base):
    """A store in memory."""
    return FakeStore(base)


def sweep(base: Any, store: Any, angle_deg: float, count: int) -> Any:
    """A sweep over an angle."""
    return CameraSweep(math.radians(angle_deg), count, base.robot, store.camera, store)


@pytest.mark.parametrize(("angle", "count"), [(180, 8), (90, 1), (180, 30), (45, 5)])
def test_takes_one_picture_after_each_part_of_the_angle(base, store, angle, count):
    """Picture k is taken within a camera period (1.2 deg) of k/n of the angle."""
    maneuver = sweep(base, store, angle, count)
    assert base.run(maneuver) == SUCCEEDED
    assert [number for number, _, _ in store.saved] == list(range(1, count + 1))
    for number, _, at in store.saved:
        assert at == pytest.approx(angle * number / count, abs=1.6)
    assert math.degrees(base.yaw) == pytest.approx(angle, abs=1.0)


def test_turns_left_at_a_fifth_of_a_radian_per_second(base, store):
    """180 degrees take 15.7 s, and the start and the stop."""
    base.run(sweep(base, store, 180, 8))
    assert max(twist.angular for twist in base.twists) == 0.2
    assert min(twist.angular for twist in base.twists) == 0.0
    assert base.time_s - 10.0 == pytest.approx(math.pi / 0.2, abs=0.8)


def test_names_folder_and_pictures_in_the_result(base, store):
    """Paths in the order taken."""
    maneuver = sweep(base, store, 30, 2)
    assert maneuver.result() == {"image_path": "", "image_paths": ()}
    base.run(maneuver)
    assert maneuver.result() == {
        "image_path": "/images/sweep",
        "image_paths": ("/images/sweep/image_01.png", "/images/sweep/image_02.png"),
    }


def test_a_picture_is_newer_than_the_moment_it_was_asked_for(base, store):
    """An old picture that still lies there is not taken."""
    base.changes = {"image": Image(9.99, 2, 3, np.zeros((2, 3, 3), dtype=np.uint8))}
    finished = base.run(sweep(base, store, 90, 3))
    assert finished.error_code == ErrorCode.NO_IMAGE
    assert store.saved == []


def test_the_camera_is_on_only_while_a_picture_is_waited_for(base, store):
    """One picture more than asked for is sent: the first shows that the camera works."""
    seen = set()
    maneuver = sweep(base, store, 90, 3)
    answer = None
    while answer != SUCCEEDED:
        now = base.observe()
        seen.add(now.image)
        answer = maneuver.step(now)
        if answer != SUCCEEDED:
            base.move(answer)
    assert store.camera.switched == ["on", "off"] * 4
    assert len(seen - {None}) == 4


def test_every_picture_is_another_one(base, store):
    """Even when the parts of the angle are smaller than the robot turns between two pictures."""
    base.run(sweep(base, store, 1, 30))
    stamps = [stamp for _, stamp, _ in store.saved]
    assert len(set(stamps)) == 30
    assert math.degrees(base.yaw) == pytest.approx(1.0, abs=0.5)


def test_does_not_turn_before_the_camera_is_seen_to_work(base, store):
    """Without pictures it gives up after two seconds, and has not moved."""
    store.camera.works = False
    finished = base.run(sweep(base, store, 90, 3))
    assert (finished.status, finished.error_code) == ("aborted", ErrorCode.NO_IMAGE)
    assert finished.reason == "no image from the camera within 2 s, 0 of 3 taken"
    assert set(base.twists) == {Twist2D()}
    assert base.time_s == pytest.approx(12.0)


def test_waits_for_a_camera_that_falls_silent_and_then_gives_up(base, store):
    """It does not turn past where the next picture is due."""
    maneuver = sweep(base, store, 90, 9)
    base.run_for(maneuver, 3.0)
    store.camera.works = base.sees_images = False
    finished = base.run(maneuver)
    assert finished.error_code == ErrorCode.NO_IMAGE
    assert len(store.saved) == 3
    assert math.degrees(base.yaw) == pytest.approx(50.0, abs=1.0)


@pytest.mark.parametrize(
    ("fails_at", "reason", "taken"),
    [
        (0, "cannot store image 1: [Errno 13] Permission denied: '/images'", 0),
        (3, "cannot store image 3: [Errno 28] No space left on device", 2),
    ],
)
def test_a_picture_that_cannot_be_stored_ends_the_goal(base, store, fails_at, reason, taken):
    """With the operating system's reason; what was taken is kept, and without any it stands."""
    store.fails_at = fails_at
    maneuver = sweep(base, store, 90, 5)
    finished = base.run(maneuver)
    assert (finished.error_code, finished.reason) == (ErrorCode.STORAGE, reason)
    assert len(maneuver.result()["image_paths"]) == taken
    assert (set(base.twists) == {Twist2D()}) is not bool(taken)


def test_feedback_counts_pictures_and_degrees(base, store):
    """Given when either has changed."""
    maneuver = sweep(base, store, 90, 9)
    reports = []
    for _ in range(60):
        base.move(maneuver.step(base.observe()))
        feedback = maneuver.feedback()
        if feedback is not None:
            reports.append((feedback["current_image"], feedback["current_angle"]))
    assert reports == sorted(set(reports))
    assert reports[0] == (0, 0.0)
    assert reports[-1][0] == 3
    assert maneuver.feedback() is None


def test_keeps_clear_of_walls(fake, waffle):
    """The sweep ends before the rear meets a wall."""
    base = fake(waffle, [(0.0, -0.21, 0.0, -0.5)])
    finished = base.run(sweep(base, FakeStore(base), 180, 4))
    assert finished.error_code == ErrorCode.BLOCKED
    assert finished.reason.startswith("no room to turn left")


@pytest.fixture
def image():
    """A picture of noise."""
    rgb = np.random.default_rng(7).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    return Image(1.0, 24, 32, rgb)


@pytest.mark.parametrize("order", [1, -1])
def test_pictures_are_png_files_of_every_pixel(tmp_path, image, order):
    """Full paths, numbered with two digits; also of a view with a negative stride, as of bgr8."""
    store = ImageFolder(tmp_path / "images", "sweep")
    store.open()
    seen = Image(1.0, 24, 32, image.rgb[:, :, ::order])
    path = store.save(1, seen)
    assert path == str(tmp_path / "images" / "sweep" / "image_01.png")
    with Picture.open(path) as picture:
        assert picture.format == "PNG"
        np.testing.assert_array_equal(np.asarray(picture), seen.rgb)


def test_every_goal_has_a_folder_of_its_own(tmp_path):
    """A name that is taken gets a number, and nothing in the older folder is touched."""
    folders = []
    for _ in range(3):
        store = ImageFolder(tmp_path, "sweep")
        store.open()
        folders.append(store.folder)
    assert folders == [str(tmp_path / name) for name in ("sweep", "sweep_2", "sweep_3")]


def test_the_path_is_full(tmp_path, monkeypatch):
    """Also when the folder was given relative to where the server runs."""
    monkeypatch.chdir(tmp_path)
    store = ImageFolder(tmp_path.__class__("images"))
    assert store.folder == ""
    store.open()
    assert store.folder == str(tmp_path / "images" / "images")


def test_a_file_in_the_way_is_told(tmp_path):
    """By the operating system's own error."""
    (tmp_path / "images").write_text("a file")
    with pytest.raises(OSError, match="File exists"):
        ImageFolder(tmp_path / "images").open()


def test_no_part_of_a_picture_is_left_when_the_disk_is_full(tmp_path, image, monkeypatch):
    """A torn file would be taken for a picture."""
    store = ImageFolder(tmp_path)
    store.open()

    def full(path, data):
        with path.open("wb") as file:
            file.write(bytes(data)[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tmp_path.__class__, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        store.save(1, image)
    assert list((tmp_path / "images").iterdir()) == []


def test_a_folder_that_vanished_is_told(tmp_path, image):
    """Somebody tidied up during the sweep."""
    store = ImageFolder(tmp_path)
    store.open()
    (tmp_path / "images").rmdir()
    with pytest.raises(FileNotFoundError):
        store.save(1, image)
