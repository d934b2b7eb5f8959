"""How a player moves, by the time of the test; an instant is the same from wherever one comes."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees.common import Status

from bt_mission.executive.events import messages
from bt_mission.executive.events.events import NodeChanged
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.messages import ROBOT
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.reading import Channel
from bt_mission.recording.recorded_messages import RobotMessage
from bt_mission.recording.replay import player as module
from bt_mission.recording.replay.player import FASTEST, SLOWEST, Player, TimelineSeeker, entries_of
from bt_mission.recording.replay.timeline import Timeline, read_timeline
from tests.support.recordings import recording
from tests.support.watched import S, tree


def scripted() -> Timeline:
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
        {("run", 0, 1): (3 * S, 7 * S)},
    )


def leaf(player: Player) -> str:
    """The status of the leaf."""
    return str(player.mission.statuses[1].value)


def test_time_passes_at_the_speed_that_is_asked_for() -> None:
    """Not before somebody plays."""
    player = Player(scripted(), speed=2.0)
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
    player = Player(scripted(), at_s=5.0)
    player.reverse()
    player.advance(2.0)
    assert (player.at_s, leaf(player)) == (3.0, "RUNNING")
    player.advance(100.0)
    assert (player.at_s, player.is_playing, player.is_at_start) == (0.0, False, True)
    assert leaf(player) == "INVALID"


def test_the_end_stays() -> None:
    """To play on from there is to begin anew."""
    player = Player(scripted(), at_s=9.0)
    player.play()
    player.advance(5.0)
    assert (player.at_s, player.is_playing, player.is_at_end) == (10.0, False, True)
    player.play()
    assert (player.at_s, player.is_playing) == (0.0, True)


def test_backwards_from_the_start_is_from_the_end() -> None:
    """As it is the other way round."""
    player = Player(scripted())
    player.reverse()
    assert not player.is_playing
    player.play()
    assert (player.at_s, player.is_playing) == (10.0, True)


def test_a_little_time_is_not_lost() -> None:
    """At the slowest speed, too."""
    player = Player(scripted(), speed=SLOWEST)
    player.play()
    for _ in range(64_000):
        player.advance(1e-6)
    assert player.at_s == pytest.approx(1e-3, abs=1e-8)


def test_the_speed_has_bounds() -> None:
    """Both ways."""
    player = Player(scripted())
    for _ in range(20):
        player.faster(2)
    assert player.speed == FASTEST
    for _ in range(40):
        player.faster(0.5)
    assert player.speed == SLOWEST


def test_steps_go_from_change_to_change() -> None:
    """And stay there."""
    player = Player(scripted())
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
    player = Player(scripted())
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
    player = Player(scripted())
    player.skip(3.5)
    assert player.at_s == 3.5
    player.skip(-10)
    assert player.at_s == 0.0
    player.go(99.0)
    assert player.at_s == 10.0
    player.go(-1.0)
    assert player.at_s == 0.0


@cache
def timeline() -> Timeline:
    """A short mission."""
    return read_timeline(recording())


@pytest.fixture(autouse=True)
def _many_scenes_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SPACING", 37)


def all_of(shown: MissionState) -> dict[str, Any]:
    """Everything that is known in a scene, and in which order."""
    result: dict[str, Any] = {}
    for part in (shown, shown.robot):
        for name, value in vars(part).items():
            if value is shown.robot:
                continue
            if isinstance(value, dict):
                result[name] = list(value.items())
            else:
                result[name] = list(value) if isinstance(value, deque | list) else value
    return result


def at(share: float) -> int:
    """The time at a share of the recording, ns."""
    return timeline().start_ns + round(share * (timeline().end_ns - timeline().start_ns))


def told_one_by_one(time_ns: int) -> MissionState:
    """As somebody would know it who has looked on all the time."""
    known = MissionState()
    for at_ns, frame in zip(timeline().times_ns, timeline().frames, strict=True):
        if at_ns > time_ns:
            break
        seen = frame.viewed() if isinstance(frame, RobotMessage) else frame
        if isinstance(seen, ROBOT):
            known.robot.take(seen)
        else:
            known.apply(seen)
    known.now_ns = time_ns
    return known


@settings(max_examples=40)
@given(shares=st.lists(st.floats(0, 1), min_size=1, max_size=6))
def test_a_seek_gives_what_looking_on_would_have_given(shares: list[float]) -> None:
    """After any other seeks, forwards and backwards."""
    seeker = TimelineSeeker(timeline())
    for share in shares:
        time_ns = at(share)
        assert all_of(seeker.seek(time_ns)) == all_of(told_one_by_one(time_ns))


def test_backwards_is_forwards_the_other_way_round() -> None:
    """Every half second of it."""
    seeker = TimelineSeeker(timeline())
    times = range(at(0), at(1), 500_000_000)
    forwards = [all_of(seeker.seek(time_ns)) for time_ns in times]
    backwards = [all_of(seeker.seek(time_ns)) for time_ns in reversed(times)]
    assert backwards[::-1] == forwards


def test_to_go_back_little_is_played_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """No more than lies between two scenes that are kept."""
    seeker = TimelineSeeker(timeline())
    seeker.seek(at(1))
    played = 0
    apply = MissionState.apply

    def counted(self: MissionState, frame: Any) -> Any:
        nonlocal played
        played += 1
        return apply(self, frame)

    monkeypatch.setattr(MissionState, "apply", counted)
    for share in range(10):
        played = 0
        seeker.seek(at(share / 10))
        assert played <= 37


@pytest.mark.parametrize(("limit", "value"), [("MOST_KEPT", 4), ("MOST_NODES", 24)])
def test_a_long_recording_keeps_no_more_scenes_than_it_may(
    monkeypatch: pytest.MonkeyPatch, limit: str, value: int
) -> None:
    """They are farther apart then, as they are where the tree is large."""
    monkeypatch.setattr(module, limit, value)
    seeker = TimelineSeeker(timeline())
    seeker.seek(at(1))
    assert len(seeker._kept) <= 5
    assert all_of(seeker.seek(at(0.5))) == all_of(told_one_by_one(at(0.5)))


def test_the_end_is_known() -> None:
    """Tree, goals, variables, battery, map, scan, trail, log without its limit."""
    mission = TimelineSeeker(timeline()).seek(at(1))
    robot = mission.robot
    assert (mission.status, mission.goals_sent) == ("success", 4)
    states = [goal.state for goal in mission.goals.values()]
    assert states == ["canceled", "succeeded"] * 2
    assert mission.variables["reach"] == "0.4"
    assert float(mission.variables["room"]) > 0.3
    assert robot.charge is not None
    assert 99 < robot.charge < 100
    assert robot.map is not None
    assert robot.frame == "map"
    assert len(robot.trail) > 10
    assert len(robot.scan_points()) > 100
    assert [entry.text for entry in mission.log if not entry.name] == ["off we go"]
    assert mission.log[0] == LogEntry(timeline().start_ns, None, "there and back", "begins")
    assert list(entries_of(timeline())) == list(mission.log)


def test_a_running_leaf_gets_on() -> None:
    """Half a second after it began at the latest."""
    seeker = TimelineSeeker(timeline())
    start_ns = timeline().starts_ns[seeker.seek(at(1)).tree.run, 0, 4][0]  # type: ignore[union-attr]
    values = []
    for tenths in (6, 11, 16):
        mission = seeker.seek(start_ns + tenths * 100_000_000)
        progress = mission.progress[4]
        assert (progress.label, progress.limit) == ("current_distance_travelled", 0.4)
        values.append(progress.value)
    assert values == sorted(set(values))


def test_a_sight_that_cannot_be_read_is_passed_over() -> None:
    """What was seen before stays."""
    whole = timeline()
    sight = RobotMessage("", "scan", Channel("/scan", "a/msg/B", "float32 angle_min", "cdr"), b"")
    damaged = replace(
        whole,
        end_ns=whole.end_ns + 1,
        times_ns=(*whole.times_ns, whole.end_ns + 1),
        frames=(*whole.frames, sight),
    )
    shown = TimelineSeeker(damaged).seek(damaged.end_ns)
    assert isinstance(shown.robot.scan, messages.ScanPoints)
