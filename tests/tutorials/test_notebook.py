"""docs/tutorials/notebook.ipynb: each cell runs, and shows the mission and its results richly."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

NOTEBOOK = ROOT / "docs" / "tutorials" / "notebook.ipynb"


@pytest.mark.process
def test_each_cell_runs_and_shows_its_value(tmp_path: Path) -> None:
    """In a kernel of its own; the shipped notebook has no outputs."""
    notebook: Any = nbformat.read(NOTEBOOK, as_version=4)
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
    for name, title in (("recording", "corner"), ("proof", "corner")):
        page = shown[name]["text/html"]
        assert page.startswith('<iframe sandbox="allow-scripts"')
        assert f"&lt;title&gt;{title}" in page
