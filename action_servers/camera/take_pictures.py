"""Take one image a second, whatever drives the base."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from action_servers.camera.camera import CameraTuning, Snapshot, encoded, load_formats, looking
from action_servers.core.action import Action, CameraSwitch
from action_servers.core.limits import NumberLimit, parameter
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    Fields,
    Finished,
    Image,
    Observation,
)
from action_servers.core.progress import Ticker
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class PicturesTuning(CameraTuning):
    """Of pictures one a second."""

    pictures: int = number(
        60, (1, 600), "Most pictures of one goal of take_pictures; they are kept in memory."
    )
    picture_quality: int = number(90, (1, 95), "Quality of JPEG pictures, as Pillow counts it.")


PICTURES = PicturesTuning()
"""The defaults."""


def plan(
    goal: Any, _now: Observation, camera: CameraSwitch, tuning: PicturesTuning = PICTURES
) -> TakePictures:
    """Return the maneuver for a goal."""
    return TakePictures(goal.nseconds, camera, tuning)


class TakePictures:
    """Takes image k at second k of the goal, or as soon after as the camera sends one."""

    needs_base = False

    def __init__(self, count: int, camera: CameraSwitch, tuning: PicturesTuning = PICTURES) -> None:
        self._count = count
        self._quality = tuning.picture_quality
        self.camera = camera
        self._snapshot = Snapshot(camera, tuning.image_timeout)
        self._ticker = Ticker()
        self._pictures: list[Fields] = []
        self._sent_count = 0

    def step(self, now: Observation) -> Twist2D | Finished:
        """Ask for the image that is due, and keep it when it arrives."""
        self._ticker.update(now.time_s)
        taken = self._snapshot.take(now)
        if isinstance(taken, Finished):
            done = f"{len(self._pictures)} of {self._count} taken"
            return replace(taken, reason=f"{taken.reason}, {done}")
        if taken is not None:
            self._pictures.append(compressed(taken, self._quality))
        if len(self._pictures) == self._count:
            return SUCCEEDED
        if not self._snapshot.is_asked_for and self._ticker.has_reached(len(self._pictures) + 1):
            self._snapshot.ask(now)
        return ZERO

    def feedback(self) -> Fields | None:
        """Return the picture that was just taken."""
        if len(self._pictures) == self._sent_count:
            return None
        self._sent_count = len(self._pictures)
        return {"last_image": self._pictures[-1]}

    def result(self) -> Fields:
        """Return the pictures taken."""
        return {"all_pictures": tuple(self._pictures)}


def compressed(image: Image, quality: int) -> Fields:
    """Return the fields of a `sensor_msgs/CompressedImage`: a JPEG of 1 to 95 of `quality`."""
    return {
        "header": {"stamp": image.stamp_s, "frame_id": image.frame},
        "format": "jpeg",
        "data": encoded(image, "JPEG", quality=quality),
    }


TAKE_PICTURES = Action(
    name="take_pictures",
    type="bt_mission_interfaces/action/TakePictures",
    needs=("camera",),
    example={"nseconds": 10},
    plan=plan,
    tuning=PICTURES,
    limits=lambda _robot, tuning: (
        NumberLimit(
            field="nseconds", low=1, high=tuning.pictures, unit="s", source=parameter("pictures")
        ),
    ),
    offered=load_formats,
    during=looking,
)
