"""`bt-mission check` says of requirements what a reader might not expect."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli.main import main


def test_a_window_that_decides_nothing_at_first_is_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the instant from which on it does; one of `so far` is not."""
    file = tmp_path / "it.yaml"
    file.write_text(
        "mission: it\nrequirements:\n"
        "  long: never historically for 8 s (previously within 2 s speed > 1)\n"
        "  short: never historically for 8 s so far speed > 1\n"
        "tree:\n  wait: 1\n"
    )
    assert main(["check", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    (line,) = [one for one in lines if "requirement" in one]
    assert line.startswith("  requirement long: its window that looks back is full at 10 s")
    assert "'so far'" in line
