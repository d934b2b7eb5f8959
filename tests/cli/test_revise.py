"""`bt-mission revise` sends a new version of a mission to the executive that runs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.testing.live_graph import LiveGraph, own_domain

MISSION = "mission: m\ntree:\n  sequence:\n    - wait: 60\n      name: nap\n    - log: done\n"


def test_a_file_with_errors_is_bad_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is not sent; the error has its place."""
    path = tmp_path / "m.yaml"
    path.write_text(MISSION.replace("wait: 60", "wiat: 60"), encoding="utf-8")
    assert main(["revise", "bt_mission", str(path)]) == 2
    assert f"{path}:4:7: error: unknown node type 'wiat'" in capsys.readouterr().err


def test_a_running_mission_is_revised_by_another_process(tmp_path: Path) -> None:
    """The exit code says whether it was applied; a mission that nobody runs is refused."""
    path, other = tmp_path / "m.yaml", tmp_path / "other.yaml"
    path.write_text(MISSION, encoding="utf-8")
    other.write_text(MISSION.replace("mission: m", "mission: n"), encoding="utf-8")
    with own_domain() as domain:
        graph = LiveGraph(tmp_path, domain)
        try:
            running = graph.run(path, "--editable", "--wall-clock")
            running.until("nap")
            refused = graph.start("revise", "bt_mission", str(other), "--json")
            assert refused.wait() == 1
            result = json.loads(refused.output.splitlines()[-1])
            assert result["reasons"] == ["it is another mission: 'n' instead of 'm'"]
            path.write_text(MISSION.replace("wait: 60", "wait: 0"), encoding="utf-8")
            applied = graph.start("revise", "bt_mission", str(path))
            assert applied.wait() == 0
            assert "~ nap (0.0): 60 s -> 0 s" in applied.output
            assert running.wait() == 0
            nobody = graph.start("revise", "nobody", str(path), "--wait", "1", "--json")
            assert nobody.wait() == 1
            assert '{"is_applied": false' in nobody.output
        finally:
            graph.close()
