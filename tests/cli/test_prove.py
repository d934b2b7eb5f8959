"""`bt-mission prove` from the command line: exit codes, JSON, files and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli.main import main

UNSET = """mission: m
tree:
  sequence:
    - fallback:
        - {turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}
        - log: no turn
    - log: $code
"""


def test_json_names_the_files_and_what_the_stage_has_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`-o` writes them; `--confirm` runs without files; neither is null for all."""
    mission, folder = tmp_path / "m.yaml", tmp_path / "findings"
    mission.write_text(UNSET, encoding="utf-8")
    rows = []
    for more in (["-o", str(folder)], ["--confirm"], []):
        assert main(["prove", str(mission), "--faults", "1", "--json", *more]) == 1
        (finding,) = json.loads(capsys.readouterr().out)["findings"]
        rows.append((finding["scenario"], finding["test"], finding["confirmed"]))
    scenario, test = folder / "m_unset_variable.scenario.yaml", folder / "test_m_unset_variable.py"
    assert rows == [(str(scenario), str(test), True), (None, None, True), (None, None, None)]
    pages = {folder / "proof.html", folder / "m_unset_variable.html"}
    assert {scenario, test, *pages} == set(folder.iterdir())


def test_a_folder_with_files_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Before anything is explored."""
    (tmp_path / "mine.py").touch()
    assert main(["prove", "square", "-o", str(tmp_path)]) == 2
    message = f"{tmp_path}: the folder is not empty; name another with -o [BT-1103]"
    assert message in capsys.readouterr().err


def test_the_tree_is_below_the_findings(capsys: pytest.CaptureFixture[str]) -> None:
    """Each node with its outcomes."""
    assert main(["prove", "patrol", "--faults", "0", "--tree"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "outcomes of nodes: ✓ some run reaches it, · none does" in lines
