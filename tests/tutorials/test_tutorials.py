"""docs/tutorials, and how to start a project: what they say to type gives what stands below."""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from bt_mission.cli import main
from bt_mission.testing import LiveGraph
from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

TUTORIALS = ROOT / "docs" / "tutorials"
PAGES = [*sorted(TUTORIALS.glob("*.md")), ROOT / "docs" / "how-to" / "own-project.md"]
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LISTED = re.compile(r"^\[(code/\S+)\]\(\1\):\n\n```\w+\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def typed(command: str) -> list[str]:
    """The arguments of a command of ours."""
    name, *arguments = shlex.split(command)
    assert name == "bt-mission"
    return arguments


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_gives_what_stands_below_it(
    page: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the order of the page, with the files that it says to save; ``...`` is anything."""
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    monkeypatch.chdir(tmp_path)
    commands = 0
    for name, text in LISTED.findall(page.read_text(encoding="utf-8")):
        (tmp_path / Path(name).name).write_text(text, encoding="utf-8")
    for language, name, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "yaml" and name:
            Path(name).write_text(text, encoding="utf-8")
        if language != "console":
            continue
        for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            command, _, expected = part.partition("\n")
            if command.startswith("cd "):
                monkeypatch.chdir(command.removeprefix("cd "))
                continue
            with contextlib.suppress(SystemExit):
                main(typed(command))
            output, complaint = capsys.readouterr()
            pattern = re.sub(r"[\[*?]", "[\\g<0>]", expected).replace("...", "*")
            assert fnmatchcase(_clean(output + complaint), _clean(pattern)), output + complaint
            commands += 1
    assert commands >= 1


def _clean(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


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
    for name in ("recording", "proof"):
        page = shown[name]["text/html"]
        assert page.startswith('<iframe sandbox="allow-scripts"')
        assert "&lt;title&gt;corner" in page
