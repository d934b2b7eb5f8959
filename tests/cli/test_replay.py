"""Recordings replayed from the command line, in lines."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.recording.reading import Channel
from tests.support.recordings import edited, recording
from tests.support.report_pages import data_of


def said(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[str]:
    """The lines that a replay prints."""
    assert main(["replay", *map(str, arguments)]) == 0
    return capsys.readouterr().out.splitlines()


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """What a replay of bad input says."""
    assert main(["replay", *map(str, arguments)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    return printed.err.removesuffix("\n")


def test_in_a_pipe_a_recording_is_told_as_its_trace_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Line by line."""
    from bt_mission.recording.replay.timeline import read_timeline  # noqa: PLC0415 - as the command does

    trace = tmp_path / "trace.jsonl"
    trace.write_text("\n".join(read_timeline(recording()).trace) + "\n", encoding="utf-8")
    lines = said(capsys, recording())
    assert lines == said(capsys, trace)
    assert lines[0].endswith("mission there and back in empty_arena, robot waffle, seed 3")
    assert said(capsys, recording(), "--plain", "--speed", "1000") == lines
    late = said(capsys, recording(), "--at", "3")
    assert late == [line for line in lines if float(line.split()[0]) >= 3]
    assert len(said(capsys, recording(), "--poses")) > len(lines) + 100


def test_the_tree_at_a_time(capsys: pytest.CaptureFixture[str]) -> None:
    """Printed once."""
    lines = said(capsys, recording(), "--once", "--at", "1")
    assert lines[0] == "there and back   1.00 s   running"
    assert "▶ drive  0.95 s  ██" in lines[5]
    assert "of 0.4" in lines[5]
    assert said(capsys, recording(), "--once")[0] == "there and back   0.00 s"


def test_times_are_those_of_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run, replay and report count from the same instant, with the same digits."""
    mission, film, page = (tmp_path / name for name in ("m.yaml", "m.mcap", "m.html"))
    mission.write_text(
        "mission: short\nworld: empty_arena\ntree: {sequence: [wait: 1.05, log: done]}\n",
        encoding="utf-8",
    )
    assert main(["run", str(mission), "--record", str(film), "--report", str(page)]) == 0
    printed = capsys.readouterr().out
    assert "     1.10 s  ✓ wait" in printed
    assert "  1.10 s in " in printed
    assert said(capsys, film, "--once", "--at", "1.1")[:4] == [
        "short   1.10 s   success",
        " ✓ short  1.05 s",
        "   ✓ wait  1.05 s  0.0 s left",
        "   ✓ log  done",
    ]
    assert "the recording ends at 1.10 s" in refused(capsys, film, "--once", "--at", "1.2")
    assert data_of(page)[""]["duration"] == 1.1


def test_a_recording_without_a_trace_is_told_by_its_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As another recorder would have made it."""

    def keep(channel: Channel, _: int) -> bool:
        return not channel.topic.endswith("/trace")

    path = edited(tmp_path / "other.mcap", keep)
    lines = said(capsys, path)
    assert lines[0] == "     0.00 s    there and back  begins"
    assert lines[-1].endswith("mission success")
    assert len(said(capsys, path, "--at", "1")) < len(lines)


def test_a_cut_recording_is_told_up_to_the_cut(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Which the last line says."""
    data = recording().read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(data[: len(data) // 2])
    why = f"{path}: ends here: the file was cut, or the recorder killed"
    assert said(capsys, path)[-1] == why
    assert said(capsys, path, "--once", "--at", "1")[-1] == why


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "the file is empty: neither a recording (MCAP, bt-mission run --record) nor a trace"),
        (b"hello", "the file is neither a recording (MCAP, bt-mission run --record) nor a trace"),
        (b"\x89MC", "no message is in it: the file was cut, or the recorder killed"),
        (b"{}\n", "1: no trace: the first line does not name its version"),
    ],
)
def test_files_that_are_neither(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], data: bytes, words: str
) -> None:
    """It says what it expected."""
    path = tmp_path / "file"
    path.write_bytes(data)
    assert words in refused(capsys, path)


def test_a_time_after_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    """It says where the end is."""
    text = refused(capsys, recording(), "--at", "1000")
    assert text.startswith("--at 1000: the recording ends at ")


def test_there_must_be_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """None, and a folder."""
    path = tmp_path / "nowhere"
    assert refused(capsys, path) == f"{path}: cannot read it: No such file or directory"
    assert refused(capsys, tmp_path) == f"{tmp_path}: cannot read it: Is a directory"


@pytest.mark.parametrize("text", ["-1", "nan", "soon", "inf"])
def test_a_time_must_be_one(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Seconds from 0."""
    with pytest.raises(SystemExit) as left:
        main(["replay", "a.mcap", f"--at={text}"])
    assert left.value.code == 2
    assert f"expected seconds from 0, such as 12.5, got '{text}'" in capsys.readouterr().err


def test_a_mission_says_its_last_before_it_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At the same instant."""
    from bt_mission.recording.replay.player import TimelineSeeker  # noqa: PLC0415 - as the command does
    from bt_mission.recording.replay.timeline import read_timeline  # noqa: PLC0415 - as the command does

    mission, film = tmp_path / "m.yaml", tmp_path / "m.mcap"
    mission.write_text(
        "mission: short\nworld: empty_arena\ntree: {sequence: [wait: 1, log: done]}\n",
        encoding="utf-8",
    )
    assert main(["run", str(mission), "--record", str(film)]) == 0
    capsys.readouterr()
    timeline = read_timeline(film)
    log = TimelineSeeker(timeline).seek(timeline.end_ns).log
    assert [(one.name, one.text) for one in log][-2:] == [("", "done"), ("mission success", "")]
