"""The root of every error this package raises on purpose."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

from bt_mission.base.code_owner import owner_of

FAILED = "BT-903"
"""The code of a callback that raised an exception."""


class BtMissionError(Exception):
    """An error that a user can act on, with the reason in its message.

    `code` is its row in `error_catalogue.toml`, such as BT-901, or empty.
    """

    code: str = ""

    def __init__(self, *arguments: object, code: str | None = None) -> None:
        super().__init__(*arguments)
        if code is not None:
            self.code = code

    @property
    def headline(self) -> str:
        """The message with its code."""
        return f"{self} [{self.code}]" if self.code else str(self)


class HintedError(BtMissionError):
    """An error with a `hint` that says what might help."""

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message if hint is None else f"{message}; {hint}", code=code)
        self.message = message
        self.hint = hint


class NotThereError(BtMissionError):
    """A node, topic, service or action that is not in the ROS graph."""

    code = "BT-901"


def described(error: BaseException, called: Any = None) -> str:
    """Return an exception in one line, with the innermost place in a user's code, or of all.

    Args:
        called: The function or class of a user that was called: its place, where no frame of
            theirs has raised, as for a wrong number of arguments; empty for no place then.
    """
    from traceback import walk_tb  # noqa: PLC0415 - for errors alone

    at = [(frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__)]
    text = str(error)
    theirs = [entry for entry in at if owner_of(entry[0]) == "user"]
    place = ""
    if isinstance(error, SyntaxError) and error.filename:
        text, place = error.msg, f"{Path(error.filename).name}:{error.lineno}"
    elif called is not None and not theirs:
        place = place_of(called)
    elif at:
        file, line = (theirs or at)[-1]
        place = f"{Path(file).name}:{line}"
    if _NO_LOOP in text:
        text += "; rclpy has no loop of asyncio: await a future of rclpy, which a timer sets"
    return type(error).__name__ + (f": {text}" if text else "") + (f" ({place})" if place else "")


_NO_LOOP = "no running event loop"


def place_of(function: Any) -> str:
    """Return the file and line of a function or class, such as ``server.py:12``.

    It is empty if unknown. That of a class is its constructor's, if it has one.
    """
    if inspect.isclass(function):
        function = vars(function).get("__init__", function)
    if inspect.isclass(function):
        try:
            file = inspect.getsourcefile(function) or ""
            return f"{Path(file).name}:{inspect.getsourcelines(function)[1]}"
        except (OSError, TypeError):
            return ""
    code = getattr(inspect.unwrap(function), "__code__", None)
    return f"{Path(code.co_filename).name}:{code.co_firstlineno}" if code else ""


def cause_of(error: Exception) -> str:
    """Return a BtMissionError by its headline; any other error with the place that raised it."""
    return error.headline if isinstance(error, BtMissionError) else described(error)


def callback_failure(error: Exception) -> str:
    """Return that a callback raised this error, or its own text if it has a code, in one line."""
    code = error.code if isinstance(error, BtMissionError) else ""
    if code not in ("", FAILED):
        return cause_of(error)
    return f"a callback failed: {cause_of(error)}{'' if code else f' [{FAILED}]'}"
