"""A disk that is full: no file grows beyond a size.

Modules are not compiled meanwhile: CPython would keep the part of a file that it could write.
"""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """Let no file of this process grow beyond a size, bytes."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    compiles, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        sys.dont_write_bytecode = compiles


def process_full_after(size: int, variables: Mapping[str, str] = os.environ) -> dict[str, Any]:
    """Return what `subprocess` takes for a process whose files do not grow beyond a size, bytes."""
    return {
        "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        "env": {**variables, "PYTHONDONTWRITEBYTECODE": "1"},
    }
