"""What a number of the feedback counts towards."""

from __future__ import annotations

from bt_mission.goals.progress_bounds import ProgressBounds


def test_a_twin_that_says_what_is_left_gives_the_sum() -> None:
    """Whatever the goal says."""
    gauges = ProgressBounds({"angle": -90.0}, {}, {})
    assert gauges.read({"current_angle": -30.0, "remaining_angle": -60.0}) == {
        "current_angle": (-30.0, 90.0),
        "remaining_angle": (-60.0, 90.0),
    }


def test_the_field_of_the_goal_with_the_same_words_is_the_bound() -> None:
    """CameraSweep's images and angle."""
    gauges = ProgressBounds({"sweep_angle": 180.0, "image_count": 8}, {}, {})
    assert gauges.read({"current_image": 2, "current_angle": 40.0}) == {
        "current_image": (2.0, 8.0),
        "current_angle": (40.0, 180.0),
    }


def test_other_words_and_other_units_are_no_bound() -> None:
    """The distance driven does not count towards the distance at which to stop."""
    gauges = ProgressBounds({"stopping_distance": 0.5, "fwd_velocity": 0.2}, {}, {})
    assert gauges.read({"current_distance_travelled": 1.2, "closest_obstacle": 0.7}) == {}
    assert (
        ProgressBounds({"angle": 90.0}, {"angle": "deg"}, {"current_angle": "rad"}).read(
            {"current_angle": 1.0}
        )
        == {}
    )


def test_what_is_left_is_held_against_the_most_that_it_was() -> None:
    """Nav2's distance_remaining."""
    gauges = ProgressBounds({}, {}, {})
    gauges.read({"distance_remaining": 4.0})
    assert gauges.read({"distance_remaining": 1.0}) == {"distance_remaining": (1.0, 4.0)}


def test_texts_truths_and_what_is_not_finite_have_no_bar() -> None:
    """Nor has a bound of zero."""
    gauges = ProgressBounds({"angle": 0.0}, {}, {})
    read = {"state": "x", "angle": 1.0, "remaining": float("inf"), "left": True}
    assert gauges.read(read) == {}


def test_a_goals_own_measure_grows() -> None:
    """The number that is done, before the one that is left, whatever comes first."""
    turn = ProgressBounds({"angle": -90.0})
    assert turn.measure({"remaining_angle": -60.0, "current_angle": -30.0}) == (
        "current_angle",
        30.0,
        90.0,
    )
    drive = ProgressBounds({})
    assert drive.measure({"distance_remaining": 4.0}) == ("distance", 0.0, 4.0)
    assert drive.measure({"distance_remaining": 1.0}) == ("distance", 3.0, 4.0)
    assert drive.measure({"closest_obstacle": 1.0}) is None
