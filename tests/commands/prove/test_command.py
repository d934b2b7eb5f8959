"""`bt-mission prove` from the command line: exit codes, JSON, files and what it refuses."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.support.command_line import CommandLine

UNSET = """mission: m
tree:
  sequence:
    - fallback:
        - {turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}
        - log: no turn
    - log: $code
"""


def test_json_names_the_files_and_what_the_stage_has_shown(cli: CommandLine) -> None:
    """`-o` writes them; `--confirm` runs without files; neither is null for all."""
    cli.write("m.yaml", UNSET)
    rows = []
    for more in ("-o findings", "--confirm", ""):
        (finding,) = cli.json(f"prove m.yaml --faults 1 {more}", 1)["findings"]
        rows.append((finding["scenario"], finding["confirmed"]))
    scenario = "findings/m_unset_variable.scenario.yaml"
    assert rows == [(scenario, True), (None, True), (None, None)]
    pages = {"findings/proof.html", "findings/m_unset_variable.html"}
    assert {scenario, *pages} == {str(path) for path in Path("findings").iterdir()}


def test_a_folder_with_files_is_refused(cli: CommandLine) -> None:
    """Before anything is explored."""
    cli.write("mine.py", "")
    message = ".: the folder is not empty; name another with -o [BT-1103]"
    assert message in cli.refused("prove square -o .")


def test_the_tree_is_below_the_findings(cli: CommandLine) -> None:
    """Each node with its outcomes."""
    lines = cli.lines("prove patrol --faults 0 --tree")
    assert "outcomes of nodes: ✓ some run reaches it, · none does" in lines


@pytest.mark.parametrize(
    ("files", "is_terminal", "is_shown"),
    [
        ("square", True, True),
        ("square", False, False),
        ("square patrol", True, False),
        ("square --json", True, False),
    ],
)
def test_check_names_prove_to_a_person_where_it_applies(
    cli: CommandLine,
    monkeypatch: pytest.MonkeyPatch,
    files: str,
    *,
    is_terminal: bool,
    is_shown: bool,
) -> None:
    """Once: pipes, several files and programs get what they had."""
    monkeypatch.setattr(sys.stdout, "isatty", lambda: is_terminal)
    hint = "  'bt-mission prove square' explores every answer of its servers\n"
    assert cli(f"check {files}").endswith(hint) is is_shown
