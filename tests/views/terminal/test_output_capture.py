"""What others write to the terminal stands above the live view, and is not lost."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.terminal import shown_by_terminal

VIEW = """\
import os, sys
from rich.console import Console
from rich.live import Live
from bt_mission.views.terminal.output_capture import OutputCapture

capture = OutputCapture()
capture.start()
print("by Python")
os.write(2, b"by C\\n")
sys.stderr.write("with no end")
for line in capture.take():
    print("taken", line, file=capture.terminal, flush=True)
print("later")
for line in capture.stop():
    print("left", line)
print("after", file=sys.stderr)
"""

LOUD = """\
import os
import sys
from bt_mission.cli import main
from bt_mission.executive.executive import Executive

tick = Executive.tick

def loud(executive):
    os.write(2, b"warning of a driver\\n")
    tick(executive)

Executive.tick = loud
main(["run", sys.argv[1]])
"""

MISSION = """\
mission: m
world: empty_arena
tree:
  sequence:
    - {log: hello}
    - {wait: 0.2}
"""


def on_terminal(script: str, *arguments: str) -> list[str]:
    """Run Python on a terminal; gives the rows that it shows in the end."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", script, *arguments]
    process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs)
    os.close(theirs)
    sent = b""
    try:
        while read := os.read(ours, 65536):
            sent += read
    except OSError:
        pass  # a terminal that nobody holds any more
    finally:
        process.kill()
        process.wait()
        os.close(ours)
    return [row for row in shown_by_terminal(sent.decode().replace("\r\n", "\n")) if row]


@pytest.mark.process
def test_lines_are_taken_when_they_are_whole() -> None:
    """Whoever writes them, in the order written; what has no end comes at the end."""
    assert on_terminal(VIEW) == ["taken by Python", "taken by C", "left with no endlater", "after"]


@pytest.mark.thorough
@pytest.mark.process
def test_what_others_write_during_a_run_does_not_tear_the_view(tmp_path: Path) -> None:
    """One frame is left, and above it every line."""
    path = tmp_path / "m.yaml"
    path.write_text(MISSION)
    rows = on_terminal(LOUD, str(path))
    assert sum("x real time   success" in row for row in rows) == 1
    frame = next(number for number, row in enumerate(rows) if row.startswith("m in empty_arena ("))
    assert [row.strip() for row in rows[frame + 1 : frame + 4]] == [
        "✓ m",
        "✓ log  hello",
        "✓ wait  0.0 s left",
    ]
    assert rows[0] == "m in empty_arena: starting ..."
    above = rows[:frame]
    assert above.count("warning of a driver") == rows.count("warning of a driver") >= 5
    assert any(row.endswith("s    hello") for row in above)
