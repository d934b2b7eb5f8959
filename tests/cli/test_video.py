"""Filming from the command line."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bt_mission.cli import main
from bt_mission.core.robot.model import load_robot
from sim.sensors import canvas
from sim.sensors.canvas import Canvas, NoCameraError
from sim.simulation import Simulation
from sim.world.loader import load_world

av = pytest.importorskip("av")

MISSION = "mission: short\nworld: nav_arena\ntree: {turn: {angle: 90}, timeout: 30}\n"


@pytest.fixture
def mission(tmp_path: Path) -> str:
    """A mission file."""
    path = tmp_path / "mission.yaml"
    path.write_text(MISSION, encoding="utf-8")
    return str(path)


@pytest.fixture
def has_egl() -> None:
    """Skips where nothing can be drawn."""
    model = Simulation(load_world("empty_arena"), load_robot("waffle"), seed=0).model
    try:
        Canvas(model).close()
    except NoCameraError as error:
        pytest.skip(str(error))


@pytest.mark.egl
@pytest.mark.usefixtures("has_egl")
def test_a_run_is_filmed(mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The frames are counted, can be decoded, and differ; the trace is that without a film."""
    assert main(["run", mission, "--json"]) == 0
    bare = json.loads(capsys.readouterr().out)
    path = tmp_path / "film.mp4"
    assert main(["run", mission, "--json", "--video", str(path)]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["trace_sha256"] == bare["trace_sha256"]
    assert (report["video"], report["video_lacks"]) == (str(path), "")
    assert report["video_bytes"] == path.stat().st_size
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(frames) == report["video_frames"] == int(report["virtual_s"] * 20 + 1e-6) + 1 + 50
    assert frames[0].shape == (720, 1280, 3)
    assert np.abs(frames[0].astype(int) - frames[30]).max() > 50


@pytest.mark.egl
@pytest.mark.usefixtures("has_egl")
def test_people_are_told(mission: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the last line, with the size."""
    path = tmp_path / "film.mp4"
    assert main(["run", mission, "--video", str(path)]) == 0
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.startswith(f"  video saved to {path} (")
    assert line.endswith(" MB)")


@pytest.mark.egl
@pytest.mark.process
@pytest.mark.usefixtures("has_egl")
def test_a_full_disk_is_told_at_the_end(mission: str, tmp_path: Path) -> None:
    """The mission itself succeeds."""
    path = tmp_path / "film.mp4"
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission", "run", mission, "--video", str(path)],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "; it lacks everything after " in done.stdout.splitlines()[-1]
    assert done.stdout.splitlines()[-1].endswith("(File too large)")
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--video", "film.avi"], "videos are MP4 files, call it film.mp4"),
        (["--video", "film.mp4", "--attach"], "--record FILE.mcap --record-camera"),
        (["--video", "no/film.mp4"], "there is no folder no"),
    ],
)
def test_what_cannot_be_filmed_is_refused(
    mission: str, arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything moves."""
    assert main(["run", mission, *arguments]) == 2
    assert expected in capsys.readouterr().err


def test_without_egl_nothing_is_filmed(
    mission: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It is said before anything moves, with what to install."""
    canvas._gl_context.cache_clear()
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    assert main(["run", mission, "--video", str(tmp_path / "film.mp4")]) == 2
    assert "apt-get install libegl1" in capsys.readouterr().err
    assert not (tmp_path / "film.mp4").exists()
