"""Recorded runs, and their pages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from bt_mission.cli import main

HURRIED = """\
mission: hurried <b>&amp;
world: empty_arena
inputs: {speed: 0.25}
requirements:
  is slow: always speed < 0.22
  arrives: eventually succeeded('far away')
tree:
  sequence:
    - log: </script><script>alert(1)</script>
    - repeat: {count: 2}
      do:
        sequence:
          - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.3}
            name: drive
            cancel_when: current_distance_travelled >= 0.4
            on_cancel: success
            timeout: 30
            outputs: {closest_obstacle: room}
          - turn: {angle: 60}
            name: turn away
            timeout: 30
    - fallback:
      - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.2}
        name: far away
        timeout: 3
      - check: $room > 100
    - wait: 1
"""


@pytest.fixture(scope="package")
def hurried(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run that breaks a requirement, and fails."""
    folder = tmp_path_factory.mktemp("hurried")
    mission, recording = folder / "hurried.yaml", folder / "hurried.mcap"
    mission.write_text(HURRIED, encoding="utf-8")
    assert main(["run", str(mission), "--record", str(recording)]) == 1
    return recording


@pytest.fixture
def page_of(tmp_path: Path) -> Callable[[Path], Path]:
    """Generates the page of a recording."""

    def made(recording: Path) -> Path:
        page = tmp_path / "page.html"
        assert main(["report", str(recording), "-o", str(page), "--force"]) == 0
        return page

    return made
