"""The speed at which a base comes to rest where it should, and not beyond."""

from __future__ import annotations

import math


def speed_to_stop_in(distance: float, *, deceleration: float, delay_s: float) -> float:
    """Return the highest speed from which the base stops within `distance`.

    It goes on at that speed for `delay_s` (until the next command takes effect) and then brakes
    at `deceleration`: distance = v * delay + v**2 / (2 * deceleration), solved for v. Works alike
    for metres and for radians; 0 for a distance of 0 or less, inf for an infinite one.
    """
    if distance <= 0.0:
        return 0.0
    return deceleration * (math.sqrt(delay_s**2 + 2.0 * distance / deceleration) - delay_s)
