"""Facts about executives that are late, back, dead and gone."""

from __future__ import annotations

import pytest

from action_servers.core.executive_watch import ExecutiveLimits, ExecutiveWatch

LATE = "no sign of life of the executive for 0.2 s: the base is held"
DEAD = "the executive has died: no sign of life for 2 s"
GONE = "the executive has gone while its sign of life was late"
LEFT = "the executive has left"
BACK = "back"


class Watched:
    """A watch, and what it tells, in order."""

    def __init__(self, **limits: float) -> None:
        self.reported: list[str] = []
        self.watch = ExecutiveWatch(
            ExecutiveLimits(**limits),
            self.reported.append,
            lambda: self.reported.append(BACK),
            self.reported.append,
        )
        self.watch.update(1, 0)

    def look(self, count: int) -> list[str]:
        """Look so many times; return what is told then."""
        before = len(self.reported)
        for _ in range(count):
            self.watch.look()
        return self.reported[before:]


@pytest.fixture
def watched() -> Watched:
    """One executive that lives."""
    return Watched()


def test_one_that_is_late_and_comes_back_loses_nothing(watched):
    """However often."""
    for _ in range(3):
        watched.watch.update(0, 1)
        watched.look(5)
        watched.watch.update(1, 0)
    assert watched.reported == [LATE, BACK] * 3


def test_one_that_stays_away_is_given_up(watched):
    """2 s after its last sign of life: 18 looks after the 0.2 s of its lease."""
    watched.watch.update(0, 1)
    assert watched.look(17) == []
    assert watched.look(1) == [DEAD, BACK]
    assert watched.look(100) == []


def test_a_server_that_is_held_up_itself_gives_nobody_up(watched):
    """It does not look meanwhile: the executive is back before it counts again."""
    watched.watch.update(0, 1)
    watched.look(1)
    watched.watch.update(1, 0)
    assert watched.look(100) == []
    assert watched.reported == [LATE, BACK]


def test_one_that_leaves_is_told_at_once(watched):
    """Nobody waits for its sign of life."""
    watched.watch.update(0, 0)
    assert watched.reported == [LEFT]


def test_one_that_leaves_while_it_is_late_is_told_at_once(watched):
    """DDS has taken note of its end."""
    watched.watch.update(0, 1)
    watched.watch.update(0, 0)
    assert watched.reported == [LATE, GONE, BACK]


def test_another_that_lives_does_not_make_up_for_one_that_is_late(watched):
    """The goals may be those of the one that is late."""
    watched.watch.update(2, 0)
    watched.watch.update(1, 1)
    assert watched.reported == [LATE]
    assert watched.look(18) == [DEAD, BACK]


def test_one_that_was_given_up_and_then_forgotten_by_dds_changes_nothing(watched):
    """DDS takes 20 s to forget a process that was killed; another one may run by then."""
    watched.watch.update(0, 1)
    watched.look(18)
    watched.watch.update(1, 1)
    before = len(watched.reported)
    watched.watch.update(1, 0)
    assert watched.reported[before:] == []


def test_one_that_was_given_up_may_come_back(watched):
    """As after a computer was suspended; and it may be late once more."""
    watched.watch.update(0, 1)
    watched.look(18)
    watched.watch.update(1, 0)
    watched.watch.update(0, 1)
    assert watched.reported[-1] == LATE
    assert watched.look(18) == [DEAD, BACK]


def test_one_of_two_that_leaves_ends_nothing(watched):
    """The other's goals go on."""
    watched.watch.update(2, 0)
    watched.watch.update(1, 0)
    assert watched.reported == []


def test_limits_are_set():
    """And told in the messages."""
    watched = Watched(executive_lease=0.5, executive_timeout=1.0)
    watched.watch.update(0, 1)
    assert watched.reported == ["no sign of life of the executive for 0.5 s: the base is held"]
    assert watched.look(4) == []
    assert watched.look(1) == ["the executive has died: no sign of life for 1 s", BACK]
