"""What a number of the feedback counts towards."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.executive.goals.progress_bounds import ProgressBounds

CASES: dict[str, tuple[dict[str, float], dict[str, Any], dict[str, tuple[float, float]]]] = {
    "a twin that says what is left gives the sum, whatever the goal says": (
        {"angle": -90.0},
        {"current_angle": -30.0, "remaining_angle": -60.0},
        {"current_angle": (-30.0, 90.0), "remaining_angle": (-60.0, 90.0)},
    ),
    "the field of the goal with the same words is the bound, as of CameraSweep": (
        {"sweep_angle": 180.0, "image_count": 8},
        {"current_image": 2, "current_angle": 40.0},
        {"current_image": (2.0, 8.0), "current_angle": (40.0, 180.0)},
    ),
    "the distance driven does not count towards the distance at which to stop": (
        {"stopping_distance": 0.5, "fwd_velocity": 0.2},
        {"current_distance_travelled": 1.2, "closest_obstacle": 0.7},
        {},
    ),
    "texts, truths, what is not finite and a bound of zero have no bar": (
        {"angle": 0.0},
        {"state": "x", "angle": 1.0, "remaining": float("inf"), "left": True},
        {},
    ),
}


@pytest.mark.parametrize(("goal", "feedback", "bounds"), CASES.values(), ids=CASES)
def test_the_bound_of_a_number(goal: Any, feedback: Any, bounds: Any) -> None:
    """With the number."""
    assert ProgressBounds(goal).read(feedback) == bounds


def test_a_field_in_another_unit_is_no_bound() -> None:
    """Though its words are the same."""
    gauges = ProgressBounds({"angle": 90.0}, {"angle": "deg"}, {"current_angle": "rad"})
    assert gauges.read({"current_angle": 1.0}) == {}


def test_what_is_left_is_held_against_the_most_that_it_was() -> None:
    """Nav2's distance_remaining, of which the progress is the part that is done."""
    gauges = ProgressBounds({})
    assert gauges.measure({"distance_remaining": 4.0}) == ("distance", 0.0, 4.0)
    assert gauges.measure({"distance_remaining": 1.0}) == ("distance", 3.0, 4.0)
    assert gauges.read({"distance_remaining": 1.0}) == {"distance_remaining": (1.0, 4.0)}
    assert gauges.measure({"closest_obstacle": 1.0}) is None


def test_a_goals_own_measure_grows() -> None:
    """The number that is done, before the one that is left, whatever comes first."""
    feedback = {"remaining_angle": -60.0, "current_angle": -30.0}
    assert ProgressBounds({"angle": -90.0}).measure(feedback) == ("current_angle", 30.0, 90.0)
