"""Commands in other processes end when told to, and so do the processes that they started."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

from bt_mission.core import children
from bt_mission.core.children import Child

DEAF = """#!/bin/sh
trap "" INT
sleep 600 &
echo "in a browser: http://here" >&2
wait
"""


@pytest.mark.process
def test_a_child_that_does_not_listen_ends_with_what_holds_its_output(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Two interrupts, then force."""
    program = tmp_path / "deaf"
    program.write_text(DEAF)
    program.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr(children, "PATIENCE_S", 0.2)

    async def stopped() -> Child:
        child = Child(None, ["run"])
        while not child.link:  # noqa: ASYNC110 - another process says it
            await asyncio.sleep(0)  # noqa: TID251 - lets the loop read
        await child.stop()
        await child.wait()
        return child

    assert asyncio.run(stopped()).code == -9
