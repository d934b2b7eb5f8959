"""An instant of a recording is the same from wherever one comes."""

from __future__ import annotations

from collections import deque
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bt_mission.events import messages
from bt_mission.events.log import LogEntry
from bt_mission.events.messages import ROBOT
from bt_mission.events.mission_state import MissionState
from bt_mission.recording.happenings import RobotMessage
from bt_mission.recording.reading import Channel
from bt_mission.recording.replay import player as module
from bt_mission.recording.replay.player import TimelineSeeker, entries_of
from bt_mission.recording.replay.timeline import Timeline, read_timeline
from tests.support.recordings import recording


@pytest.fixture(scope="module")
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


def told_one_by_one(timeline: Timeline, time_ns: int) -> MissionState:
    """As somebody would know it who has looked on all the time."""
    known = MissionState()
    for at_ns, frame in zip(timeline.times_ns, timeline.frames, strict=True):
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
    timeline = read_timeline_once()
    seeker = TimelineSeeker(timeline)
    for share in shares:
        time_ns = timeline.start_ns + round(share * (timeline.end_ns - timeline.start_ns))
        assert all_of(seeker.seek(time_ns)) == all_of(told_one_by_one(timeline, time_ns))


def read_timeline_once(kept: list[Timeline] = []) -> Timeline:  # noqa: B006 - kept on purpose
    """Hypothesis and fixtures of a module do not go together."""
    if not kept:
        kept.append(read_timeline(recording()))
    return kept[0]


def test_backwards_is_forwards_the_other_way_round(timeline: Timeline) -> None:
    """Every half second of it."""
    seeker = TimelineSeeker(timeline)
    times = range(timeline.start_ns, timeline.end_ns, 500_000_000)
    forwards = [all_of(seeker.seek(time_ns)) for time_ns in times]
    backwards = [all_of(seeker.seek(time_ns)) for time_ns in reversed(times)]
    assert backwards[::-1] == forwards


def test_to_go_back_little_is_played_again(
    timeline: Timeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No more than lies between two scenes that are kept."""
    seeker = TimelineSeeker(timeline)
    seeker.seek(timeline.end_ns)
    played = 0
    apply = MissionState.apply

    def counted(self: MissionState, frame: Any) -> Any:
        nonlocal played
        played += 1
        return apply(self, frame)

    monkeypatch.setattr(MissionState, "apply", counted)
    for share in range(10):
        played = 0
        seeker.seek(timeline.start_ns + share * (timeline.end_ns - timeline.start_ns) // 10)
        assert played <= 37


@pytest.mark.parametrize(("limit", "value"), [("MOST_KEPT", 4), ("MOST_NODES", 24)])
def test_a_long_film_keeps_no_more_scenes_than_it_may(
    timeline: Timeline, monkeypatch: pytest.MonkeyPatch, limit: str, value: int
) -> None:
    """They are farther apart then, as they are where the tree is large."""
    monkeypatch.setattr(module, limit, value)
    seeker = TimelineSeeker(timeline)
    seeker.seek(timeline.end_ns)
    assert len(seeker._kept) <= 5
    middle_ns = (timeline.start_ns + timeline.end_ns) // 2
    assert all_of(seeker.seek(middle_ns)) == all_of(told_one_by_one(timeline, middle_ns))


def test_the_end_is_known(timeline: Timeline) -> None:
    """Tree, goals, variables, battery, map, scan, trail, log."""
    shown = TimelineSeeker(timeline).seek(timeline.end_ns)
    mission, robot = shown, shown.robot
    assert mission.status == "success"
    assert mission.goals_sent == 4
    assert [goal.state for goal in mission.goals.values()] == [
        "canceled",
        "succeeded",
        "canceled",
        "succeeded",
    ]
    assert mission.variables["reach"] == "0.4"
    assert float(mission.variables["room"]) > 0.3
    assert robot.charge is not None
    assert 99 < robot.charge < 100
    assert robot.map is not None
    assert robot.frame == "map"
    assert len(robot.trail) > 10
    assert len(robot.scan_points()) > 100
    assert [entry.text for entry in shown.log if not entry.name] == ["off we go"]


def test_a_running_leaf_gets_on(timeline: Timeline) -> None:
    """Half a second after it began at the latest."""
    seeker = TimelineSeeker(timeline)
    start_ns = timeline.starts_ns[seeker.seek(timeline.end_ns).tree.run, 4][0]  # type: ignore[union-attr]
    values = []
    for tenths in (6, 11, 16):
        mission = seeker.seek(start_ns + tenths * 100_000_000)
        progress = mission.progress[4]
        assert (progress.label, progress.limit) == ("current_distance_travelled", 0.4)
        values.append(progress.value)
    assert values == sorted(set(values))


def test_the_log_without_its_limit(timeline: Timeline) -> None:
    """For those who print it."""
    shown = TimelineSeeker(timeline).seek(timeline.end_ns)
    assert list(entries_of(timeline)) == list(shown.log)
    assert LogEntry(timeline.start_ns, None, "there and back", "begins") == shown.log[0]


def test_a_sight_that_cannot_be_read_is_passed_over(timeline: Timeline) -> None:
    """What was seen before stays."""
    channel = Channel("/scan", "a/msg/B", "float32 angle_min", "cdr")
    sight = RobotMessage("", "scan", channel, b"")
    frames = (*timeline.frames, sight)
    damaged = Timeline(
        timeline.path,
        timeline.start_ns,
        timeline.end_ns + 1,
        (*timeline.times_ns, timeline.end_ns + 1),
        frames,
        (),
        "",
        timeline.changes_ns,
        timeline.starts_ns,
    )
    assert isinstance(TimelineSeeker(damaged).seek(timeline.end_ns).robot.scan, messages.ScanPoints)
