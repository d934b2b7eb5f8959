"""`bt-mission serve` as a process: missions whose lines nobody reads."""

from __future__ import annotations

import signal
from contextlib import ExitStack
from pathlib import Path

import pytest

from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started

pytestmark = pytest.mark.process


def test_a_mission_is_carried_out_when_the_reader_of_the_output_has_left(tmp_path: Path) -> None:
    """It is the client's: what reads the lines, or the disk that takes them, is no part of it."""
    (tmp_path / "talks.yaml").write_text(
        "mission: talks\ntree: {sequence: [{log: one}, {wait: 0.2}, {log: two}]}\n", "utf-8"
    )
    with ExitStack() as stack:
        options = ("serve", "--missions", str(tmp_path), "--wall-clock")
        serve = stack.enter_context(started(*options, **LOCAL))
        read_until(serve, "missions of")
        assert serve.stdout is not None
        serve.stdout.close()
        for _ in range(2):
            command = ("actions", "send", "/execute_mission", "{path: talks.yaml}")
            sent = stack.enter_context(started(*command, **LOCAL))
            result, _ = sent.communicate(timeout=PATIENCE_S)
            assert sent.returncode == 0, result
        assert serve.poll() is None
        serve.send_signal(signal.SIGINT)
        serve.wait(timeout=PATIENCE_S)
