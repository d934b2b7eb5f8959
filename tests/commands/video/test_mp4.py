"""Films as files."""

import errno
import io
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from bt_mission.base import output
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.video import mp4
from bt_mission.commands.video.mp4 import Mp4File

av = pytest.importorskip("av")


@pytest.fixture
def file(tmp_path: Path) -> Mp4File:
    """A file of 20 small frames a second."""
    return Mp4File(tmp_path / "film.mp4", 160, 120, 20)


def grey(level: int) -> np.ndarray:
    """A picture of one brightness."""
    return np.full((120, 160, 3), level, dtype=np.uint8)


def decoded(path: Path) -> list[np.ndarray]:
    """All frames of a file."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_frames_come_back(file: Mp4File) -> None:
    """As many as were added, in their order and brightness, at the rate of the film."""
    for level in range(0, 250, 10):
        file.add(grey(level))
    file.add(grey(250), 5)
    file.close()
    frames = decoded(file.path)
    assert len(frames) == file.frames == 30
    assert [frame.mean() for frame in frames[:25]] == pytest.approx(range(0, 250, 10), abs=3)
    assert (file.write_error, file.bytes) == (None, file.path.stat().st_size)


def test_colours_are_kept(file: Mp4File) -> None:
    """Pure ones, as near as 4:2:0 allows."""
    picture = grey(0)
    picture[:, :, 0] = 200
    file.add(picture)
    file.close()
    assert decoded(file.path)[0][60, 80] == pytest.approx((200, 0, 0), abs=6)


def test_browsers_and_phones_play_it(file: Mp4File) -> None:
    """H.264 with 4:2:0 in an MP4 file that says its length."""
    file.add(grey(9), 40)
    file.close()
    with av.open(str(file.path)) as container:
        track = container.streams.video[0]
        assert (track.codec_context.name, track.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert (track.average_rate, track.frames, container.duration) == (20, 40, 2_000_000)


class Full(io.FileIO):
    """A file on a disk that is soon full."""

    room = 1_000_000

    def write(self, data: object) -> int:
        if self.tell() > self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)  # type: ignore[arg-type]


def test_a_full_disk_ends_the_film_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It says why, and all fragments that are whole can be played."""
    monkeypatch.setattr(output, "_opened", lambda path, *_: Full(path, "w"))
    file = Mp4File(tmp_path / "film.mp4", 160, 120, 20)
    noise = np.random.default_rng(1)
    for _ in range(400):
        file.add(noise.integers(0, 255, (120, 160, 3), dtype=np.uint8))
    file.close()
    monkeypatch.undo()
    assert file.write_error == "No space left on device"
    assert file.frames < 400
    played = 0
    with av.open(str(file.path)) as container, suppress(av.FFmpegError):
        for _ in container.decode(video=0):
            played += 1
    assert played >= 40


def test_a_file_that_cannot_be_opened(tmp_path: Path) -> None:
    """It is named, with the reason."""
    with pytest.raises(BtMissionError, match=r"cannot write .*film\.mp4: No such file"):
        Mp4File(tmp_path / "no" / "film.mp4", 160, 120, 20)


def test_closing_twice_is_closing(file: Mp4File) -> None:
    """Nothing is added afterwards."""
    file.add(grey(1))
    file.close()
    size = file.path.stat().st_size
    file.close()
    assert file.path.stat().st_size == size


def test_without_the_encoder_people_are_told_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is an extra."""
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(BtMissionError, match=r"pip install 'bt-mission\[video\]'"):
        mp4.load_encoder()
