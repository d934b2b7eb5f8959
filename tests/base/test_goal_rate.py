"""A flood of goals is refused before it fills the status messages."""

from __future__ import annotations

from bt_mission.base.goal_rate import NS, GoalRate, RateLimit


def accepts(rate: GoalRate, seconds: int) -> bool:
    """Offer a goal at a ROS time, s."""
    if rate.refusal(seconds * NS) is not None:
        return False
    rate.count(seconds * NS)
    return True


def test_so_many_goals_are_accepted_in_the_window() -> None:
    """The next is refused with the reason, until one has left."""
    rate = GoalRate(10, most=3)
    assert [accepts(rate, second) for second in (0, 1, 2, 3, 9)] == [True] * 3 + [False] * 2
    output = rate.refusal(9 * NS)
    assert output is not None
    assert output.startswith("3 goals were accepted within 10 s, which is the limit")
    assert [accepts(rate, second) for second in (10, 10, 11)] == [True, False, True]


def test_a_clock_that_is_set_back_refuses_nobody() -> None:
    """Goals of the future are forgotten."""
    rate = GoalRate(10, most=2)
    assert [accepts(rate, second) for second in (100, 100, 5)] == [True, True, True]


def test_a_limit_admits_so_many() -> None:
    """And counts only those."""
    limit = RateLimit(1.0, most=2)
    assert [limit.admits(second * NS) for second in (0, 0, 0, 1, 1, 1)] == [True, True, False] * 2
