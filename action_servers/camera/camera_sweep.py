"""Turn left and take images during the turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from action_servers.camera.camera import CameraTuning, Snapshot, encoded, load_formats, looking
from action_servers.core.action import Action, CameraSwitch, FeedbackRanges
from action_servers.core.limits import OVERSHOOT_DEG, Limits, NumberLimit, around, parameter
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Image,
    Observation,
)
from action_servers.core.progress import ChangedFields
from action_servers.driving.drive import TURNED_WITHIN, Drive
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.robots.model import RobotModel

# The lowest level that compresses at all: seven times faster than Pillow's default for files a
# fifth larger, and a picture is written between two control steps.
COMPRESS_LEVEL = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepTuning(CameraTuning):
    """Of camera sweeps."""

    sweep_velocity: float = number(
        0.2,
        (0.05, 3.0),
        "Speed of a camera sweep, rad/s: slow enough for sharp pictures (the Sheffield course's).",
    )
    sweep_images: int = number(
        30, (1, 1000), "Most pictures of one camera sweep (the Sheffield course's limit)."
    )


SWEEPS = SweepTuning()
"""The defaults."""


class ImageFolder:
    """The folder of one goal, `root`/`name`; `name` may be set until it is opened.

    If that name exists, a number is added: the images of an earlier goal are never changed.
    """

    def __init__(self, root: Path, name: str = "images") -> None:
        self.name = name
        self._root = root
        self._path: Path | None = None

    @property
    def folder(self) -> str:
        """Full path of the folder; empty before it is opened."""
        return str(self._path or "")

    def open(self) -> None:
        """Make the folder, and those above it. Raises OSError."""
        root = self._root.expanduser().resolve()
        root.mkdir(parents=True, exist_ok=True)
        path, number = root / self.name, 1
        while True:
            try:
                path.mkdir()
            except FileExistsError:
                number += 1
                path = root / f"{self.name}_{number}"
            else:
                self._path = path
                return

    def save(self, number: int, image: Image) -> str:
        """Write `image_NN.png` and return its full path; an OSError leaves no partial file."""
        if self._path is None:
            raise FileNotFoundError("the folder has not been opened")
        contents = encoded(image, "PNG", compress_level=COMPRESS_LEVEL)
        path = self._path / f"image_{number:02d}.png"
        try:
            path.write_bytes(contents)
        except OSError:
            with suppress(OSError):
                path.unlink(missing_ok=True)
            raise
        return str(path)


def limits(_robot: RobotModel, tuning: SweepTuning) -> Limits:
    """Return the limits of `camera_sweep`; the angle's is that of the Sheffield course."""
    return (
        NumberLimit(
            field="sweep_angle",
            low=0.0,
            high=180.0,
            unit="deg",
            source="the Sheffield course's camera sweep",
            above=True,
        ),
        NumberLimit(
            field="image_count",
            low=1,
            high=tuning.sweep_images,
            unit="images",
            source=parameter("sweep_images"),
        ),
    )


def feedback(goal: Any) -> FeedbackRanges:
    """Return the ranges of pictures and angle."""
    return {
        "current_image": (0.0, goal.image_count),
        "current_angle": around(goal.sweep_angle, OVERSHOOT_DEG),
    }


def plan(
    goal: Any,
    now: Observation,
    robot: RobotModel,
    camera: CameraSwitch,
    image_folder: Path,
    tuning: SweepTuning = SWEEPS,
) -> CameraSweep:
    """Return the maneuver for a goal."""
    store = ImageFolder(image_folder, f"sweep_{now.time_s:.3f}")
    angle = math.radians(goal.sweep_angle)
    return CameraSweep(angle, goal.image_count, robot, camera, store, tuning)


@contextmanager
def sweeping(sweep: CameraSweep, goal_id: str) -> Iterator[None]:
    """Name the folder after the goal, and turn the camera off at its end."""
    sweep.store.name += f"_{goal_id[:8]}"
    with looking(sweep, goal_id):
        yield


class CameraSweep:
    """Turns left by `angle` (radians) and takes `count` images, one after each equal part.

    It turns only once the folder is created and the camera works. An image counts only if it was
    taken after it was asked for, and only once. The robot waits at the place of the next image
    until the last one has arrived.
    """

    needs_base = True

    def __init__(
        self,
        angle: float,
        count: int,
        robot: RobotModel,
        camera: CameraSwitch,
        store: ImageFolder,
        tuning: SweepTuning = SWEEPS,
    ) -> None:
        self._angle = angle
        self._count = count
        self.store = store
        self._speed = min(tuning.sweep_velocity, robot.max_angular_velocity)
        self.camera = camera
        self._snapshot = Snapshot(camera, tuning.image_timeout)
        self._drive = Drive(robot, tuning)
        self._camera_works = False
        self._opened = False
        self._paths: list[str] = []
        self._changed = ChangedFields()

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
        return self._drive.turn_towards(now, self._angle, self._speed) or ZERO

    def feedback(self) -> Fields | None:
        """Return pictures taken and angle turned, when either has changed."""
        angle = math.degrees(self._drive.yaw)
        return self._changed.of({"current_image": len(self._paths), "current_angle": angle})

    def result(self) -> Fields:
        """Return the folder (empty without one) and the path of every image taken."""
        return {"image_path": self.store.folder, "image_paths": tuple(self._paths)}

    def _store_images(self, now: Observation) -> Finished | None:
        """Ask for the image that is due, and save the one that was asked for."""
        try:
            if not self._opened:
                self.store.open()
                self._opened = True
            self._ask(now)
            taken = self._snapshot.take(now)
            if isinstance(taken, Finished):
                done = f"{len(self._paths)} of {self._count} taken"
                return replace(taken, reason=f"{taken.reason}, {done}")
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
        """Ask for an image: the first checks the camera, then one at each part."""
        if self._snapshot.is_asked_for or len(self._paths) == self._count:
            return
        if not self._camera_works or self._due(len(self._paths) + 1):
            self._snapshot.ask(now)

    def _due(self, number: int) -> bool:
        """Return whether the robot has turned to where picture `number` is taken."""
        angle = self._angle * min(number, self._count) / self._count
        return self._drive.yaw >= angle - TURNED_WITHIN


CAMERA_SWEEP = Action(
    name="camera_sweep",
    type="bt_mission_interfaces/action/CameraSweep",
    needs=("base", "scan", "odometry", "camera"),
    example={"sweep_angle": 180.0, "image_count": 6},
    plan=plan,
    tuning=SWEEPS,
    limits=limits,
    feedback=feedback,
    offered=load_formats,
    during=sweeping,
)
