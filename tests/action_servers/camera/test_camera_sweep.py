"""Facts about turning and taking pictures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from action_servers.camera.camera_sweep import CameraSweep
from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import SUCCEEDED, Image
from bt_mission.core.geometry import Twist2D


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


def test_folder_that_cannot_be_made_ends_the_goal_without_moving(base, store):
    """The reason is the operating system's."""
    store.fails_at = 0
    finished = base.run(sweep(base, store, 90, 3))
    assert finished.error_code == ErrorCode.STORAGE
    assert finished.reason == ("cannot store image 1: [Errno 13] Permission denied: '/images'")
    assert set(base.twists) == {Twist2D()}


def test_full_disk_ends_the_goal_and_keeps_what_was_taken(base, store):
    """The result names the pictures that are there."""
    store.fails_at = 3
    maneuver = sweep(base, store, 90, 5)
    finished = base.run(maneuver)
    assert finished.error_code == ErrorCode.STORAGE
    assert finished.reason == "cannot store image 3: [Errno 28] No space left on device"
    assert len(maneuver.result()["image_paths"]) == 2


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


def test_blocked_robot_gives_up(base, store):
    """A base that does not turn ends the goal."""
    base.stuck = True
    assert base.run(sweep(base, store, 90, 3)).error_code == ErrorCode.BLOCKED


def test_keeps_clear_of_walls(fake, waffle):
    """The sweep ends before the rear meets a wall."""
    base = fake(waffle, [(0.0, -0.21, 0.0, -0.5)])
    finished = base.run(sweep(base, FakeStore(base), 180, 4))
    assert finished.error_code == ErrorCode.BLOCKED
    assert finished.reason.startswith("no room to turn left")
