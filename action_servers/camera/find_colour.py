"""Watch the camera until a colour is seen, whatever drives the base.

Hue alone distinguishes the colours of beacons and zones, and light and shade do not change it.
Saturation and value only exclude grey walls, and pixels too dark to have a hue.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from action_servers.camera.camera import CameraTuning, looking
from action_servers.core.action import Action, CameraSwitch
from action_servers.core.limits import ChoiceLimit, NumberLimit
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Image,
    Observation,
)
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.robots.model import CameraModel, RobotModel

HUES_DEG: dict[str, tuple[float, float]] = {
    "red": (344.0, 14.0),
    "yellow": (40.0, 68.0),
    "green": (95.0, 160.0),
    "turquoise": (166.0, 198.0),
    "blue": (206.0, 256.0),
}
"""From and to which hue a colour goes, in degrees: around those of the beacons of the Sheffield
course (red 357, yellow 50, green 133, turquoise 181, blue 225), clear of orange (31) and purple
(272)."""

LOWEST_SATURATION = 90
"""Of 255: white and grey walls in coloured light stay below."""

LOWEST_VALUE = 40
"""Of 255. The hue of a darker pixel is noise."""

_OPENING = np.ones((3, 3), dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class ColourPatch:
    """The largest connected area of a colour: its `share` of the image, and its middle.

    `across` goes from -1 at the left edge of the image to 1 at the right edge.
    """

    share: float
    across: float


def largest_patch(rgb: npt.NDArray[np.uint8], colour: str) -> ColourPatch | None:
    """Return the largest patch of a colour of `HUES_DEG` in an image (height, width, 3), if any.

    Areas narrower than three pixels count as noise.
    """
    seen = cv2.morphologyEx(_mask(rgb, colour), cv2.MORPH_OPEN, _OPENING)
    _, _, stats, middles = cv2.connectedComponentsWithStats(seen, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA]  # 0 is the background
    if not areas.size:
        return None
    largest = int(np.argmax(areas))
    height, width = seen.shape
    column = float(middles[largest + 1][0])
    return ColourPatch(float(areas[largest]) / (height * width), (2.0 * column + 1.0) / width - 1.0)


def _mask(rgb: npt.NDArray[np.uint8], colour: str) -> npt.NDArray[np.uint8]:
    hsv = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2HSV)
    first, last = (round(hue / 2.0) for hue in HUES_DEG[colour])  # OpenCV's hue has 180 steps
    bands = [(first, last)] if first <= last else [(first, 179), (0, last)]
    mask = np.zeros(hsv.shape[:2], dtype=np.uint8)
    for low, high in bands:
        mask |= cv2.inRange(
            hsv,
            np.array([low, LOWEST_SATURATION, LOWEST_VALUE]),
            np.array([high, 255, 255]),
        ).astype(np.uint8)
    return mask


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourTuning(CameraTuning):
    """Of the search for a colour."""

    colour_share: float = number(
        0.01, (0.0001, 1.0), "Share of the picture that find_colour looks for by default."
    )


COLOUR_SEARCH = ColourTuning()
"""The defaults."""

LIMITS = (
    ChoiceLimit(
        field="colour",
        what="colour",
        choices=tuple(HUES_DEG),
        source="the colours that differ by their hue",
    ),
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
    tuning: ColourTuning = COLOUR_SEARCH,
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
        tuning: ColourTuning = COLOUR_SEARCH,
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
    tuning=COLOUR_SEARCH,
    limits=lambda _robot, _tuning: LIMITS,
    feedback=lambda _goal: {"share": (0.0, 1.0)},
    during=looking,
)
