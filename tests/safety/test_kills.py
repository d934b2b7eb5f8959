"""Processes that are killed with ``kill -9`` while the robot drives."""

from __future__ import annotations

import math
from typing import Any

import pytest

pytestmark = pytest.mark.process

STANDSTILL = (0.0, 0.0)


@pytest.mark.parametrize("killed", ["servers", "executive"])
def test_the_base_is_told_to_stand_and_stays(
    benchmark: Any, monkeypatch: pytest.MonkeyPatch, killed: str
) -> None:
    """With the arbiter before it, as on a real robot.

    How soon after the last command holds under any load; how soon after the kill is measured by
    benchmarks/safety.py.
    """
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    kills = benchmark("safety_kills")
    kill = kills.kill(killed, with_arbiter=True)
    assert kill.stood_after_s < math.inf
    # However long a command was under way, its time to hold counts from when it was sent.
    assert kill.after_command_s <= 0.5 + kills.TRUTH_PERIOD_S
    assert kill.stayed
    assert STANDSTILL in kill.commands
    told_to_stand = kill.commands.index(STANDSTILL)
    assert set(kill.commands[told_to_stand:]) == {STANDSTILL}
    assert all(ahead <= kills.SPEED + 1e-9 for ahead, _ in kill.commands[:told_to_stand])
