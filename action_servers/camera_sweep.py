"""Turn left and take pictures on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from action_servers.drive import Drive
from action_servers.freshness import stale
from action_servers.limits import first_fault, outside
from action_servers.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Finished,
    Image,
    Observation,
    Refusal,
    Twist2D,
    Value,
)
from action_servers.rotation import ARRIVED_WITHIN, Rotation
from bt_mission.common.robot import RobotModel

MAX_ANGLE_DEG = 180.0
MAX_IMAGES = 30
"""The limits of the Sheffield course's camera sweep for Jazzy, whose missions run here too."""

SPEED = 0.2
"""rad/s, left: slow enough for sharp pictures; 180 deg take 15.7 s. The same course's figure."""

IMAGE_PATIENCE_S = 2.0
"""Seconds to wait for a picture: twenty of a camera at 10 Hz."""


class Goal(Protocol):
    """The goal fields of `bt_mission_interfaces/action/CameraSweep`."""

    @property
    def sweep_angle(self) -> float:
        """How far to turn left, degrees."""

    @property
    def image_count(self) -> int:
        """Number of pictures, one at the end of each equal part of the angle."""


class ImageStore(Protocol):
    """Where the pictures of one goal go. Each method may raise OSError."""

    name: str
    """Name of the folder; may be set until it is opened."""

    @property
    def folder(self) -> str:
        """Path of the folder; empty until it is opened."""

    def open(self) -> None:
        """Make the folder."""

    def save(self, number: int, image: Image) -> str:
        """Write picture `number` (1, 2, ...) and return its path."""


class CameraSwitch(Protocol):
    """Whether pictures are sent; both may be called in any state."""

    def on(self) -> None:
        """Have pictures sent; they come with the observations from then on."""

    def off(self) -> None:
        """Have no more pictures sent."""


def plan(
    goal: Goal, now: Observation, robot: RobotModel, camera: CameraSwitch, store: ImageStore
) -> CameraSweep | Refusal:
    """Check a goal against the robot and what it sees."""
    if robot.camera is None:
        return Refusal(f"the robot '{robot.name}' has no camera")
    fault = first_fault(
        _outside_angle(goal.sweep_angle),
        outside("image_count", goal.image_count, 1, MAX_IMAGES, "images"),
    )
    if fault is not None:
        return Refusal(fault)
    unready = stale(now)
    if unready is not None:
        return Refusal(unready.reason)
    return CameraSweep(math.radians(goal.sweep_angle), goal.image_count, robot, camera, store)


def _outside_angle(angle_deg: float) -> str | None:
    if angle_deg <= 0.0:
        return f"sweep_angle must be above 0 and at most {MAX_ANGLE_DEG:g} deg, got {angle_deg:g}"
    return outside("sweep_angle", angle_deg, 0.0, MAX_ANGLE_DEG, "deg")


class CameraSweep:
    """Turns left by `angle` (radians) and takes `count` pictures, one after each equal part.

    It does not turn before the folder is made and the camera is seen to work. A picture counts
    only if it was taken after it was asked for, and only once. The robot waits where the next
    picture is due while the last one is still on its way. The camera is on only while a picture is
    waited for, since sending pictures is by far the most costly thing that a robot's sensors do.
    """

    needs_base = True

    def __init__(
        self,
        angle: float,
        count: int,
        robot: RobotModel,
        camera: CameraSwitch,
        store: ImageStore,
    ) -> None:
        self._angle = angle
        self._count = count
        self.store = store
        self._camera = camera
        self._drive = Drive(robot)
        self._rotation = Rotation(self._drive, robot)
        self._asked_s: float | None = None
        self._seen: Image | None = None
        self._camera_works = False
        self._opened = False
        self._paths: list[str] = []
        self._told: tuple[int, float] | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Take the picture that is due, and turn on."""
        fault = self._drive.fault(now) or self._store_images(now)
        if fault is not None:
            return fault
        if not self._camera_works:
            return ZERO
        if len(self._paths) == self._count:
            return self._drive.rest(now) or SUCCEEDED
        if self._asked_s is not None and self._due(len(self._paths) + 2):
            return self._drive.rest(now) or ZERO
        return self._rotation.towards(now, self._angle, SPEED) or ZERO

    def feedback(self) -> Mapping[str, Value] | None:
        """Return pictures taken and angle turned, when either has changed."""
        telling = (len(self._paths), self._drive.yaw)
        if telling == self._told:
            return None
        self._told = telling
        return {"current_image": telling[0], "current_angle": math.degrees(telling[1])}

    def result(self) -> Mapping[str, Value]:
        """Return the folder (empty when none was made) and the path of every picture taken."""
        return {"image_path": self.store.folder, "image_paths": tuple(self._paths)}

    def _store_images(self, now: Observation) -> Finished | None:
        """Ask for the picture that is due, and take the one that was asked for."""
        try:
            if not self._opened:
                self.store.open()
                self._opened = True
            self._ask(now)
            if self._asked_s is None:
                return None
            image = now.image
            if image is None or image is self._seen or image.stamp_s < self._asked_s:
                return self._out_of_patience(now)
            self._seen = image
            self._asked_s = None
            self._camera.off()
            if self._camera_works:
                number = len(self._paths) + 1
                self._paths.append(self.store.save(number, image))
            self._camera_works = True
            self._ask(now)
        except OSError as error:
            return Finished(
                "aborted", ErrorCode.STORAGE, f"cannot store image {len(self._paths) + 1}: {error}"
            )
        return None

    def _ask(self, now: Observation) -> None:
        """Ask for a picture: the first to see that the camera works, then one at each part."""
        if self._asked_s is not None or len(self._paths) == self._count:
            return
        if not self._camera_works or self._due(len(self._paths) + 1):
            self._asked_s = now.time_s
            self._camera.on()

    def _due(self, number: int) -> bool:
        """Return whether the robot has turned to where picture `number` is taken."""
        angle = self._angle * min(number, self._count) / self._count
        return self._drive.yaw >= angle - ARRIVED_WITHIN

    def _out_of_patience(self, now: Observation) -> Finished | None:
        if self._asked_s is None or now.time_s - self._asked_s < IMAGE_PATIENCE_S:
            return None
        return Finished(
            "aborted",
            ErrorCode.NO_IMAGE,
            f"no image from the camera within {IMAGE_PATIENCE_S:g} s, "
            f"{len(self._paths)} of {self._count} taken",
        )
