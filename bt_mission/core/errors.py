"""The root of every error this package raises on purpose."""

from __future__ import annotations

import traceback
from pathlib import Path


class BtMissionError(Exception):
    """Something the user, the robot or the machine did, told in words they can act on."""


class HintedError(BtMissionError):
    """A fault whose `hint` says what might help."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message if hint is None else f"{message}; {hint}")
        self.message = message
        self.hint = hint


class NotThereError(BtMissionError):
    """What was asked for is not in the ROS graph: nobody offers it."""


def described(error: BaseException) -> str:
    """An exception in one line, with the place that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{place}"


def cause_of(error: Exception) -> str:
    """An error of ours in its own words; any other with the place that raised it."""
    return str(error) if isinstance(error, BtMissionError) else described(error)
