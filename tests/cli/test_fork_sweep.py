"""The last instant at which a change would have saved a run, from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main
from tests.support.forks import forked

LATE = """\
mission: up to the wall
world: wet_arena
inputs: {speed: 0.26}
requirements:
  keeps its distance: always clearance > 0.31
tree:
  sequence:
    - wait: 0.5
    - set: {pace: $speed}
    - explore_forward: {fwd_velocity: $pace, stopping_distance: 0.3}
      timeout: 60
"""


@pytest.fixture(scope="module")
def late(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A run that comes too near to a wall, since it was too fast on a wet floor."""
    folder = tmp_path_factory.mktemp("late")
    source = Path(__file__).parents[2] / "worlds" / "empty_arena.yaml"
    world = source.read_text(encoding="utf-8").replace("name: empty_arena", "name: wet_arena")
    wet = "slippery:\n  - {name: puddle, x: 1.2, y: 0, radius: 0.5, friction: 0.03}\n"
    (folder / "wet_arena.yaml").write_text(world + wet, encoding="utf-8")
    (folder / "late.yaml").write_text(LATE, encoding="utf-8")
    path = folder / "late.mcap"
    words = ("run", str(folder / "late.yaml"), "--json", "--record", str(path))
    assert main([*words]) == 1
    return str(path)


def test_the_last_instant_that_saves_a_mission(
    late: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The variable is read when the drive begins: not a control step later."""
    kept = tmp_path / "saved.mcap"
    capsys.readouterr()
    words = ("fork", late, "--sweep-at", "--set", "speed=0.1", "--json", "--record", str(kept))
    assert main([*words]) == 0
    captured = capsys.readouterr()
    told = json.loads(captured.out)
    assert (told["last"]["status"], told["last"]["is_saved"]) == ("success", True)
    assert told["next"]["at_s"] == pytest.approx(told["last"]["at_s"] + 0.05)
    assert told["next"]["reason"].startswith("keeps its distance: violated by ")
    assert len(told["tries"]) == len(captured.err.splitlines())
    fork = forked(capsys, late, "--at", str(told["last"]["at_s"]), "--set", "speed=0.1")
    assert fork["forked"]["requirements"][0]["verdict"] == "holds"
    assert kept.exists()


def test_a_sweep_is_told_with_what_was_tried(late: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A value that is overwritten before it is read saves nothing."""
    assert main(["fork", late, "--sweep-at", "--set", "pace=0.1", "--tries", "2"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("  requirement keeps its distance: violated by ")
    assert lines[2] == "with pace=0.1: saved at none of the instants that were tried"
    assert lines[3].startswith("  2 of ")
    assert "such instants were left out (--tries). Nothing is known of the others" in lines[3]
