"""Frames written to an MP4 file that browsers and phones play."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import OutputFile

Picture = npt.NDArray[np.uint8]

KEY_S = 2
"""Seconds between two key frames: the part that a truncated video may lack."""

_BT709, _BT601 = 1, 6
"""Numbers of colours and of what makes them of numbers in the standards of video (ITU-T H.273)."""


def load_encoder() -> Any:
    """Return the module ``av``.

    Raises:
        BtMissionError: Where it is not installed.
    """
    try:
        import av
    except ImportError as error:
        raise BtMissionError(
            f"video export needs PyAV ({error}); install it with: pip install 'bt-mission[video]'",
            code="BT-905",
        ) from error
    return av


class Mp4File:
    """H.264, 4:2:0, in an MP4 file. Memory does not grow with the length.

    While it is written it consists of fragments, which can be played when the process is killed;
    closed, it is an ordinary file. Once a write fails nothing more is written, and
    :attr:`write_error` says why.

    Args:
        path: See :class:`OutputFile`.
        fps: Frames a second.

    Raises:
        BtMissionError: Where there is no encoder, or the file cannot be opened.
    """

    def __init__(self, path: Path, width: int, height: int, fps: int) -> None:
        self._av = av = load_encoder()
        self.output = OutputFile(path)
        self.frames = 0
        """Frames given to the encoder."""
        self.bytes = 0
        """Size of the file, once it is closed."""
        self._is_closed = False
        self._stream = self.output.stream
        self._container = av.open(
            self._stream, "w", format="mp4", options={"movflags": "hybrid_fragmented"}
        )
        self._track = self._container.add_stream("libx264", rate=fps)
        context = self._track.codec_context
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base = Fraction(1, fps)
        context.gop_size = KEY_S * fps
        # Given, because players otherwise guess it from a frame's size.
        context.color_primaries = context.color_trc = _BT709
        context.colorspace = _BT601
        context.color_range = 1
        context.options = {"preset": "veryfast", "crf": "22"}

    def add(self, picture: Picture, times: int = 1) -> None:
        """Add a frame, optionally several times: 8-bit RGB, height x width x 3."""
        if self.write_error is None:
            self._guarded(lambda: self._encode(picture, times))

    @property
    def path(self) -> Path:
        """The path: a file that replaces another is beside that until it is closed complete."""
        return self.output.place

    @property
    def write_error(self) -> str | None:
        """Why nothing more is written; None without an error."""
        return self.output.write_error

    def abandon(self, why: str) -> None:
        """Write nothing more."""
        self.output.abandon(why)

    def close(self, *, replaces: bool = True) -> None:
        """Write the remaining frames, and close the file; further calls do nothing.

        Args:
            replaces: Whether a complete file replaces the existing one.
        """
        if self._is_closed:
            return
        self._is_closed = True
        if self.write_error is None:
            self._guarded(self._end)
        self.output.close(replaces=replaces)
        if self.write_error is not None:
            # The fragments that are there stay as they are: nothing reaches the closed stream.
            with suppress(OSError, ValueError, self._av.FFmpegError):
                self._container.close()
        self.bytes = self.path.stat().st_size if self.path.exists() else 0

    def _encode(self, picture: Picture, times: int) -> None:
        planes = cv2.cvtColor(picture, cv2.COLOR_RGB2YUV_I420)  # FFmpeg's own takes 5 ms, not 1
        frame = self._av.VideoFrame.from_ndarray(planes, format="yuv420p")
        for _ in range(times):
            frame.pts = self.frames
            frame.time_base = self._track.codec_context.time_base
            self.frames += 1
            self._container.mux(self._track.encode(frame))

    def _end(self) -> None:
        self._container.mux(self._track.encode())
        self._container.close()
        self._stream.flush()

    def _guarded(self, write: Callable[[], None]) -> None:
        try:
            write()
        except (OSError, self._av.FFmpegError) as error:
            self.abandon(getattr(error, "strerror", None) or str(error))
