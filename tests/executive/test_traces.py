"""Traces are read back, told in words, and compared; what is no trace is refused with its line."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.cli import main
from bt_mission.executive.events.codec import fields_of
from bt_mission.executive.events.events import (
    Event,
    EventStream,
    GoalChanged,
    LogLine,
    NodeChanged,
    NodeInfo,
    NodeProgressed,
    NodesReset,
    PoseSampled,
    RunStarted,
    StateChanged,
)
from bt_mission.executive.events.log import line_of
from bt_mission.executive.stored_trace import TraceError, read_trace
from bt_mission.executive.trace import Trace, TraceFile
from bt_mission.executive.trace_diff import first_difference
from tests.support.full_disk import full_after

S = 1_000_000_000


NODE = NodeInfo("t", "ActionLeaf", "0", 0)


def traced(trace: Trace, *events: Event, node: NodeInfo = NODE) -> Trace:
    """Have a trace take these events."""
    stream = EventStream()
    trace.follow(stream, (node,))
    for event in events:
        stream.emit(event)
    return trace


def started(seed: int = 1) -> RunStarted:
    """The start of a mission in a simulation."""
    return RunStarted(S, "run", "m", (NODE,), "w", "waffle", seed)


def write(path: Path, *, seed: int = 1, x: float = 0.5, goal: str = "aa" * 16) -> Trace:
    """A short run, written as a run writes it."""
    trace = Trace()
    with TraceFile(trace, path):
        traced(
            trace,
            started(seed),
            GoalChanged(2 * S, goal, "/turn", "t", 2 * S, "sent", "sent"),
            NodeChanged(2 * S, 0, Status.RUNNING, "waiting"),
            PoseSampled(3 * S, x, 0.0, 1.5, 0),
            NodeChanged(4 * S, 0, Status.SUCCESS, "90 deg"),
            StateChanged(4 * S, "run", "m", "success", ""),
        )
    return trace


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A trace in a file."""
    write(tmp_path / "a.jsonl")
    return tmp_path / "a.jsonl"


def test_a_trace_reads_back(path: Path) -> None:
    """With the hash that the run had."""
    trace = read_trace(path)
    assert trace.sha256 == write(path).sha256
    assert [trace.seconds(event) for event in trace.events] == [0, 1, 1, 2, 3, 3]
    assert (trace.start["seed"], trace.is_cut) == (1, False)


def test_a_trace_that_was_cut_is_read_up_to_there(path: Path) -> None:
    """Wherever the process was killed."""
    whole = path.read_bytes()
    for length in range(whole.index(b"\n") + 1, len(whole)):
        path.write_bytes(whole[:length])
        trace = read_trace(path)
        assert trace.is_cut == (whole[length - 1 : length] != b"\n")
        assert len(trace.events) == whole[:length].count(b"\n") - 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a trace: an empty file"),
        ("x", "not a trace: a torn line"),
        ("x\n", ":1: not a line of a trace: expected a JSON object"),
        ("[1]\n", ":1: not a line of a trace: expected a JSON object"),
        ("{}\n", ":1: not a trace: the first line has no version"),
        ('{"trace_version": 99}\n', ":1: a trace of version 99; this bt-mission reads 3"),
        ('{"trace_version": 3}\n{"t": "x"}\n', ":2: not an event: expected 't' in ns and 'event'"),
        ('{"trace_version": 3}\n\xff\n', ":2: not a line of a trace: expected a JSON object"),
        ("[" * 100_000 + "\n", ":1: not a line of a trace: expected a JSON object"),
    ],
)
def test_what_is_no_trace_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """With the line that is none."""
    file = tmp_path / "x"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(TraceError) as caught:
        read_trace(file)
    assert str(caught.value) in (f"{file}{message}", f"{file}: {message}")


@pytest.mark.parametrize("name", ["absent", "."])
def test_what_cannot_be_read_is_refused(tmp_path: Path, name: str) -> None:
    """A file that is not there, a folder."""
    with pytest.raises(TraceError, match="cannot read the trace"):
        read_trace(tmp_path / name)


