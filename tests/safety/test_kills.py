"""Processes that are killed with ``kill -9`` while the robot drives."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = pytest.mark.process

SEEN_EVERY_S = 0.05
"""The truth is published 20 times a second."""


@pytest.mark.parametrize("killed", ["servers", "executive"])
def test_the_base_stands_within_half_a_second(
    benchmark: Any, monkeypatch: pytest.MonkeyPatch, killed: str
) -> None:
    """With the arbiter before it, as on a real robot."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    kill = benchmark("safety_kills").kill(killed, with_arbiter=True)
    assert kill.stood_after_s <= 0.5 + SEEN_EVERY_S
    assert kill.way_m < 0.15
