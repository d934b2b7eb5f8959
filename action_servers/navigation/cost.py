"""What driving past obstacles costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from action_servers.core.grid import Floats
from action_servers.navigation.tuning import NAVIGATION, NavigationTuning

_DISLIKE = 4.0


@dataclass(frozen=True, slots=True)
class CostModel:
    """Price of one metre of path: 1 in the open, up to 5 where the robot only just fits.

    `radius` is the least clearance allowed, `comfort` the clearance from which more is of no use,
    both in metres from the middle of the axle; `margin` is what `radius` has beyond the robot's.
    """

    radius: float
    comfort: float
    margin: float

    def price(self, clearance: Floats) -> Floats:
        """Return the price at each clearance; finite below `radius` too, and no less than there."""
        lack = np.clip((self.comfort - clearance) / max(1e-6, self.comfort - self.radius), 0.0, 1.0)
        return 1.0 + _DISLIKE * lack * lack


def cost_model(turning_radius: float, tuning: NavigationTuning = NAVIGATION) -> CostModel:
    """Return the cost model of a robot whose turning circle has a radius in metres."""
    radius = turning_radius + tuning.margin
    return CostModel(radius, radius + tuning.comfort, tuning.margin)
