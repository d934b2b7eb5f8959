"""Lists of missions, worlds and robots, and copies of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.core.files import find

KINDS = ["missions", "worlds", "robots"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", KINDS)
def test_a_list_has_a_line_for_each(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Name, where from, the first sentence of its description; with `list` or without."""
    assert main([kind]) == 0
    said = capsys.readouterr().out
    assert main([kind, "list"]) == 0
    assert capsys.readouterr().out == said
    assert all("  shipped  " in line for line in said.splitlines())
    expected = {"missions": "square", "worlds": "empty_arena", "robots": "burger"}[kind]
    assert any(line.startswith(f"{expected} ") for line in said.splitlines())


@pytest.mark.parametrize("arguments", [["worlds", "--json"], ["worlds", "list", "--json"]])
def test_programs_get_objects(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """One list."""
    assert main(arguments) == 0
    found = {one["name"]: one for one in json.loads(capsys.readouterr().out)}
    stage = found["dqn_stage1"]
    assert stage == {
        "name": "dqn_stage1",
        "kind": "world",
        "description": "Four walls and nothing inside, 4.70 m x 4.70 m.",
        "shipped": True,
        "path": str(find("worlds", "dqn_stage1").absolute()),
    }


@pytest.mark.parametrize(
    ("kind", "name", "to", "written"),
    [
        ("missions", "square", [], ["missions/square.yaml"]),
        ("missions", "meanwhile", ["mine.yaml"], ["mine.yaml"]),
        ("worlds", "nav_arena", ["halls/mine"], ["halls/mine/nav_arena.yaml"]),
        ("robots", "waffle", ["own.yml"], ["own.yml"]),
        (
            "missions",
            "scenarios/square.scenario.yaml",
            [],
            ["missions/scenarios/square.scenario.yaml", "missions/square.yaml"],
        ),
        (
            "missions",
            "fleets/two_wanderers.fleet.yaml",
            [],
            ["missions/fleets/two_wanderers.fleet.yaml", "missions/sources/two_metres.yaml"],
        ),
    ],
)
def test_a_copy_is_the_same_file(
    kind: str, name: str, to: list[str], written: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """In the folder of its kind, another folder or a file; with the files that it names."""
    assert main([kind, "copy", name, *to]) == 0
    assert capsys.readouterr().out.splitlines() == [f"{one}: written" for one in written]
    there = [str(path) for path in Path().rglob("*") if path.is_file()]
    assert sorted(there) == sorted(written)


def test_a_copy_stands_for_the_shipped_file(capsys: pytest.CaptureFixture[str]) -> None:
    """By its name, in this folder; and it is valid where it lies."""
    assert main(["missions", "copy", "square"]) == 0
    capsys.readouterr()
    assert main(["check", "square"]) == 0
    assert capsys.readouterr().out.startswith("missions/square.yaml: mission 'square' is valid")
    assert main(["missions"]) == 0
    assert "square" in capsys.readouterr().out.splitlines()[0]


def test_a_file_that_exists_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    """Each of them, before anything is written; unless --force is given."""
    Path("missions").mkdir()
    Path("missions/square.yaml").write_text("mine\n")
    command = ["missions", "copy", "scenarios/square.scenario.yaml"]
    assert main(command) == 2
    expected = "missions/square.yaml exists; give another name, or --force to overwrite it\n"
    assert capsys.readouterr().err == expected
    assert not Path("missions/scenarios").exists()
    assert main([*command, "--force"]) == 0
    assert "mission: square" in Path("missions/square.yaml").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["worlds", "copy", "empty_arnea"], "did you mean 'empty_arena'?"),
        (["worlds", "copy", "square"], "no such world (known: "),
        (["missions", "copy", "square", "mine.txt"], "expected a folder, or a file that ends with"),
        (["robots", "copy", "waffle", "/proc/none"], "cannot make /proc/none: No such file"),
        (
            ["missions", "copy", "scenarios/square.scenario.yaml", "mine.yaml"],
            "names square.yaml in another folder, which is copied with it: give a folder",
        ),
    ],
)
def test_what_cannot_be_copied_is_told(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """And nothing is written."""
    assert main(arguments) == 2
    assert words in capsys.readouterr().err
    assert list(Path().iterdir()) == []


def test_a_file_is_not_copied_onto_itself(capsys: pytest.CaptureFixture[str]) -> None:
    """That would be no copy."""
    assert main(["missions", "copy", "square"]) == 0
    capsys.readouterr()
    assert main(["missions", "copy", "square", "--force"]) == 2
    assert "missions/square.yaml is that file itself" in capsys.readouterr().err


def test_a_copy_does_not_take_the_place_of_a_file_that_it_names(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Both would be written to one file, and one of them lost."""
    Path("a.yaml").write_text("mission: a\ninclude: [b.yaml]\ntree: {wait: 1}\n")
    Path("b.yaml").write_text("trees: {}\n")
    assert main(["missions", "copy", "a.yaml", "new/b.yaml"]) == 2
    assert "a.yaml names b.yaml, which is copied with it" in capsys.readouterr().err
    assert not Path("new").exists()
