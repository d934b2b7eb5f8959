"""Outputs that would destroy something are refused before anything runs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bt_mission.cli.argument_types import FileType
from bt_mission.cli.commands import load_commands
from bt_mission.cli.main import main, make_parser

MISSION = "mission: m\nworld: hall.yaml\ninclude: [trees.yaml]\ntree: {tree: pause}\n"
TREES = "trees:\n  pause: {do: {wait: 0.1}}\n"
PART = "mission: part\ntree:\n  sequence:\n    - wait: 0.1\n"
FLEET = """\
fleet: two
world: empty_arena
robots:
  one: {mission: part.yaml, start: {x: 0, y: 0}}
  two: {mission: part.yaml, start: {x: 1, y: 1}}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Go to a folder with a mission, a tree that it includes, its world, and requirements."""
    (tmp_path / "m.yaml").write_text(MISSION, encoding="utf-8")
    (tmp_path / "trees.yaml").write_text(TREES, encoding="utf-8")
    (tmp_path / "part.yaml").write_text(PART, encoding="utf-8")
    (tmp_path / "hall.yaml").write_text(
        "name: hall\nsize: [4, 4]\nspawn: {x: 0, y: 0}\n", encoding="utf-8"
    )
    (tmp_path / "safe.yaml").write_text(
        "requirements:\n  slow: always speed < 5\n", encoding="utf-8"
    )
    (tmp_path / "two.fleet.yaml").write_text(FLEET, encoding="utf-8")
    (tmp_path / "link.jsonl").symlink_to("m.yaml")
    os.link(tmp_path / "m.yaml", tmp_path / "hard.jsonl")
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            "run part.yaml --record a.mcap --trace sub/../a.mcap",
            "--trace and --record name the same file, a.mcap: name two",
        ),
        (
            "run part.yaml --trace c.html --report c.html",
            "--trace and --report name the same file, c.html: name two",
        ),
        (
            "run m.yaml --trace m.yaml --force",
            "--trace m.yaml: is the file that FILE names; name another one to write",
        ),
        ("run m.yaml --trace link.jsonl --force", "--trace m.yaml: is the file that FILE names"),
        ("run m.yaml --trace hard.jsonl --force", "--trace m.yaml: is the file that FILE names"),
        (
            "run m.yaml --require safe.yaml --trace safe.yaml --force",
            "--trace safe.yaml: is the file that --require names",
        ),
        ("run m.yaml --trace trees.yaml --force", "trees.yaml: is read for this run"),
        ("run m.yaml --trace hall.yaml --force", "hall.yaml: is read for this run"),
        ("run two.fleet.yaml --trace part.yaml --force", "part.yaml: is read for this run"),
        ("tree m.yaml --format dot -o trees.yaml --force", "trees.yaml: is read for this run"),
        ("convert m.yaml -o m.yaml --force", "--output m.yaml: is the file that FILE names"),
        ("convert m.yaml -o trees.yaml --force", "trees.yaml: is read for this run"),
        ("sweep m.yaml --seeds 2 --report trees.yaml", "trees.yaml: is read for this run"),
        ("sweep m.yaml --seeds 2 --report m.yaml", "--report m.yaml: is the file that FILE names"),
        ("run m.yaml --trace sub", "--trace sub: is a folder; name a file"),
        ("run m.yaml --trace no/t", "--trace no/t: there is no folder no"),
    ],
)
def test_it_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], words: str, message: str
) -> None:
    """With the options, whatever names the file has; no file is touched."""
    before = {one: one.read_bytes() for one in folder.iterdir() if one.is_file()}
    assert main(words.split()) == 2
    assert message in capsys.readouterr().err
    assert {one: one.read_bytes() for one in folder.iterdir() if one.is_file()} == before


def test_an_output_that_cannot_be_made_leaves_the_others_untouched(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where they may be overwritten."""
    old = folder / "old.mcap"
    old.write_bytes(b"the only copy")
    words = ["run", "part.yaml", "--record", "old.mcap", "--trace", "/nonexist/t", "--force"]
    assert main(words) == 2
    assert "--trace /nonexist/t: there is no folder /nonexist" in capsys.readouterr().err
    assert old.read_bytes() == b"the only copy"
    assert not list(folder.glob("*part.mcap"))


def test_files_of_a_fleet_that_exist_are_kept(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of each robot."""
    (folder / "two.one.jsonl").write_bytes(b"the only copy")
    assert main(["run", "two.fleet.yaml", "--trace", "two.jsonl"]) == 2
    assert "two.one.jsonl exists" in capsys.readouterr().err


def test_a_device_takes_several_outputs(folder: Path) -> None:
    """It is no file."""
    words = ["--json", "--trace", "/dev/null", "--record", "/dev/null"]
    assert main(["run", "part.yaml", *words]) == 0


def test_options_with_files_declare_what_they_are() -> None:
    """Else the rule does not know them; folders are not files."""
    undeclared = [
        f"{name} {option.attribute}"
        for name, parser in load_commands(make_parser()).choices.items()
        if any(
            isinstance(one.type, FileType) and "output" in one.type.role for one in parser.options
        )
        for option in parser.options
        if option.type is Path and option.metavar not in ("FOLDER", "DIR")
    ]
    assert undeclared == ["run images", "sweep-report folder"]
