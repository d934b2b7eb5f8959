"""The process that is ready for a run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command_line import CommandLine

MISSION = """\
mission: turns
world: empty_arena
tree:
  turn: {angle: 45}
  timeout: 20
"""


@pytest.mark.process
def test_a_ready_process_runs_as_a_new_one_does(cli: CommandLine, tmp_path: Path) -> None:
    """The run with which it got ready leaves nothing in the trace and in the outputs."""
    mission = cli.write("turns.yaml", MISSION)
    traces = [tmp_path / "ready.jsonl", tmp_path / "new.jsonl"]
    words = ["run", str(mission), "--json", "--trace"]
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission.cli.ready"],
        input=json.dumps([*words, str(traces[0])]) + "\n",
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["status"] == "success"
    assert done.stderr == ""
    assert cli.call(" ".join([*words, str(traces[1])])) == 0
    assert traces[0].read_text() == traces[1].read_text()