def test_events_in_words(path: Path) -> None:
    """One line each; an event of a kind that is not known is told by its fields."""
    assert [line_of(event) for event in read_trace(path).events] == [
        "mission m in w, robot waffle, seed 1",
        "  goal aaaaaaaa at /turn sent (t)",
        "▶ t",
        "  robot at (0.500, 0.000) m, 85.9 deg, 0 collisions",
        "✓ t  90 deg",
        "mission ended: success",
    ]
    assert line_of({"t": 1, "event": "fault", "name": "drop"}) == "  fault: name drop"
    fault = {"t": 1, "event": "fault", "number": 2, "what": "drop"}
    given = {"state": "begins", "with": {"topic": "scan", "share": 0.3}}
    assert line_of(fault | given) == "  fault 2 begins: drop topic scan share 0.3"
    assert line_of(fault | {"state": "ends"}) == "  fault 2 ends: drop"
    clock = {"t": 1, "event": "clock"}
    assert line_of(clock | {"jump": -9.5}) == "  the clock was set back by 9.5 s"
    assert line_of(clock | {"jump": 100.0}) == "  the clock skipped 100 s"
    assert line_of({"t": 1, "event": "status", "node": 3}) == "  status: node 3"
    assert line_of({"t": 1, "event": "quiet"}) == "  quiet"


def test_the_same_runs_do_not_differ(path: Path, tmp_path: Path) -> None:
    """Nothing is told."""
    write(tmp_path / "b.jsonl")
    assert first_difference(read_trace(path), read_trace(tmp_path / "b.jsonl")) is None


def test_the_first_difference_is_told(path: Path, tmp_path: Path) -> None:
    """What led up to it, what happened in each, and by how much numbers differ."""
    write(tmp_path / "b.jsonl", x=0.5000001)
    assert str(
        first_difference(read_trace(path), read_trace(tmp_path / "b.jsonl"))
    ).splitlines() == [
        "the first 3 events are the same; the first difference is at 2.00 s",
        "      0.00 s  mission m in w, robot waffle, seed 1",
        "      1.00 s    goal aaaaaaaa at /turn sent (t)",
        "      1.00 s  ▶ t",
        "<     2.00 s    robot at (0.500, 0.000) m, 85.9 deg, 0 collisions",
        ">     2.00 s    robot at (0.500, 0.000) m, 85.9 deg, 0 collisions",
        "    x: 0.5 in the first, 0.5000001 in the second (+1e-07)",
    ]


def test_a_trace_that_ends_earlier_differs_there(path: Path, tmp_path: Path) -> None:
    """Its end is told as one."""
    short = tmp_path / "b.jsonl"
    short.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    difference = first_difference(read_trace(path), read_trace(short))
    assert difference is not None
    assert (difference.number, difference.second) == (5, None)
    assert difference.first == "    3.00 s  mission ended: success"
    assert "> " + " " * 10 + "(the end)" in str(difference)


def test_runs_of_two_seeds_are_compared_in_what_followed(path: Path, tmp_path: Path) -> None:
    """Goal ids are made from the seed, and do not count."""
    other = tmp_path / "b.jsonl"
    write(other, seed=2, goal="bb" * 16)
    assert str(first_difference(read_trace(path), read_trace(other))) == (
        "different set-up: seed: 1 in the first, 2 in the second\nall other 5 events are the same"
    )
    write(other, seed=2, goal="bb" * 16, x=9.0)
    difference = first_difference(read_trace(path), read_trace(other))
    assert difference is not None
    assert (difference.number, difference.time_s) == (2, 2.0)


