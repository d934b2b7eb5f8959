"""Recordings of ours and of others, read for people who look on later."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordingError
from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import beside, read_timeline
from bt_mission.sessions.load import load
from tests.support.recordings import edited, recorded_run, recording

S = 1_000_000_000


def test_time_begins_with_the_mission() -> None:
    """And ends with the recording."""
    timeline = read_timeline(recording())
    assert timeline.start_ns in timeline.times_ns
    assert 5 < (timeline.end_ns - timeline.start_ns) / S < 20
    assert timeline.why_cut == ""
    assert timeline.times_ns == tuple(sorted(timeline.times_ns))
    assert timeline.trace[0] == '{"trace_version": 3}'


def test_changes_of_the_tree_are_found_in_both_directions() -> None:
    """The next one, and the one before."""
    timeline = read_timeline(recording())
    first, second = timeline.changes_ns[:2]
    assert beside(timeline.changes_ns, first, 1) == second
    assert beside(timeline.changes_ns, second, -1) == first
    assert beside(timeline.changes_ns, first, -1) is None
    assert beside(timeline.changes_ns, timeline.changes_ns[-1], 1) is None


def test_starts_of_a_node_are_found_in_both_directions() -> None:
    """It has run twice."""
    timeline = read_timeline(recording())
    tree = TimelineSeeker(timeline).seek(timeline.end_ns).tree
    assert tree is not None
    (index,) = (at for at, node in enumerate(tree.nodes) if node.name == "drive")
    first = beside(timeline.starts_ns[tree.run, 0, index], timeline.start_ns - 1, 1)
    assert first is not None
    second = beside(timeline.starts_ns[tree.run, 0, index], first, 1)
    assert second is not None
    assert beside(timeline.starts_ns[tree.run, 0, index], second, 1) is None
    assert beside(timeline.starts_ns[tree.run, 0, index], second, -1) == first
    assert timeline.starts_ns.get(("another run", 0, index)) is None


def test_a_file_of_another_recorder_that_begins_later(tmp_path: Path) -> None:
    """Statuses are known as far as they have changed since; there is no trace."""
    whole = read_timeline(recording())
    third_ns = whole.changes_ns[3]

    def keep(channel: Channel, time_ns: int) -> bool:
        if channel.topic.endswith("/trace"):
            return False
        return channel.topic.endswith(("/tree", "/state", "/tf_static")) or time_ns > third_ns

    timeline = read_timeline(edited(tmp_path / "late.mcap", keep))
    assert timeline.trace == ()
    mission = TimelineSeeker(timeline).seek(timeline.end_ns)
    # The last change of each node is in the file, so in the end all is known.
    assert mission.statuses[0] == TimelineSeeker(whole).seek(whole.end_ns).statuses[0]


def test_a_message_that_is_lost_is_bridged(tmp_path: Path) -> None:
    """What follows it is shown all the same."""
    whole = read_timeline(recording())
    lost_ns = whole.changes_ns[2]

    def keep(channel: Channel, time_ns: int) -> bool:
        near = abs(time_ns - lost_ns) < S // 20
        return not (near and channel.topic.endswith("/changes"))

    timeline = read_timeline(edited(tmp_path / "gap.mcap", keep))
    assert len(timeline.changes_ns) < len(whole.changes_ns)
    assert TimelineSeeker(timeline).seek(timeline.end_ns).status == "success"
    assert str(TimelineSeeker(timeline).seek(timeline.end_ns).statuses[0]) == "Status.SUCCESS"


def test_a_cut_file_gives_what_is_before_the_cut(tmp_path: Path) -> None:
    """And says why there is no more."""
    data = recording().read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(data[: len(data) // 2])
    timeline = read_timeline(path)
    assert timeline.why_cut == "the file is incomplete, or the recorder was killed"
    assert timeline.end_ns < read_timeline(recording()).end_ns
    assert TimelineSeeker(timeline).seek(timeline.end_ns).status == "running"


def test_a_file_without_a_tree_says_what_is_missing(tmp_path: Path) -> None:
    """And what to do."""
    path = edited(tmp_path / "foreign.mcap", lambda channel, _: channel.topic in ("/scan", "/tf"))
    with pytest.raises(RecordingError) as error:
        read_timeline(path)
    assert str(error.value) == (
        f"{path}: contains no tree of a mission (topics here: /scan, /tf). Record with "
        f"`bt-mission run --record`; with ros2 bag record, include /bt_mission/tree, changes, "
        f"state, details and log from the start of the mission"
    )


def test_a_tree_of_another_version_says_so(tmp_path: Path) -> None:
    """The message has other fields."""
    path = tmp_path / "old.mcap"
    file = McapFile(path, "test")
    channel = file.channel(
        "/bt_mission/tree", "bt_mission_interfaces/msg/Tree", "uint32 number\n", {}
    )
    file.write(S, [(channel, b"\0\1\0\0\1\0\0\0")])
    file.close()
    with pytest.raises(RecordingError, match="another version of bt-mission made it"):
        read_timeline(path)


@pytest.mark.parametrize(
    ("share", "words"),
    [
        (0.0002, "contains no messages: the file is incomplete"),
        (0.005, "it ends before the mission began: the file is incomplete"),
    ],
)
def test_too_little_of_a_file(tmp_path: Path, share: float, words: str) -> None:
    """Cut before the first chunk, and before anything that names a run."""
    data = recording().read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(data[: max(int(len(data) * share), 20)])
    with pytest.raises(RecordingError, match=words):
        read_timeline(path)


def test_a_recording_without_a_robot(tmp_path: Path) -> None:
    """The tree is shown all the same."""
    path = tmp_path / "tree.mcap"
    edited(path, lambda channel, _: channel.topic.startswith("/bt_mission"))
    timeline = read_timeline(path)
    shown = TimelineSeeker(timeline).seek(timeline.end_ns)
    assert (shown.robot.map, shown.status) == (None, "success")


def test_requirements_are_shown_as_they_were_then(tmp_path: Path) -> None:
    """The violation is in the log at its instant; margins come before it and after it."""
    path = tmp_path / "judged.mcap"
    text = "mission: m\nworld: empty_arena\nrequirements:\n  is quick: always time < 1.22\n"
    recorded_run(load(text + "tree:\n  wait: 2\n"), path)
    timeline = read_timeline(path)
    assert timeline.missing == ""
    seeker = TimelineSeeker(timeline)

    def verdict(after_s: float) -> str:
        (requirement,) = seeker.seek(timeline.start_ns + round(after_s * S)).requirements
        return requirement.verdict

    assert [verdict(1.2), verdict(1.25), verdict(1.2)] == ["open", "violated", "open"]
    lines = [entry.text for entry in seeker.seek(timeline.end_ns).log]
    assert "requirement is quick: violated by 0.03 s" in lines


def test_the_zones_of_a_world_are_known(tmp_path: Path) -> None:
    """With their names and places, from the first instant that was recorded."""
    path = tmp_path / "run.mcap"
    recorded_run(load("mission: m\nworld: nav_arena\ntree: {wait: 0.2}\n"), path)
    timeline = read_timeline(path)
    zones = TimelineSeeker(timeline).seek(timeline.start_ns).robot.zones
    assert [zone.name for zone in zones] == ["A", "B", "C", "D"]
    assert (zones[0].x, zones[0].y, zones[0].radius) == (-1.85, -1.76, 0.4)


def test_a_topic_of_another_type_with_the_name_of_the_zones_is_left_alone(tmp_path: Path) -> None:
    """It is no fault of the file."""
    text = (
        "mission: m\nworld: empty_arena\ntree:\n  sequence:\n"
        "    - publish: {topic: /zones, type: std_msgs/msg/String, message: {data: none}}\n"
        "    - wait: 0.2\n"
    )
    recorded_run(load(text), tmp_path / "run.mcap")
    timeline = read_timeline(tmp_path / "run.mcap")
    assert timeline.missing == ""
    assert TimelineSeeker(timeline).seek(timeline.end_ns).robot.zones == ()
