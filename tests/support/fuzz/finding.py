"""Cases, and what is found with them."""

from __future__ import annotations

import traceback
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Case:
    """An input: a file's name, whose suffix says what it is, and what it holds."""

    name: str
    contents: bytes


@dataclass(frozen=True)
class Finding:
    """Something that must not happen; `kind` is the same for what is probably the same bug."""

    kind: str
    text: str


@dataclass(frozen=True)
class Verdict:
    """What became of a case: was it accepted, how did its run end, and what was wrong with that.

    `inputs` is how many things came from outside: one file, or the messages of a program.
    """

    accepted: bool
    end: str = ""
    finding: Finding | None = None
    inputs: int = 1


def crash(error: BaseException) -> Finding:
    """Return an exception that nobody should see, as a finding."""
    frames = traceback.extract_tb(error.__traceback__)
    last = frames[-1] if frames else None
    place = f"{Path(last.filename).name}:{last.name}" if last else "?"
    text = "".join(traceback.format_exception(error, limit=-12))
    return Finding(f"{type(error).__name__} in {place}", text[-6000:])
