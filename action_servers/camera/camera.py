"""What maneuvers ask of the camera, and a wait for one picture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from action_servers.core.action import CameraSwitch
from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished, Image, Observation


@contextmanager
def looking(maneuver: Any, _goal_id: str) -> Iterator[None]:
    """Turn the camera of a maneuver off at the end of its goal."""
    try:
        yield
    finally:
        maneuver.camera.off()


class Snapshot:
    """One picture after another, each taken after it was asked for, and each only once.

    The camera is on only while a picture is waited for, since sending pictures is by far the most
    costly thing that a robot's sensors do.
    """

    def __init__(self, camera: CameraSwitch, patience_s: float) -> None:
        self._camera = camera
        self._patience_s = patience_s
        self._asked_s: float | None = None
        self._seen: Image | None = None

    @property
    def is_asked_for(self) -> bool:
        """Whether a picture is on its way."""
        return self._asked_s is not None

    def ask(self, now: Observation) -> None:
        """Ask for a picture."""
        self._asked_s = now.time_s
        self._camera.on()

    def take(self, now: Observation) -> Image | Finished | None:
        """Return the picture that was asked for, None while it is on its way, or why none comes."""
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
