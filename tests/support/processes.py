"""``bt-mission`` as a process that is read through a pipe."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from bt_mission.testing.live_graph import command

PATIENCE_S = 280.0
"""How long a test waits for another process: for ever, as far as a loaded machine goes.

It is below `faulthandler_timeout` of pytest, so that a hang fails one test and ends no worker.
"""


@contextmanager
def started(*arguments: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Run ``bt-mission`` as a process that is read through a pipe; it is killed at the end."""
    process = subprocess.Popen(
        command(*arguments),
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
        if process.stdout:
            process.stdout.close()


def read_until(process: subprocess.Popen[str], words: str) -> str:
    """Read lines until one has these words; gives all of them."""
    assert process.stdout is not None
    seen = ""
    for line in process.stdout:
        seen += line
        if words in line:
            return seen
    raise AssertionError(f"'{words}' was never said in:\n{seen}")
