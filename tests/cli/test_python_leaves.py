"""``check`` imports no code of a mission's unless told to; ``--no-python`` refuses it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli.main import main

LEAF = """
import pathlib
from py_trees.behaviour import Behaviour
from py_trees.common import Status
pathlib.Path(__file__).with_name("ran").touch()
class Leaf(Behaviour):
    times: int = 1
    def update(self):
        return Status.SUCCESS
"""
MISSION = """\
mission: m
tree:
  python: leaf.py:Leaf
  inputs: {tmies: 2}
"""


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    """A mission with a Python leaf, whose file leaves a trace when it is imported."""
    (tmp_path / "leaf.py").write_text(LEAF)
    (tmp_path / "m.yaml").write_text(MISSION)
    return tmp_path / "m.yaml"


def test_check_names_python_leaves(mission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With their place, and how to have them imported; their code does not run."""
    assert main(["check", str(mission)]) == 0
    said = capsys.readouterr().err
    assert "m.yaml:3:11: warning: Python code, which was not imported: 'leaf.py:Leaf'" in said
    assert "--import-python" in said
    assert not mission.with_name("ran").exists()


def test_programs_see_the_warning(mission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As every other."""
    assert main(["check", "--json", str(mission)]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["line"], found["column"], found["severity"]) == (3, 11, "warning")


def test_check_imports_them_where_told_to(
    mission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Then it knows their attributes."""
    assert main(["check", "--import-python", str(mission)]) == 2
    assert "no attribute 'tmies' on Leaf" in capsys.readouterr().err
    assert mission.with_name("ran").exists()


def test_a_file_that_is_not_there_is_found_without_an_import(
    mission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """So is a plug-in."""
    mission.with_name("leaf.py").unlink()
    assert main(["check", str(mission)]) == 2
    assert "no such file: leaf.py" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command", [["check"], ["check", "--import-python"], ["run"], ["run", "--attach"]]
)
def test_python_leaves_can_be_refused(
    mission: Path, command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is imported, or moves."""
    assert main([*command, "--no-python", str(mission)]) == 2
    said = capsys.readouterr().err
    assert "m.yaml:3:11: error: the Python leaf 'leaf.py:Leaf' is refused; --no-python" in said
    assert not mission.with_name("ran").exists()
