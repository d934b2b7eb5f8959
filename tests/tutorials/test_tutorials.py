"""Files, scripts and the notebook of docs/tutorials. tests/docs/test_commands.py types commands."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from bt_mission.testing import LiveGraph
from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

TUTORIALS = ROOT / "docs" / "tutorials"
PAGES = [*sorted(TUTORIALS.glob("*.md")), ROOT / "docs" / "how-to" / "own-project.md"]
LISTED = re.compile(
    r"^\[(code/\S+)\]\(\1\):\n\n```\w+(?: \S+)?\n(.*?)^```$", re.MULTILINE | re.DOTALL
)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_is_listed_is_what_the_files_hold(page: Path) -> None:
    """A file that is shown on the page is the file in the folder."""
    for name, text in LISTED.findall(page.read_text(encoding="utf-8")):
        assert (page.parent / name).read_text(encoding="utf-8") == text


def test_the_files_of_the_folder_are_all_shown() -> None:
    """None is left over."""
    shown = {name for page in PAGES for name, _ in LISTED.findall(page.read_text(encoding="utf-8"))}
    assert shown == {
        f"code/{path.name}" for path in (TUTORIALS / "code").iterdir() if path.is_file()
    }


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.parametrize(
    ("script", "output"),
    [
        pytest.param("ten_lines", "side: success", marks=pytest.mark.thorough),
        ("patrol_node", "1 round, node.messages > 0=True"),
    ],
)
def test_a_script_runs_as_written(
    live_graph: LiveGraph, monkeypatch: pytest.MonkeyPatch, script: str, output: str
) -> None:
    """Beside simulator and servers, in a folder with the mission of the page alone."""
    page = (TUTORIALS / "embed.md").read_text(encoding="utf-8")
    (mission,) = re.findall(r"```yaml side\.yaml\n(.*?)```", page, re.DOTALL)
    (live_graph.folder / "side.yaml").write_text(mission, encoding="utf-8")
    monkeypatch.chdir(live_graph.folder)
    live_graph.robot("empty_arena")
    script_path = str(TUTORIALS / "code" / f"{script}.py")
    program = live_graph.start_program(script, sys.executable, script_path)
    assert program.wait(within=180) == 0, program.output
    assert output in program.output


@pytest.mark.thorough
@pytest.mark.process
def test_each_cell_of_the_notebook_runs_and_shows_its_value(tmp_path: Path) -> None:
    """In a kernel of its own; the shipped notebook has no outputs."""
    notebook: Any = nbformat.read(TUTORIALS / "notebook.ipynb", as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    place = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=PATIENCE_S, kernel_name="python3", resources=place).execute()
    shown = {
        cell.id: cell.outputs[-1]["data"]
        for cell in notebook.cells
        if cell.cell_type == "code" and "data" in cell.outputs[-1]
    }
    assert shown["load"]["image/svg+xml"].startswith("<svg ")
    report = shown["drive"]["text/html"]
    assert "<b>corner: success</b>" in report
    assert "<td>keeps clear</td><td>holds by " in report
    page = shown["recording"]["text/html"]
    assert page.startswith('<iframe sandbox="allow-scripts"')
    assert "&lt;title&gt;corner" in page
