"""Turn left and take pictures on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from action_servers.camera.camera import CameraSwitch, Snapshot
from action_servers.core.checks import refusal, stale
from action_servers.core.goal_limits import camera_sweep_limits
from action_servers.core.limits import faults
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Finished,
    Image,
    Observation,
    Refusal,
    Value,
)
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.drive import DriveGuard
from action_servers.driving.rotation import ARRIVED_WITHIN, Rotation
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel


class CameraSweepGoal(Protocol):
    """The goal fields of `bt_mission_interfaces/action/CameraSweep`."""

    sweep_angle: float
    """How far to turn left, degrees."""
    image_count: int
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


def plan(
    goal: CameraSweepGoal,
    now: Observation,
    robot: RobotModel,
    camera: CameraSwitch,
    store: ImageStore,
    tuning: Tuning = TUNING,
) -> CameraSweep | Refusal:
    """Check a goal against the robot and what it sees."""
    if robot.camera is None:
        return Refusal(f"the robot '{robot.name}' has no camera")
    wrong = faults(goal, camera_sweep_limits(tuning))
    refused = refusal(*wrong, unready=stale(now, tuning.sensor_timeout))
    angle = math.radians(goal.sweep_angle)
    return refused or CameraSweep(angle, goal.image_count, robot, camera, store, tuning)


class CameraSweep:
    """Turns left by `angle` (radians) and takes `count` pictures, one after each equal part.

    It does not turn before the folder is made and the camera is seen to work. A picture counts
    only if it was taken after it was asked for, and only once. The robot waits where the next
    picture is due while the last one is still on its way.
    """

    needs_base = True

    def __init__(
        self,
        angle: float,
        count: int,
        robot: RobotModel,
        camera: CameraSwitch,
        store: ImageStore,
        tuning: Tuning = TUNING,
    ) -> None:
        self._angle = angle
        self._count = count
        self.store = store
        self._speed = min(tuning.sweep_velocity, robot.max_angular_velocity)
        self.camera = camera
        self._snapshot = Snapshot(camera, tuning.image_timeout)
        self._drive = DriveGuard(robot, tuning)
        self._rotation = Rotation(self._drive, robot, tuning)
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
        if self._snapshot.is_asked_for and self._due(len(self._paths) + 2):
            return self._drive.rest(now) or ZERO
        return self._rotation.towards(now, self._angle, self._speed) or ZERO

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
            taken = self._snapshot.take(now)
            if isinstance(taken, Finished):
                return self._without_image(taken)
            if taken is None:
                return None
            if self._camera_works:
                number = len(self._paths) + 1
                self._paths.append(self.store.save(number, taken))
            self._camera_works = True
            self._ask(now)
        except OSError as error:
            return Finished(
                "aborted", ErrorCode.STORAGE, f"cannot store image {len(self._paths) + 1}: {error}"
            )
        return None

    def _ask(self, now: Observation) -> None:
        """Ask for a picture: the first to see that the camera works, then one at each part."""
        if self._snapshot.is_asked_for or len(self._paths) == self._count:
            return
        if not self._camera_works or self._due(len(self._paths) + 1):
            self._snapshot.ask(now)

    def _due(self, number: int) -> bool:
        """Return whether the robot has turned to where picture `number` is taken."""
        angle = self._angle * min(number, self._count) / self._count
        return self._drive.yaw >= angle - ARRIVED_WITHIN

    def _without_image(self, end: Finished) -> Finished:
        done = f"{len(self._paths)} of {self._count} taken"
        return Finished(end.status, end.error_code, f"{end.reason}, {done}")
