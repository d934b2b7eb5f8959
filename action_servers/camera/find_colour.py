"""Watch the camera until a colour is seen, whatever drives the base."""

from __future__ import annotations

import math
from typing import Any

from action_servers.camera.camera import looking
from action_servers.camera.colours import ColourPatch, largest_patch
from action_servers.core.action import Action, CameraSwitch
from action_servers.core.error_codes import ErrorCode
from action_servers.core.limits import ColourLimit, NumberLimit
from action_servers.core.maneuver import SUCCEEDED, ZERO, Fields, Finished, Image, Observation
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import CameraModel, RobotModel

LIMITS = (
    ColourLimit("colour"),
    NumberLimit(
        field="min_share",
        low=1e-4,  # eight pixels of a picture of 320 x 240: less is no patch
        high=1.0,
        unit="of the picture",
        source="what is still a patch of colour",
        zero="the server's default",
    ),
)


def plan(
    goal: Any,
    _now: Observation,
    robot: RobotModel,
    camera: CameraSwitch,
    tuning: Tuning = TUNING,
) -> FindColour:
    """Return the maneuver for a goal."""
    assert robot.camera is not None  # the action needs it
    share = goal.min_share or tuning.colour_share
    return FindColour(goal.colour, share, robot.camera, camera, tuning)


class FindColour:
    """Looks at each picture taken since it began, and ends with the first that has the colour."""

    needs_base = False

    def __init__(
        self,
        colour: str,
        share: float,
        model: CameraModel,
        camera: CameraSwitch,
        tuning: Tuning = TUNING,
    ) -> None:
        self._colour = colour
        self._share = share
        # Half the picture's width, in focal lengths.
        self._half_width = math.tan(model.hfov / 2.0)
        self.camera = camera
        self._timeout_s = tuning.image_timeout
        self._last_s: float | None = None
        self._image: Image | None = None
        self._patch: ColourPatch | None = None
        self._sent: Image | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Look at the newest picture, or end."""
        if self._last_s is None:
            self._last_s = now.time_s
            self.camera.on()
        image = now.image
        if image is None or image is self._image or image.stamp_s < self._last_s:
            return self._out_of_patience(now.time_s - self._last_s)
        self._image, self._last_s = image, now.time_s
        self._patch = largest_patch(image.rgb, self._colour)
        is_seen = self._patch is not None and self._patch.share >= self._share
        return SUCCEEDED if is_seen else ZERO

    def feedback(self) -> Fields | None:
        """Return what the newest picture shows."""
        if self._image is self._sent:
            return None
        self._sent = self._image
        return self.result()

    def result(self) -> Fields:
        """Return bearing and share of the largest patch in the newest image; NaN and 0 without one.

        The bearing is that of a camera without distortion that looks straight ahead.
        """
        if self._patch is None:
            return {"angle": math.nan, "share": 0.0}
        angle = -math.atan(self._patch.across * self._half_width)
        return {"angle": math.degrees(angle), "share": self._patch.share}

    def _out_of_patience(self, waited_s: float) -> Twist2D | Finished:
        if waited_s < self._timeout_s:
            return ZERO
        reason = f"no image from the camera for {self._timeout_s:g} s"
        return Finished("aborted", ErrorCode.NO_IMAGE, reason)


FIND_COLOUR = Action(
    name="find_colour",
    type="bt_mission_interfaces/action/FindColour",
    needs=("camera",),
    example={"colour": "blue"},
    plan=plan,
    limits=lambda _robot, _tuning: LIMITS,
    feedback=lambda _goal: {"share": (0.0, 1.0)},
    during=looking,
)
