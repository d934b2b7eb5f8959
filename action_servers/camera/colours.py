"""The position of a colour in an image.

Hue alone distinguishes the colours of beacons and zones, and light and shade do not change it.
Saturation and value only exclude grey walls, and pixels too dark to have a hue.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

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
