"""Whatever happens in the midst of an action, the base stands in time; on the virtual clock."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.thorough import sample

ACTIONS = (
    "explore_forward",
    "turn",
    "camera_sweep",
    "move",
    "navigate_to_pose",
    "navigate_through_poses",
    "follow_waypoints",
    "spin",
    "backup",
    "drive_on_heading",
)


def test_every_action_that_drives_is_here(benchmark: Any) -> None:
    """The trials have a goal for each."""
    assert tuple(benchmark("safety_stops").GOALS) == ACTIONS


@pytest.mark.parametrize("action", sample(ACTIONS, every=2))
def test_the_stop_service_stops(benchmark: Any, action: str) -> None:
    """The base stands within 0.3 s, and the goal is aborted as stopped."""
    stop = benchmark("safety_stops").by_service(action)
    assert stop.stood_after_s <= 0.3
    assert (stop.status, stop.reason) == ("aborted", "stopped")


@pytest.mark.parametrize("action", sample(reversed(ACTIONS), every=2))
def test_a_lidar_that_falls_silent_stops(benchmark: Any, action: str) -> None:
    """The base stands within 1 s, and the goal is aborted with the reason."""
    stop = benchmark("safety_stops").by_lost_scan(action)
    assert stop.stood_after_s <= 1.0
    assert stop.status == "aborted"
    assert "no scan" in stop.reason
