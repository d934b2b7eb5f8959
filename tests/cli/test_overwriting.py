"""Files that exist are overwritten only where the command line says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli.main import main

OLD = b"the only copy"


@pytest.fixture
def mission(tmp_path: Path) -> str:
    """A short mission's file."""
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\nworld: empty_arena\ntree:\n  wait: 0.1\n")
    return str(path)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (["run", "MISSION", "--json", "--record"], "run.mcap"),
        (["run", "MISSION", "--json", "--report"], "run.html"),
        (["run", "MISSION", "--json", "--trace"], "run.trace"),
        (["tree", "MISSION", "-o"], "tree.dot"),
        (["convert", "MISSION", "-o"], "m.xml"),
        (["convert", "--palette", "-o"], "palette.xml"),
        (["report", "RECORDING", "-o"], "page.html"),
    ],
)
def test_a_file_that_exists_is_kept(
    command: list[str],
    name: str,
    mission: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """As ros2 bag record does; ``--force`` overwrites it."""
    recording = tmp_path / "given.mcap"
    if "RECORDING" in command:
        assert main(["run", mission, "--json", "--record", str(recording)]) == 0
    given = {"MISSION": mission, "RECORDING": str(recording)}
    path = tmp_path / name
    path.write_bytes(OLD)
    arguments = [*(given.get(one, one) for one in command), str(path)]
    capsys.readouterr()
    assert main(arguments) == 2
    assert capsys.readouterr().err.endswith(
        f"{path} exists; give another name, or --force to overwrite it\n"
    )
    assert path.read_bytes() == OLD
    assert main([*arguments, "--force"]) == 0
    assert path.read_bytes() != OLD


def test_the_page_beside_a_recording_is_kept_too(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where ``report`` is not told a name."""
    recording = tmp_path / "run.mcap"
    assert main(["run", mission, "--json", "--record", str(recording)]) == 0
    (tmp_path / "run.html").write_bytes(OLD)
    assert main(["report", str(recording)]) == 2
    assert "run.html exists" in capsys.readouterr().err
    assert (tmp_path / "run.html").read_bytes() == OLD


def test_a_video_is_refused_before_anything_moves(
    mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The encoder has not opened the file."""
    path = tmp_path / "film.mp4"
    path.write_bytes(OLD)
    assert main(["run", mission, "--video", str(path)]) == 2
    assert "film.mp4 exists" in capsys.readouterr().err
    assert path.read_bytes() == OLD


def test_a_device_is_no_file_to_keep(mission: str) -> None:
    """``/dev/null`` exists, and takes everything."""
    assert main(["tree", mission, "--format", "dot", "-o", "/dev/null"]) == 0


@pytest.mark.parametrize("name", ["x.txt", "x", "x.html"])
def test_a_recording_is_called_mcap(
    name: str, mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No tool would take it for what it is; nothing is run."""
    path = tmp_path / name
    assert main(["run", mission, "--record", str(path)]) == 2
    assert capsys.readouterr().err == "--record: recordings are MCAP files, call it x.mcap\n"
    assert not path.exists()


@pytest.mark.parametrize("name", ["x.txt", "x", "x.mcap"])
def test_a_report_is_called_html(
    name: str, mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No browser would take it for what it is; nothing is run."""
    path = tmp_path / name
    assert main(["run", mission, "--report", str(path)]) == 2
    assert capsys.readouterr().err == "--report: a report is a page of HTML, call it x.html\n"
    assert not path.exists()


def test_a_recording_may_go_to_a_device(mission: str) -> None:
    """Which is no file, and has a name of its own."""
    assert main(["run", mission, "--json", "--record", "/dev/null"]) == 0
