"""A recording as a stream: each message has its class, and what is newer is named and skipped."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.executive.events.codec import event_of, node_names, trace_line
from bt_mission.executive.events.events import NodeInfo, RunStarted
from bt_mission.recording.contents import string_message
from bt_mission.recording.file import McapFile
from bt_mission.recording.reader import read_run
from bt_mission.recording.reading import Channel, RecordedFile
from bt_mission.recording.recorded_messages import (
    ExecutiveMessage,
    GoalMessage,
    RobotMessage,
    RosoutMessage,
    SignalLine,
    TraceLine,
    recorded_messages,
)
from bt_mission.recording.replay.timeline import read_timeline
from tests.support.recordings import Message, recording, write_messages

NEWER = "bt_mission_interfaces/msg/Weather"


@pytest.fixture
def with_more(tmp_path: Path) -> Callable[[Iterable[Message]], Path]:
    """The recorded run with further messages at its end."""

    def write(more: Iterable[Message]) -> Path:
        source, copy = RecordedFile(recording()), McapFile(tmp_path / "newer.mcap", "newer")
        messages = [*source.messages(), *more]
        for name, note in source.notes.items():
            copy.note(name, note)
        return write_messages(copy, messages)

    return write


def test_each_message_has_its_class() -> None:
    """In the order of the file; messages that nobody shows are plain ones."""
    file = RecordedFile(recording())
    times, results = zip(*recorded_messages(file), strict=True)
    assert list(times) == sorted(times)
    assert len(results) == sum(1 for _ in RecordedFile(recording()).messages())
    topics: dict[type, set[str]] = {}
    for result in results:
        topics.setdefault(type(result), set()).add(result.channel.topic)
    own = {"tree", "changes", "state", "details"}
    assert topics[ExecutiveMessage] == {f"/bt_mission/{name}" for name in own}
    assert topics[TraceLine] == {"/bt_mission/trace"}
    assert topics[SignalLine] == {"/bt_mission/signals"}
    assert topics[RosoutMessage] == {"/rosout"}
    assert {"/scan", "/odom", "/ground_truth/odom", "/tf", "/map"} <= topics[RobotMessage]
    goals = {(result.action, result.part) for result in results if isinstance(result, GoalMessage)}
    assert ("/turn", "feedback") in goals


def test_a_line_of_a_trace_is_the_event_that_it_was_written_from() -> None:
    """Written again it is the same line, of each kind that the run has."""
    nodes: tuple[NodeInfo, ...] = ()
    lines: list[TraceLine] = []
    for _, first in recorded_messages(RecordedFile(recording())):
        if isinstance(first, TraceLine):
            lines.append(first)
        elif isinstance(first, ExecutiveMessage):
            nodes = next((e.nodes for e in first.batch.events if isinstance(e, RunStarted)), nodes)
    indices, names = {node.path: at for at, node in enumerate(nodes)}, node_names(nodes)
    assert lines[0].event(indices) is None
    kinds = Counter(line.name.partition(" ")[0] for line in lines[1:])
    assert kinds.keys() == {"start", "status", "reset", "goal", "log", "pose", "mission"}
    for line in lines[1:]:
        event = line.event(indices)
        assert event is not None
        assert trace_line(event, nodes, names) == line.text


@pytest.mark.parametrize(
    "line",
    [
        {"event": "paused", "keep_goals": True, "reason": "by hand", "t": 1},
        {"event": "resumed", "t": 2},
        {"event": "observing", "reason": "done", "seconds": 2.5, "status": "success", "t": 3},
        {"event": "clock", "jump": -1.5, "t": 4},
        {"event": "fault", "number": 1, "state": "begins", "t": 5, "what": "drop", "with": {}},
        {"at": 1.5, "event": "requirement", "margin": -0.1, "name": "slow", "t": 6, "unit": "m/s"}
        | {"verdict": "violated"},
    ],
)
def test_rarer_lines_of_a_trace_are_read_back(line: dict[str, object]) -> None:
    """As they are written."""
    event = event_of(line, {})
    assert event is not None
    assert json.loads(trace_line(event, (), ()) or "") == line


def test_an_event_of_a_newer_version_is_named_once_and_skipped(
    with_more: Callable[[Iterable[Message]], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """Everything else is shown and judged as without it."""
    messages = [*RecordedFile(recording()).messages()]
    trace = next(channel for channel, *_ in messages if channel.topic.endswith("/trace"))
    end_ns = messages[-1][1]
    lines = [json.dumps({"event": "weather", "t": end_ns, "wind": n}) for n in (1, 2)]
    path = with_more((trace, end_ns, string_message(line)) for line in lines)
    lacks = "2 events 'weather' (this bt-mission does not know it)"
    assert read_timeline(path).missing == lacks
    run, whole = read_run(path), read_run(recording())
    assert run.missing == lacks
    assert (run.status, run.spans, len(run.goals)) == (
        *(whole.status, whole.spans),
        len(whole.goals),
    )
    assert main(["replay", str(path), "--once"]) == 0
    assert capsys.readouterr().out.count(lacks) == 1
    assert main(["verify", str(path), "--require", str(requirements(path))]) == 0
    out = capsys.readouterr().out
    assert "requirement runs: holds" in out
    assert out.count(lacks) == 1


def test_a_message_of_a_newer_version_is_named_once_and_skipped(
    with_more: Callable[[Iterable[Message]], Path],
) -> None:
    """By its type; a type of another package is nothing that is missing."""
    end_ns = [*RecordedFile(recording()).messages()][-1][1]
    newer = Channel("/bt_mission/weather", NEWER, "float64 wind\n", "cdr")
    other = Channel("/weather", "my_msgs/msg/Weather", "float64 wind\n", "cdr")
    path = with_more((channel, end_ns, bytes(12)) for channel in (newer, newer, other))
    lacks = (
        f"2 messages of type {NEWER} (cannot be read: an unknown type in this version of "
        f"bt-mission)"
    )
    timeline = read_timeline(path)
    assert timeline.missing == lacks
    assert timeline.changes_ns == read_timeline(recording()).changes_ns
    assert read_run(path).missing == lacks


def requirements(path: Path) -> Path:
    """A file with a requirement that the run fulfils."""
    file = path.with_name("required.yaml")
    file.write_text("requirements:\n  runs: eventually succeeded('drive')\n", encoding="utf-8")
    return file
