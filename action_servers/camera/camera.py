"""The camera of maneuvers, and a wait for one image."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from action_servers.core.action import CameraSwitch
from action_servers.core.maneuver import ErrorCode, Finished, Image, Observation
from action_servers.core.tuning import Tuning
from bt_mission.base.parameters import number


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraTuning(Tuning):
    """Of all that takes pictures."""

    image_timeout: float = number(
        2.0, (0.1, 60.0), "How long a picture is waited for, s; twenty of a camera at 10 Hz."
    )


def load_formats() -> None:
    """Load Pillow: with the first picture, it would hold the servers while the robot moves."""
    from PIL import Image as Picture  # noqa: PLC0415 - checks of goals load this module, too

    Picture.preinit()


def encoded(image: Image, form: str, **settings: int) -> bytes:
    """Return an image as a file of a format of Pillow, such as ``PNG``, with settings of that."""
    from PIL import Image as Picture  # noqa: PLC0415 - checks of goals load this module, too

    file = io.BytesIO()
    Picture.fromarray(image.rgb).save(file, form, **settings)
    return file.getvalue()


@contextmanager
def looking(maneuver: Any, _goal_id: str) -> Iterator[None]:
    """Turn the camera of a maneuver off at the end of its goal."""
    try:
        yield
    finally:
        maneuver.camera.off()


class Snapshot:
    """Takes images one by one, each after it was asked for, and each only once.

    The camera is on only while an image is awaited, since sending images is by far the most
    expensive task of a robot's sensors.
    """

    def __init__(self, camera: CameraSwitch, patience_s: float) -> None:
        self._camera = camera
        self._patience_s = patience_s
        self._asked_s: float | None = None
        self._seen: Image | None = None

    @property
    def is_asked_for(self) -> bool:
        """Whether an image was asked for and has not arrived."""
        return self._asked_s is not None

    def ask(self, now: Observation) -> None:
        """Ask for an image."""
        self._asked_s = now.time_s
        self._camera.on()

    def take(self, now: Observation) -> Image | Finished | None:
        """Return the requested image, None before it arrives, or the goal's end without one."""
        if self._asked_s is None:
            return None
        image = now.image
        if image is None or image is self._seen or image.stamp_s < self._asked_s:
            return self._out_of_patience(now.time_s - self._asked_s)
        self._seen = image
        self._asked_s = None
        self._camera.off()
        return image

    def _out_of_patience(self, waited_s: float) -> Finished | None:
        if waited_s < self._patience_s:
            return None
        return Finished(
            "aborted",
            ErrorCode.NO_IMAGE,
            f"no image from the camera within {self._patience_s:g} s",
        )
