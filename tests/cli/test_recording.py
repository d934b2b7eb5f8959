"""Recording from the command line, in this process and in others."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.recording.reader import read_run
from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started
from tests.support.recorded_runs import heard_by_others

WAIT = "mission: short\ntree: {wait: 0.5}\n"
LONG = "mission: long\nworld: empty_arena\ntree: {wait: 60}\n"
DRIVE = """\
mission: drive
tree:
  retry: {attempts: 20, pause: 1}
  do:
    turn: {angle: 90}
    timeout: 30
"""


@pytest.fixture
def mission(tmp_path: Path) -> str:
    """A mission file."""
    path = tmp_path / "mission.yaml"
    path.write_text(WAIT, encoding="utf-8")
    return str(path)


def test_a_run_says_where_it_was_recorded(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In the last line, and the file is there."""
    path = tmp_path / "run.mcap"
    assert main(["run", mission, "--record", str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"  recorded to {path}"
    run = read_run(path)
    assert (run.mission, run.status, run.missing) == ("short", "success", "")


def test_programs_are_told_too(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two more fields."""
    path = tmp_path / "run.mcap"
    assert main(["run", mission, "--json", "--record", str(path)]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["recording"], report["recording_lacks"]) == (str(path), "")


def test_a_file_that_cannot_be_made_is_bad_input(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing has moved."""
    assert main(["run", mission, "--record", str(tmp_path / "no" / "run.mcap")]) == 2
    assert "run.mcap: there is no folder " in capsys.readouterr().err


def test_the_camera_alone_is_not_recorded(mission: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It needs a file."""
    assert main(["run", mission, "--record-camera"]) == 2
    assert "--record FILE.mcap" in capsys.readouterr().err


def test_a_report_that_fails_hides_no_outcome(
    mission: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever goes wrong in it, the run has ended by then."""

    def broken(_: object) -> str:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr("bt_mission.views.web.report.page.page_of", broken)
    assert main(["run", mission, "--json", "--report", str(tmp_path / "run.html")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "success"
    assert told["report_lacks"].startswith("ZeroDivisionError: a defect (test_recording.py:")


@pytest.mark.process
def test_a_full_disk_is_told_at_the_end(mission: str, tmp_path: Path) -> None:
    """The mission itself succeeds."""
    path = tmp_path / "run.mcap"
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission", "run", mission, "--record", str(path)],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8000, 8000)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1].startswith(
        f"  recorded to {path}; it lacks everything after 0.0 s (File too large)"
    )
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.process
def test_a_killed_run_leaves_all_but_its_last_second(tmp_path: Path) -> None:
    """What it recorded can be read, without a summary."""
    mission, path = tmp_path / "mission.yaml", tmp_path / "run.mcap"
    mission.write_text(LONG, encoding="utf-8")
    arguments = ("run", str(mission), "--speed", "2", "--trace", str(tmp_path / "trace"))
    with started(*arguments, "--record", str(path)) as process:
        read_until(process, "▶ wait")
        while not path.exists() or path.stat().st_size < 100_000:
            assert process.poll() is None
        process.kill()
        process.wait()
    run = read_run(path)
    assert run.why_cut == "the file was cut, or the recorder killed"
    assert run.status == "running"
    assert len(run.truth) > 20


@pytest.mark.process
def test_an_attached_run_records_the_whole_graph(tmp_path: Path) -> None:
    """Of a robot and servers in other processes."""
    mission, path = tmp_path / "mission.yaml", tmp_path / "run.mcap"
    mission.write_text(DRIVE, encoding="utf-8")
    with ExitStack() as stack:
        for command in (["sim", "--world", "empty_arena"], ["servers"]):
            stack.enter_context(started(*command, **LOCAL))
        run = stack.enter_context(
            started("run", str(mission), "--attach", "--record", str(path), **LOCAL)
        )
        out, _ = run.communicate(timeout=PATIENCE_S)
    assert run.returncode == 0, out
    heard = heard_by_others(path)
    topics = {one.topic for one in heard}
    assert {"/odom", "/scan", "/tf", "/tf_static", "/map", "/turn/_action/feedback"} <= topics
    assert {"/bt_mission/tree", "/bt_mission/changes", "/rosout"} <= topics
    known = read_run(path)
    assert [goal.status for goal in known.goals if goal.action == "/turn"][-1] == "succeeded"
    assert known.start_ns < 60_000_000_000, "the times are those of the simulation"


def test_a_page_is_made_of_a_recording(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Beside it, or where it is wanted."""
    path = tmp_path / "run.mcap"
    assert main(["run", mission, "--json", "--record", str(path)]) == 0
    capsys.readouterr()
    assert main(["report", str(path)]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'run.html'}\n"
    assert "<title>short success · bt-mission</title>" in (tmp_path / "run.html").read_text()
    assert main(["report", str(path), "-o", str(tmp_path / "other.html")]) == 0
    assert (tmp_path / "other.html").exists()


@pytest.mark.parametrize("option", ["--report=run.html", "--video=run.mp4"])
def test_a_folder_that_takes_no_file_is_refused_before_the_run(
    mission: str,
    option: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Pages and films are written after it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("os.access", lambda _path, _mode: False)  # a superuser may write anywhere
    assert main(["run", mission, option]) == 2
    name = option.partition("=")[2]
    said = capsys.readouterr()
    assert said.out == ""
    assert f"{name}: the folder {tmp_path} cannot be written to" in said.err


def test_a_run_can_have_a_page_without_a_recording(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Only the page is left."""
    page = tmp_path / "out" / "run.html"
    assert main(["run", mission, "--report", str(page)]) == 2
    assert "there is no folder" in capsys.readouterr().err
    page.parent.mkdir()
    assert main(["run", mission, "--report", str(page)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"  report: {page}"
    assert [one.name for one in page.parent.iterdir()] == ["run.html"]


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (None, "cannot read it: No such file"),
        (b"", "the file is empty"),
        (b"PK\x03\x04 and so on", "not an MCAP file"),
        (b"\x89MCAP0\r\n", "no run of a mission is in it"),
    ],
)
def test_a_page_of_something_else_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], data: bytes | None, what: str
) -> None:
    """With the file's name; no page is made."""
    path = tmp_path / "run.mcap"
    if data is not None:
        path.write_bytes(data)
    assert main(["report", str(path)]) == 2
    assert f"{path}: {what}" in capsys.readouterr().err
    assert not (tmp_path / "run.html").exists()
