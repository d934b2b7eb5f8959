"""How a player moves: time comes from the test."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

from bt_mission.events.events import NodeChanged
from bt_mission.recording.replay.player import FASTEST, SLOWEST, Player
from bt_mission.recording.replay.timeline import Timeline
from tests.support.watched import S, tree


def timeline() -> Timeline:
    """Ten seconds: the leaf runs at 2 and at 6 s, for two seconds each."""
    changes = [
        (time_s * S, NodeChanged(time_s * S, 1, status, ""))
        for time_s, status in (
            (3, Status.RUNNING),
            (5, Status.SUCCESS),
            (7, Status.RUNNING),
            (9, Status.FAILURE),
        )
    ]
    begin = tree("root\n  leaf")
    return Timeline(
        Path("a.mcap"),
        S,
        11 * S,
        (S, *(time_ns for time_ns, _ in changes)),
        (begin, *(event for _, event in changes)),
        (),
        "",
        tuple(time_ns for time_ns, _ in changes),
        {("run", 1): (3 * S, 7 * S)},
    )


def leaf(player: Player) -> str:
    """The status of the leaf."""
    return str(player.mission.statuses[1].value)


def test_time_passes_at_the_speed_that_is_asked_for() -> None:
    """Not before somebody plays."""
    player = Player(timeline(), speed=2.0)
    assert not player.advance(1.0)
    player.play()
    assert player.advance(1.25)
    assert player.at_s == 2.5
    assert leaf(player) == "RUNNING"
    player.faster(2)
    player.advance(0.5)
    assert player.at_s == 4.5
    assert leaf(player) == "SUCCESS"


def test_backwards() -> None:
    """To the start, where it stops."""
    player = Player(timeline(), at_s=5.0)
    player.reverse()
    player.advance(2.0)
    assert (player.at_s, leaf(player)) == (3.0, "RUNNING")
    player.advance(100.0)
    assert (player.at_s, player.is_playing, player.is_at_start) == (0.0, False, True)
    assert leaf(player) == "INVALID"


def test_the_end_stays() -> None:
    """To play on from there is to begin anew."""
    player = Player(timeline(), at_s=9.0)
    player.play()
    player.advance(5.0)
    assert (player.at_s, player.is_playing, player.is_at_end) == (10.0, False, True)
    player.play()
    assert (player.at_s, player.is_playing) == (0.0, True)


def test_backwards_from_the_start_is_from_the_end() -> None:
    """As it is the other way round."""
    player = Player(timeline())
    player.reverse()
    assert not player.is_playing
    player.play()
    assert (player.at_s, player.is_playing) == (10.0, True)


def test_a_little_time_is_not_lost() -> None:
    """At the slowest speed, too."""
    player = Player(timeline(), speed=SLOWEST)
    player.play()
    for _ in range(64_000):
        player.advance(1e-6)
    assert player.at_s == pytest.approx(1e-3, abs=1e-8)


def test_the_speed_has_bounds() -> None:
    """Both ways."""
    player = Player(timeline())
    for _ in range(20):
        player.faster(2)
    assert player.speed == FASTEST
    for _ in range(40):
        player.faster(0.5)
    assert player.speed == SLOWEST


def test_steps_go_from_change_to_change() -> None:
    """And stay there."""
    player = Player(timeline())
    player.play()
    seen = []
    while player.step(1):
        seen.append((player.at_s, leaf(player)))
    assert seen == [(2.0, "RUNNING"), (4.0, "SUCCESS"), (6.0, "RUNNING"), (8.0, "FAILURE")]
    assert not player.is_playing
    back = [(player.at_s, leaf(player)) for _ in range(5) if player.step(-1)]
    assert back == seen[-2::-1]


def test_the_starts_of_a_node() -> None:
    """The next, the one before, and none."""
    player = Player(timeline())
    assert player.step_to_start(1, 1)
    assert player.at_s == 2.0
    assert player.step_to_start(1, 1)
    assert player.at_s == 6.0
    assert not player.step_to_start(1, 1)
    assert player.step_to_start(1, -1)
    assert player.at_s == 2.0
    assert not player.step_to_start(0, 1)


def test_leaps_end_at_the_ends() -> None:
    """Of so many seconds, and to a time."""
    player = Player(timeline())
    player.skip(3.5)
    assert player.at_s == 3.5
    player.skip(-10)
    assert player.at_s == 0.0
    player.go(99.0)
    assert player.at_s == 10.0
    player.go(-1.0)
    assert player.at_s == 0.0
