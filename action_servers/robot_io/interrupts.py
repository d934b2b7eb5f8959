"""SIGINT and SIGTERM as something to look at, for a node that has a robot to stop first."""

from __future__ import annotations

import signal
from types import FrameType
from typing import Any, Self

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class SignalNote:
    """While entered, notes the first signal in `received`; the second raises KeyboardInterrupt."""

    def __init__(self) -> None:
        self.received = ""
        self._former: list[tuple[signal.Signals, Any]] = []

    def __enter__(self) -> Self:
        self._former = [(number, signal.signal(number, self._note)) for number in SIGNALS]
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former:
            signal.signal(number, handler)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if self.received:
            raise KeyboardInterrupt
        self.received = signal.Signals(number).name
