"""Cases that are programs of bytes: what happens next is read from them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TypeVar

from tests.support.fuzz.finding import Finding, crash

T = TypeVar("T")
SHOWN = 30
"""Steps of a program that a finding shows."""


class Program:
    """Hands out bytes, and what they choose; at its end there are zeros.

    A case is made smaller by leaving bytes out.
    """

    def __init__(self, contents: bytes) -> None:
        self._contents = contents
        self._at = 0

    def __bool__(self) -> bool:
        return self._at < len(self._contents)

    def byte(self) -> int:
        """Return the next byte."""
        self._at += 1
        return self._contents[self._at - 1] if self._at <= len(self._contents) else 0

    def pick(self, choices: Sequence[T]) -> T:
        """Return one of these."""
        return choices[self.byte() % len(choices)]

    def chance(self, share: float) -> bool:
        """Return true in so many cases, as a share of 1."""
        return self.byte() < 256 * share


class ProgramPlay(ABC):
    """What a program does to the product; `log` has a line for each step."""

    def __init__(self, contents: bytes) -> None:
        self.program = Program(contents)
        self.log: list[str] = []
        self.is_refused = False

    @abstractmethod
    def run(self) -> None:
        """Do what the program says, and check the product after each step."""

    def is_clear(self, error: Exception) -> bool:
        """Tell whether an exception is a refusal that people understand."""
        return False

    def finding(self) -> Finding | None:
        """Run; return an exception as a finding, with the steps that led to it."""
        try:
            self.run()
        except Exception as error:  # noqa: BLE001 - any exception is what the hunt looks for
            self.is_refused = self.is_clear(error)
            if self.is_refused:
                return None
            crashed = crash(error)
            kind = str(error) if isinstance(error, AssertionError) else crashed.kind
            return Finding(kind, "\n".join([*self.log[-SHOWN:], crashed.text]))
        return None
