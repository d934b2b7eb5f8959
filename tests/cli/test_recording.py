"""Recording from the command line, in this process and in others."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bt_mission.recording.reader import read_run
from bt_mission.testing.live_graph import LiveGraph
from tests.support.command_line import CommandLine
from tests.support.full_disk import process_full_after
from tests.support.processes import PATIENCE_S, read_until, started
from tests.support.recorded_runs import messages_for_others
from tests.support.thorough import sample

WAIT = "mission: short\ntree: {wait: 0.5}\n"
DRIVE = "mission: drive\ntree: {turn: {angle: 90}, timeout: 30}\n"


@pytest.fixture
def mission(cli: CommandLine) -> CommandLine:
    """A folder with a short mission."""
    cli.write("m.yaml", WAIT)
    return cli


def test_a_run_says_where_it_was_recorded(mission: CommandLine) -> None:
    """In the last line, and in two fields for programs; the file exists."""
    assert mission.lines("run m.yaml --record run.mcap")[-1] == "  recorded to run.mcap"
    run = read_run(Path("run.mcap"))
    assert (run.mission, run.status, run.missing) == ("short", "success", "")
    report = mission.json("run m.yaml --record other.mcap")
    assert (report["recording"], report["recording_lacks"]) == ("other.mcap", "")


def test_a_report_that_fails_hides_no_outcome(
    mission: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever fails in it, the run has ended by then."""

    def broken(_: object) -> str:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr("bt_mission.views.web.report.page.page_of", broken)
    report = mission.json("run m.yaml --report run.html", 1)
    assert report["status"] == "success"
    assert report["report_lacks"].startswith("ZeroDivisionError: a defect (test_recording.py:")


@pytest.mark.process
@pytest.mark.usefixtures("mission")
@pytest.mark.parametrize(
    ("option", "file", "limit", "words"),
    sample(
        [
            (
                "--record",
                "run.mcap",
                8000,
                "  recorded to run.mcap; it lacks everything after 0.0 s",
            ),
            ("--trace", "t.jsonl", 200, "  trace in t.jsonl; it lacks everything after 0.1 s"),
            ("--report", "run.html", 8000, "  no report: "),
        ],
        4,
    ),
)
def test_a_full_disk_is_reported_at_the_end(option: str, file: str, limit: int, words: str) -> None:
    """The mission itself succeeds; what was asked for did not."""
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission", "run", "m.yaml", option, file],
        capture_output=True,
        text=True,
        check=False,
        **process_full_after(limit),
    )
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1].startswith(words)
    assert ("(File too large)" in done.stdout) == (option != "--report")
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.process(always=True)
def test_a_killed_run_leaves_all_but_its_last_second(cli: CommandLine) -> None:
    """What it recorded can be read, without a summary."""
    cli.write("long.yaml", "mission: long\nworld: empty_arena\ntree: {wait: 60}\n")
    path = Path("run.mcap")
    arguments = ("run", "long.yaml", "--speed", "2", "--trace", "trace")
    with started(*arguments, "--record", str(path)) as process:
        read_until(process, "▶ wait")
        while not path.exists() or path.stat().st_size < 100_000:
            assert process.poll() is None
        process.kill()
        process.wait()
    run = read_run(path)
    assert run.why_cut == "the file is incomplete, or the recorder was killed"
    assert run.status == "running"
    assert len(run.truth) > 20


@pytest.mark.thorough
@pytest.mark.process
def test_an_attached_run_records_the_whole_graph(live_graph: LiveGraph) -> None:
    """Of a robot and servers in other processes."""
    path = live_graph.folder / "run.mcap"
    live_graph.robot("empty_arena")
    assert live_graph.run(DRIVE, "--record", str(path)).wait(within=PATIENCE_S) == 0
    messages = messages_for_others(path)
    topics = {message.topic for message in messages}
    assert {"/odom", "/scan", "/tf", "/tf_static", "/map", "/turn/_action/feedback"} <= topics
    assert {"/bt_mission/tree", "/bt_mission/changes", "/rosout"} <= topics
    known = read_run(path)
    assert [goal.status for goal in known.goals if goal.action == "/turn"][-1] == "succeeded"
    assert known.start_ns < 60_000_000_000, "the times are those of the simulation"


def test_a_page_is_made_of_a_recording(mission: CommandLine) -> None:
    """Beside it, or where it is wanted."""
    mission("run m.yaml --json --record run.mcap")
    assert mission("report run.mcap") == "run.html\n"
    assert "<title>short success · bt-mission</title>" in Path("run.html").read_text("utf-8")
    mission("report run.mcap -o other.html")
    assert Path("other.html").exists()


def test_a_folder_that_takes_no_file_is_refused_before_the_run(
    mission: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page is written after it."""
    monkeypatch.setattr("os.access", lambda _path, _mode: False)  # a superuser may write anywhere
    error = mission.refused("run m.yaml --report=run.html")
    assert f"run.html: the folder {mission.folder} is not writable" in error


def test_a_run_can_have_a_page_without_a_recording(mission: CommandLine) -> None:
    """Only the page is left."""
    assert "does not exist" in mission.refused("run m.yaml --report out/run.html")
    Path("out").mkdir()
    assert mission.lines("run m.yaml --report out/run.html")[-1] == "  report: out/run.html"
    assert [path.name for path in Path("out").iterdir()] == ["run.html"]


def test_a_page_of_no_run_is_refused(cli: CommandLine) -> None:
    """With the file's name; no page is made. Others are in transcripts/recordings.txt."""
    Path("run.mcap").write_bytes(b"\x89MCAP0\r\n")
    assert "run.mcap: contains no run of a mission" in cli.refused("report run.mcap")
    assert not Path("run.html").exists()
