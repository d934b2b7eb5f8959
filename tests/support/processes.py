"""``bt-mission`` as a process that is read through a pipe."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from bt_mission.testing.live_graph import LOCAL, command
from tests.support.full_disk import process_full_after

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


def ended(process: subprocess.Popen[str], code: int, number: int | None = None) -> str:
    """Wait for the end of a process with this exit code, after a signal; gives what it said."""
    if number is not None:
        process.send_signal(number)
    out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, out
    assert "Traceback" not in out
    return out


def printed_beside_libraries(*arguments: str) -> str:
    """Return the output of a command while Fast DDS prints errors, for want of shared memory."""
    done = subprocess.run(
        command(*arguments),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        **process_full_after(1024, os.environ | LOCAL),
    )
    assert done.returncode == 0
    assert "RTPS" in done.stderr
    return done.stdout
