"""Virtual time against the wall."""

from collections.abc import Callable

import pytest

from bt_mission.base.wall_clock import Pacer

MS = 1_000_000
S = 1_000 * MS


class Wall:
    """A wall clock that is set."""

    now_ns = 100 * S


@pytest.fixture
def wall() -> Wall:
    """At 100 s."""
    return Wall()


@pytest.fixture
def pace(wall: Wall) -> Callable[[float], Pacer]:
    """Make a pacer for which 100 s on the wall are virtual time 1 s."""

    def make(speed: float = 1.0) -> Pacer:
        wall.now_ns = 100 * S
        return Pacer(speed, 1 * S, lambda: wall.now_ns)

    return make


# Speed; wall, world and what is due, each in ms after 100 s on the wall and 1 s in the world.
PACES: dict[str, tuple[float, list[tuple[int, int, int]]]] = {
    "at speed one both run alike": (1.0, [(10, 0, 10)]),
    "at speed ten virtual time runs ten times as fast": (10.0, [(10, 0, 100)]),
    "a world that is ahead waits, as time never goes back": (1.0, [(0, 4000, 4000)]),
    "a short delay is caught up with": (1.0, [(100, 0, 100)]),
    # A command holds for two tenths: what drives the robot is heard again before it brakes.
    "of a long delay a tenth of a second follows, and pacing starts again": (
        1.0,
        [(3000, 0, 100), (3010, 100, 110)],
    ),
    "a slow world makes up for 100 ms of the wall": (0.5, [(3000, 0, 50)]),
    "a fast world does not leap": (10.0, [(40, 0, 400), (3000, 400, 900), (3010, 900, 1000)]),
}


@pytest.mark.parametrize(("speed", "moments"), PACES.values(), ids=PACES)
def test_what_is_due(wall, pace, speed, moments):
    """At each moment, exactly."""
    pacer = pace(speed)
    for wall_ms, world_ms, due_ms in moments:
        wall.now_ns = 100 * S + wall_ms * MS
        assert pacer.due_ns(1 * S + world_ms * MS) == 1 * S + due_ms * MS


def test_a_new_speed_holds_from_here_on(wall, pace):
    """What has passed stays passed."""
    pacer = pace()
    wall.now_ns = 101 * S
    pacer.set_speed(4.0, 2 * S)
    wall.now_ns += 10 * MS
    assert pacer.due_ns(2 * S) == 2 * S + 40 * MS


def test_shortfall_is_told_once_a_window(wall, pace):
    """Of 10 s only 5.1 s could be kept: speed 0.51, reported once, and not for a short delay."""
    pacer = pace()
    wall.now_ns = 105 * S
    pacer.due_ns(1 * S)
    assert pacer.shortfall() is None
    wall.now_ns = 110 * S
    assert pacer.shortfall() == pytest.approx(0.51)
    wall.now_ns += MS
    assert pacer.shortfall() is None
    pacer.due_ns(1 * S + 100 * MS)
    hiccup = pace()
    wall.now_ns += 900 * MS
    hiccup.due_ns(1 * S)
    wall.now_ns = 110 * S
    assert hiccup.shortfall() is None


def test_the_wall_time_to_wait_for_virtual_time(wall, pace):
    """At speed 4 a second of the world is a quarter on the wall; without a speed nothing waits."""
    pacer = pace(4.0)
    assert pacer.ahead_s(2 * S) == pytest.approx(0.25)
    wall.now_ns = 101 * S
    assert pacer.ahead_s(2 * S) == pytest.approx(-0.75)
    assert Pacer(None, 1 * S).ahead_s(100 * S) <= 0.0
