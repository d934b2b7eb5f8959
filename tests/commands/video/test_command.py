"""Filming from the command line."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bt_mission.robots.model import load_robot
from sim.sensors import canvas
from sim.sensors.canvas import Canvas, NoCameraError
from sim.world.loader import load_world
from tests.support.command_line import CommandLine
from tests.support.simulated import alone

av = pytest.importorskip("av")

MISSION = "mission: short\nworld: nav_arena\ntree: {turn: {angle: 90}, timeout: 30}\n"


@pytest.fixture
def has_egl() -> None:
    """Skips where nothing can be drawn."""
    model = alone(load_world("empty_arena"), load_robot("waffle"), seed=0).physics.model
    try:
        Canvas(model).close()
    except NoCameraError as error:
        pytest.skip(str(error))


@pytest.mark.thorough
@pytest.mark.egl
@pytest.mark.usefixtures("has_egl")
def test_a_run_is_filmed(cli: CommandLine) -> None:
    """The frames are counted, can be decoded, and differ; the trace is that without a video."""
    cli.write("m.yaml", MISSION)
    bare = cli.json("run m.yaml")
    report = cli.json("run m.yaml --video film.mp4")
    assert report["trace_sha256"] == bare["trace_sha256"]
    assert (report["video"], report["video_lacks"]) == ("film.mp4", "")
    assert report["video_bytes"] == Path("film.mp4").stat().st_size
    with av.open("film.mp4") as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(frames) == report["video_frames"] == int(report["virtual_s"] * 20 + 1e-6) + 1 + 50
    assert frames[0].shape == (720, 1280, 3)
    assert np.abs(frames[0].astype(int) - frames[30]).max() > 50
    line = cli.lines("run m.yaml --video film.mp4 --force")[-1]
    assert line.startswith("  video saved to film.mp4 (")
    assert line.endswith(" MB)")


@pytest.mark.thorough
@pytest.mark.egl
@pytest.mark.process
@pytest.mark.usefixtures("has_egl")
def test_a_full_disk_is_reported_at_the_end(cli: CommandLine) -> None:
    """The mission itself succeeds."""
    cli.write("m.yaml", MISSION)
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission", "run", "m.yaml", "--video", "film.mp4"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "; it lacks everything after " in done.stdout.splitlines()[-1]
    assert done.stdout.splitlines()[-1].endswith("(File too large)")
    assert "Traceback" not in done.stdout + done.stderr


def test_without_egl_nothing_is_filmed(cli: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    """The error comes before anything moves, with what to install."""
    canvas._gl_context.cache_clear()
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    cli.write("m.yaml", MISSION)
    assert "apt-get install libegl1" in cli.refused("run m.yaml --video film.mp4")
    assert not Path("film.mp4").exists()


def test_a_video_is_refused_before_anything_moves(cli: CommandLine) -> None:
    """The encoder has not opened the file."""
    cli.write("m.yaml", MISSION)
    cli.write("film.mp4", "the only copy")
    assert "film.mp4 exists" in cli.refused("run m.yaml --video film.mp4")
    assert Path("film.mp4").read_text("utf-8") == "the only copy"


def test_a_folder_that_takes_no_file_is_refused_before_the_run(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The video is written after it."""
    cli.write("m.yaml", MISSION)
    monkeypatch.setattr("os.access", lambda _path, _mode: False)  # a superuser may write anywhere
    error = cli.refused("run m.yaml --video=run.mp4")
    assert f"run.mp4: the folder {cli.folder} is not writable" in error
