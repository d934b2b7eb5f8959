"""What missions, worlds and robots there are, and which files belong to one."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.file_index import LISTED, files_of, find_listed, list_files
from bt_mission.base.files import Kind, fleets, names, scenarios
from tests.support.thorough import sample

TREE = "tree: {wait: 1}\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: str, text: str) -> Path:
    """Write a file below the working folder."""
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize("kind", sample(LISTED, 9))
def test_every_shipped_file_is_listed_with_a_line(kind: Kind) -> None:
    """By the name that commands take."""
    files = list_files(kind)
    assert all(
        file.is_shipped and file.description and "\n" not in file.description for file in files
    )
    listed = {file.name for file in files}
    assert {*names(kind), *([*scenarios(), *fleets()] if kind == "missions" else ())} <= listed
    assert all(find_listed(kind, file.name) == file for file in files)


def test_files_of_the_working_folder_come_first() -> None:
    """In the folder of their kind and beside it; a name hides the shipped file of that name."""
    write("missions/square.yaml", f"mission: square\ndescription: Mine.\n{TREE}")
    write("missions/more/turns.yaml", f"# Turns. And more.\nmission: turns\n{TREE}")
    write("near.yaml", f"mission: near\n{TREE}")
    write(
        "near.scenario.yaml",
        "# yaml-language-server: $schema=s.json\n# Near.\nscenario: s\nmission: near.yaml\n",
    )
    write("library.yaml", "trees: {}\n")
    write("notes.yaml", "a: b\n")
    write("hall.yaml", "name: hall\nspawn: {x: 0, y: 0}\n")
    own = [file for file in list_files("missions") if not file.is_shipped]
    assert [(listed.name, listed.what, listed.description) for listed in own] == [
        ("near.scenario.yaml", "scenario", "Near."),
        ("near.yaml", "mission", ""),
        ("square", "mission", "Mine."),
        ("more/turns.yaml", "mission", "Turns."),
    ]
    assert [file.name for file in list_files("missions")].count("square") == 1
    assert [file.name for file in list_files("worlds") if not file.is_shipped] == ["hall.yaml"]


def test_a_file_that_cannot_be_read_is_listed_as_such() -> None:
    """With the first fault in it, on one line."""
    write("missions/torn.yaml", "mission: torn\ntree: {wait: [\n")
    (torn,) = (file for file in list_files("missions") if file.name == "torn")
    assert torn.description.startswith("cannot be read: line ")


def test_the_last_part_of_a_name_is_enough() -> None:
    """Scenarios need no suffixes; what is listed nowhere is found by its path."""
    assert find_listed("missions", "meanwhile").name == "sources/meanwhile.yaml"
    assert find_listed("missions", "back_up").what == "scenario"
    path = write("elsewhere/m.yaml", f"mission: m\n{TREE}")
    assert find_listed("missions", "elsewhere/m.yaml").path == path


def test_a_wrong_name_gets_the_nearest() -> None:
    """Also of those that lie deeper."""
    with pytest.raises(InputError) as caught:
        find_listed("missions", "meanwile")
    (fault,) = caught.value.diagnostics
    assert fault.hint == "did you mean 'meanwhile'?"
    assert fault.message.startswith("no such mission (known: explore, ")


def test_a_file_brings_those_that_it_names_by_path() -> None:
    """Trees that are included, in turn; the files of a scenario; Python leaves. Each once."""
    main = write(
        "own/s/a.scenario.yaml", "scenario: a\nmission: ../m.yaml\nworld: ../hall.yaml\nrobot: r\n"
    )
    write("own/m.yaml", "mission: m\ninclude: [t.yaml, sources/x.yaml]\ntree: {tree: t}\n")
    write("own/t.yaml", "include: [t.yaml]\ntrees: {t: {python: 'leaves/own.py:Count'}}\n")
    write("own/leaves/own.py", "class Count: ...\n")
    write("own/hall.yaml", "name: hall\n")
    files = {path.resolve() for path in files_of(main)}
    names = ("s/a.scenario.yaml", "m.yaml", "t.yaml", "leaves/own.py", "hall.yaml")
    assert files == {(Path("own") / name).resolve() for name in names}


def test_a_file_that_is_no_yaml_has_no_others() -> None:
    """The error has its place."""
    with pytest.raises(InputError):
        files_of(write("torn.yaml", "mission: [\n"))
