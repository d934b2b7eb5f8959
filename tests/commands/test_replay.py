"""Recordings replayed from the command line, in lines."""

from __future__ import annotations

from pathlib import Path

from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline
from tests.support.command_line import CommandLine
from tests.support.recordings import edited, recording
from tests.support.report_pages import data_of

SHORT = "mission: short\nworld: empty_arena\ntree: {sequence: [wait: 1.05, log: done]}\n"


def test_in_a_pipe_a_recording_is_printed_as_its_trace_is(cli: CommandLine) -> None:
    """Line by line."""
    cli.write("trace.jsonl", "\n".join(read_timeline(recording()).trace) + "\n")
    lines = cli.lines(f"replay {recording()}")
    assert lines == cli.lines("replay trace.jsonl")
    assert lines[0].endswith("mission there and back in empty_arena, robot waffle, seed 3")
    assert cli.lines(f"replay {recording()} --plain --speed 1000") == lines
    late = cli.lines(f"replay {recording()} --at 3")
    assert late == [line for line in lines if float(line.split()[0]) >= 3]
    assert len(cli.lines(f"replay {recording()} --poses")) > len(lines) + 100


def test_the_tree_at_a_time(cli: CommandLine) -> None:
    """Printed once."""
    lines = cli.lines(f"replay {recording()} --once --at 1")
    assert lines[0] == "there and back   1.00 s   running"
    assert "▶ drive  0.95 s  ██" in lines[5]
    assert "of 0.4" in lines[5]
    assert cli.lines(f"replay {recording()} --once")[0] == "there and back   0.00 s"


def test_times_are_those_of_the_run(cli: CommandLine) -> None:
    """Run, replay and report count from the same instant; the last log line precedes the end."""
    cli.write("m.yaml", SHORT)
    out = cli("run m.yaml --record m.mcap --report m.html")
    assert "     1.10 s  ✓ wait" in out
    assert "  1.10 s in " in out
    assert cli.lines("replay m.mcap --once --at 1.1")[:4] == [
        "short   1.10 s   success",
        " ✓ short  1.05 s",
        "   ✓ wait  1.05 s  0.0 s left",
        "   ✓ log  done",
    ]
    assert "the recording ends at 1.10 s" in cli.refused("replay m.mcap --once --at 1.2")
    assert data_of(Path("m.html"))[""]["duration"] == 1.1
    timeline = read_timeline(Path("m.mcap"))
    log = TimelineSeeker(timeline).seek(timeline.end_ns).log
    last = [(entry.name, entry.text) for entry in log][-2:]
    assert last == [("", "done"), ("mission success", "")]


def test_a_recording_without_a_trace_is_printed_by_its_log(cli: CommandLine) -> None:
    """As another recorder would have made it."""
    edited(Path("other.mcap"), lambda channel, _: not channel.topic.endswith("/trace"))
    lines = cli.lines("replay other.mcap")
    assert lines[0] == "     0.00 s    there and back  begins"
    assert lines[-1].endswith("mission success")
    assert len(cli.lines("replay other.mcap --at 1")) < len(lines)


def test_a_cut_recording_is_printed_up_to_the_cut(cli: CommandLine) -> None:
    """The last line says so."""
    data = recording().read_bytes()
    Path("cut.mcap").write_bytes(data[: len(data) // 2])
    why = "cut.mcap: ends here: the file is incomplete, or the recorder was killed"
    assert cli.lines("replay cut.mcap")[-1] == why
    assert cli.lines("replay cut.mcap --once --at 1")[-1] == why


def test_the_beginning_of_a_recording_is_refused(cli: CommandLine) -> None:
    """Other files that are none are in transcripts/recordings.txt."""
    Path("file").write_bytes(b"\x89MC")
    expected = "contains no messages: the file is incomplete, or the recorder was killed"
    assert expected in cli.refused("replay file")


def test_a_time_after_the_end_is_refused(cli: CommandLine) -> None:
    """The error says where the end is."""
    error = cli.refused(f"replay {recording()} --at 1000")
    assert error.startswith("--at 1000: the recording ends at ")
