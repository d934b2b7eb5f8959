"""A recorded run to be forked, and what the command says of its forks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main

MISSION = """\
mission: to the wall and back
world: empty_arena
seed: 3
inputs: {speed: 0.2, angle: 90}
include: [parts/ways.yaml]
requirements:
  has power: always battery > 20
tree:
  sequence:
    - set: {way: 0.3}
    - tree: {name: drive, inputs: {speed: $speed, way: $way}}
    - turn: {angle: $angle}
      timeout: 30
      name: turn away
    - tree: {name: drive, inputs: {speed: $speed, way: $way}}
"""
WAYS = """\
trees:
  drive:
    needs: {speed: number, way: number}
    do:
      explore_forward: {fwd_velocity: $speed, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled >= $way
      on_cancel: success
      timeout: 30
"""


def record_mission(folder: Path) -> Path:
    """Record a run of the mission, the files of which are others or gone after it."""
    (folder / "parts").mkdir()
    (folder / "mission.yaml").write_text(MISSION, encoding="utf-8")
    (folder / "parts" / "ways.yaml").write_text(WAYS, encoding="utf-8")
    files = ("--record", str(folder / "run.mcap"), "--trace", str(folder / "run.jsonl"))
    assert main(["run", str(folder / "mission.yaml"), "--json", *files]) == 0
    (folder / "mission.yaml").write_text("mission: another\ntree: {wait: 1}\n", encoding="utf-8")
    (folder / "parts" / "ways.yaml").unlink()
    return folder / "run.mcap"


def forked(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> Any:
    """What programs are told of a fork."""
    capsys.readouterr()
    assert main(["fork", *words, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Why a fork was refused."""
    capsys.readouterr()
    assert main(["fork", *words]) == 2
    return capsys.readouterr().err
