"""A run on its way into a film."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bt_mission.commands.video.mp4 import Mp4File
from bt_mission.commands.video.recorder import (
    ABOVE,
    AHEAD,
    FPS,
    HEIGHT,
    OUTCOME_S,
    WIDTH,
    VideoRecorder,
)
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

pytest.importorskip("av")

MISSION = """\
mission: short
world: empty_arena
tree:
  sequence:
    - log: off we go
    - navigate_to_pose: {pose: [0.3, 0.0, 0]}
      timeout: 30
"""


class Taken:
    """A file that keeps the frames."""

    def __init__(self) -> None:
        self.path = Path("film.mp4")
        self.pictures: list[np.ndarray] = []
        self.write_error: str | None = None
        self.bytes = 0

    @property
    def frames(self) -> int:
        return len(self.pictures)

    def add(self, picture: np.ndarray, times: int = 1) -> None:
        self.pictures += [picture.copy()] * times

    def abandon(self, why: str) -> None:
        self.write_error = why

    def close(self, *, replaces: bool = True) -> None:
        self.bytes = 1


@dataclass
class Plain:
    """Pictures without a renderer: black from above, white ahead."""

    stage: Stage
    fails_at_s: float = 1e9
    closed: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.still = np.zeros((ABOVE[1], ABOVE[0], 3), dtype=np.uint8)

    @property
    def pose(self) -> tuple[float, float, float]:
        return self.stage.sim.robots[0].pose

    def pixel(self, x: Any, y: Any) -> tuple[Any, Any]:
        return 360 + 150 * x, 360 - 150 * y

    def look(self) -> None:
        if self.stage.now_ns / 1e9 > self.fails_at_s:
            raise RuntimeError("no more pictures")

    def moving(self) -> Iterable[Any]:
        return ()

    def ahead(self) -> np.ndarray:
        return np.full((AHEAD[1], AHEAD[0], 3), 255, dtype=np.uint8)

    def seen(self) -> np.ndarray:
        return np.empty((0, 2))

    def close(self) -> None:
        self.closed.append(True)


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    """A stage with the short mission."""
    with Stage(load(MISSION), image_folder=tmp_path) as stage:
        yield stage


def filmed(stage: Stage, views: Plain) -> tuple[VideoRecorder, Taken]:
    """The mission to its end, and its film."""
    file: Any = Taken()
    with VideoRecorder(stage, views, file, [("start", 0.0, 0.0, 0.2)]) as film:
        while not stage.is_done:
            stage.step()
        film.finish()
    return film, file


def test_there_is_a_frame_for_each_twentieth_second(stage: Stage) -> None:
    """From the start to the end, and the outcome stands for a while."""
    film, file = filmed(stage, Plain(stage))
    elapsed_ns = stage.now_ns - stage.start_ns
    assert file.frames == elapsed_ns * FPS // 10**9 + 1 + OUTCOME_S * FPS
    assert film.missing == ""
    assert file.pictures[0].shape == (HEIGHT, WIDTH, 3)


def test_frames_show_what_changes(stage: Stage) -> None:
    """The way, the waypoint once it is sent, the captions, and the outcome at last."""
    _, file = filmed(stage, Plain(stage))
    first, later, last = file.pictures[0], file.pictures[60], file.pictures[-1]
    above, captions = slice(0, ABOVE[0]), (slice(AHEAD[1], None), slice(ABOVE[0], None))
    assert not np.array_equal(first[:, above], later[:, above])
    assert not np.array_equal(first[captions], later[captions])
    green = last[captions].astype(int)[60:110]
    assert (green[..., 1] > 100).sum() > (green[..., 0] > 100).sum()
    assert np.array_equal(file.pictures[-1], file.pictures[-10])


def test_a_run_is_the_same_with_a_film(stage: Stage, tmp_path: Path) -> None:
    """Its trace is."""
    filmed(stage, Plain(stage))
    with Stage(load(MISSION), image_folder=tmp_path) as other:
        while not other.is_done:
            other.step()
        assert other.trace.sha256 == stage.trace.sha256


def test_a_film_that_fails_ends_alone(stage: Stage) -> None:
    """The mission succeeds, and it is said what the film lacks."""
    views = Plain(stage, fails_at_s=2.0)
    film, file = filmed(stage, views)
    assert stage.report(1.0).status == "success"
    assert film.missing.startswith(
        "everything after 1.1 s (the video failed: RuntimeError: no more"
    )
    assert file.frames == 21
    assert views.closed == [True]


def test_it_leaves_nothing_behind(stage: Stage) -> None:
    """Once closed it listens no more."""
    before = list(stage.executive.after_tick), len(stage.executive.events)
    filmed(stage, Plain(stage))
    assert (stage.executive.after_tick, len(stage.executive.events)) == before


def test_memory_is_bounded(stage: Stage, tmp_path: Path) -> None:
    """Frames go into the file as they come: none is kept."""
    file = Mp4File(tmp_path / "film.mp4", WIDTH, HEIGHT, FPS)
    with VideoRecorder(stage, Plain(stage), file) as film:
        for _ in range(40):
            stage.step()
        assert file.frames > 10
        assert not [name for name, value in vars(film).items() if isinstance(value, list)]
