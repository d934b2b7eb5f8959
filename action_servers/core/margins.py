"""The distances that the governor keeps, m. Those that are a choice are parameters.

`stop_margin` and `turn_margin` of the servers (`core/tuning.py`) are added to `HULL_M`.
"""

from __future__ import annotations

NOISE_M = 0.03
"""The largest error of a ray: three standard deviations (0.01 m in ROBOTIS's simulation)."""

HULL_M = 0.01
"""Between the hull and a point that must not be touched: one standard deviation of a ray. The
circle that the hull sweeps has none: a path keeps only the circle free, so that noise would stop
every turn.
"""

ESCAPE_M = HULL_M + 0.02
"""The same on the way out of the way of what moves, where nobody aims: twice the precision of an
LDS-01 more (10 mm, ROBOTIS e-manual)."""

MOVING_M = 0.08
"""Between the hull and a moving obstacle, of which only the front is seen."""

STROKE_M = 0.04
"""Around the hull in a stroke of a car that turns, where there is as much room: its corners sweep
outside of its path."""
