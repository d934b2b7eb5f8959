"""A control step costs at most so many calls: a figure that no machine's noise touches."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MOST_CALLS = 592
"""Calls a control step of explore_fixed: lower it with what saves some."""


def test_a_control_step_costs_at_most_so_many_calls() -> None:
    """From the tenth second of a run to the twentieth; both runs are the same on every machine."""
    script = ROOT / "benchmarks" / "calls.py"
    done = subprocess.run(
        [sys.executable, script, "--seconds", "10", "20"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    calls = int(done.stdout.splitlines()[-1].split()[0])
    assert calls <= MOST_CALLS
