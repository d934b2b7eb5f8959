"""Facts about Nav2's Wait."""

from __future__ import annotations

import pytest

from action_servers.core.maneuver import SUCCEEDED, ZERO, Observation
from action_servers.driving.recoveries import WaitManeuver


def test_it_ends_at_the_time():
    """Feedback counts down to nothing; the result is the time that has passed."""
    wait = WaitManeuver(0.15)
    left = []
    for step in range(4):
        answer = wait.step(Observation(10.0 + step * 0.05))
        assert answer == (SUCCEEDED if step == 3 else ZERO)
        left.append((wait.feedback() or {})["time_left"])
    assert left == pytest.approx([0.15, 0.1, 0.05, 0.0])
    assert wait.result() == {"total_elapsed_time": pytest.approx(0.15)}
    assert wait.feedback() is None


def test_no_time_at_all_ends_with_the_first_step():
    """As in Nav2."""
    assert WaitManeuver(0.0).step(Observation(10.0)) == SUCCEEDED