def test_diff_on_the_command_line(path: Path, tmp_path: Path, capsys: Any) -> None:
    """Exit codes as those of diff; an object for programs."""
    other = tmp_path / "b.jsonl"
    write(other, x=0.25)
    assert main(["diff", str(path), str(path)]) == 0
    assert capsys.readouterr().out.startswith("the same 6 events at the same times (sha256 ")
    assert main(["diff", str(path), str(other)]) == 1
    assert capsys.readouterr().out.splitlines()[:2] == [f"< {path}", f"> {other}"]
    assert main(["diff", str(path), str(other), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["number"] == 3
    assert main(["diff", str(path), str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) is None
    assert main(["diff", str(path), str(tmp_path / "absent")]) == 2
    other.write_bytes(path.read_bytes()[:-3])
    assert main(["diff", str(path), str(other)]) == 1
    assert "its last line is incomplete and was ignored" in capsys.readouterr().out


def test_replay_on_the_command_line(path: Path, capsys: Any) -> None:
    """From a time on; poses when they are asked for."""
    assert main(["replay", str(path), "--start", "1.5"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "    3.00 s  ✓ t  90 deg",
        "    3.00 s  mission ended: success",
    ]
    assert main(["replay", str(path), "--poses", "--speed", "1000"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 6


def written(event: Event, node: NodeInfo = NODE) -> tuple[str, str]:
    """The line of an event in a trace, and its fields as JSON has them."""
    fields = {"t": event.time_ns, **fields_of(event, (node,))}
    trace = traced(Trace(), event, node=node)
    return trace.newest[-1], json.dumps(fields, sort_keys=True)


@pytest.mark.parametrize("text", ["", "turn", 'a "quoted" \\ one', "ä → \u202e\x1b\n", "\ud800"])
@pytest.mark.parametrize("state", ["canceling", "succeeded", "rejected"])
def test_the_frequent_events_are_written_as_all_others(text: str, state: str) -> None:
    """Byte for byte, whatever the names and messages."""
    node = NodeInfo(text, "ActionLeaf", "0.1", 0)
    line, fields = written(NodeChanged(S, 0, Status.FAILURE, text), node)
    assert line == fields
    line, fields = written(GoalChanged(2 * S, "00ff" * 8, text, text, S, state, "released"))
    assert line == fields


@pytest.mark.parametrize(
    "x", [0.0, -0.0, 0.1, 1e-300, 1e22, -12345.678901234567, math.inf, math.nan]
)
def test_the_pose_is_written_as_any_other_event(x: float) -> None:
    """Byte for byte, whatever the numbers."""
    line, fields = written(PoseSampled(S, x, 2.5, -x, 3))
    assert line == fields


def test_what_differs_from_run_to_run_is_in_no_trace() -> None:
    """What is under way in a pause is told again and again; progress is sampled by the wall."""
    trace = traced(
        Trace(),
        started(),
        StateChanged(2 * S, "run", "m", "paused", "by hand", ("'t'",), keep_goals=True),
        StateChanged(3 * S, "run", "m", "paused", "by hand", (), keep_goals=True, is_update=True),
        NodeProgressed(3 * S, 0, S, "", "s", 1.0, 2.0),
        StateChanged(4 * S, "run", "m", "running", ""),
        LogLine(4 * S, "repeats another event", is_own=False),
        NodesReset(5 * S, (0,)),
    )
    start, *lines = map(json.loads, list(trace.newest)[1:])
    assert sorted(start) == ["event", "mission", "robot", "seed", "t", "world"]
    assert lines == [
        {"event": "paused", "keep_goals": True, "reason": "by hand", "t": 2 * S},
        {"event": "resumed", "t": 4 * S},
        {"event": "reset", "paths": ["0"], "t": 5 * S},
    ]


def test_a_full_disk_ends_the_file_and_nothing_else() -> None:
    """The hash is that of the whole run, and what the file lacks is said with its time."""
    trace = Trace()
    with TraceFile(trace, Path("/dev/full")) as file:
        assert file.missing == "everything after 0.0 s (No space left on device)"
        traced(trace, started())
    assert trace.sha256 == _hash_of_start()
    assert trace.lines.raised == []


def test_a_disk_that_gets_full_is_told_with_the_time(tmp_path: Path) -> None:
    """Of the first line that the file lacks, since the first event."""
    trace, path = traced(Trace(), started()), tmp_path / "a.jsonl"
    with TraceFile(trace, path) as file:
        traced(trace, LogLine(2 * S, "kept"))
        with full_after(path.stat().st_size):
            traced(trace, LogLine(5 * S // 2, "lost"), LogLine(3 * S, "lost, too"))
    assert file.missing == "everything after 1.5 s (File too large)"
    assert [event["event"] for event in read_trace(path).events] == ["start", "log"]


def test_a_trace_replaces_an_old_one_when_the_run_has_ended(tmp_path: Path) -> None:
    """One that raises leaves the old one."""
    path = tmp_path / "a.jsonl"
    path.write_text("old", encoding="utf-8")

    def run(*, is_broken: bool) -> None:
        trace = Trace()
        with TraceFile(trace, path) as file:
            traced(trace, started())
            assert path.read_text(encoding="utf-8") == "old"
            assert '"start"' in file.file.place.read_text(encoding="utf-8")
            if is_broken:
                raise KeyError

    with pytest.raises(KeyError):
        run(is_broken=True)
    assert path.read_text(encoding="utf-8") == "old"
    run(is_broken=False)
    assert read_trace(path).start["mission"] == "m"


def _hash_of_start() -> str:
    return traced(Trace(), started()).sha256
