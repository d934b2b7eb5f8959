"""Where a robot went, by the truth."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any


def path_length(run: Any, start_ns: int, end_ns: int) -> float:
    """Length of the true path between two times, from the pose of every tick, m."""
    poses = [pose for pose in run.events("pose") if start_ns <= pose["t"] <= end_ns]
    return sum(math.hypot(b["x"] - a["x"], b["y"] - a["y"]) for a, b in pairwise(poses))
