"""Where missions, worlds and robots are found."""

import sys
from pathlib import Path

import pytest

from bt_mission.base import files
from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import plain_words


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Each test works in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: Path) -> Path:
    """Write a file that is there to be found."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("name: x\n", encoding="utf-8")
    return path


def test_shipped_names_are_found_from_anywhere():
    """The source checkout, or the installed data, is the last place that is looked at."""
    assert "explore" in files.names("missions")
    assert files.find("missions", "explore").name == "explore.yaml"
    assert "waffle" in files.names("robots")


def test_a_path_is_taken_as_it_is(elsewhere):
    """Absolute, or relative to the working folder."""
    path = write(elsewhere / "my" / "own.yaml")
    assert files.find("worlds", path) == path
    assert files.find("worlds", "my/own.yaml") == Path("my/own.yaml")


def test_what_stands_beside_the_mission_comes_before_the_shipped(elsewhere):
    """A mission folder that is moved keeps working."""
    near = write(elsewhere / "project" / "missions" / "m.yaml")
    beside = write(near.parent / "dqn_stage4.yaml")
    assert files.find("worlds", "dqn_stage4", near) == beside
    assert files.find("worlds", "dqn_stage4.yaml", near) == beside
    assert files.find("worlds", "dqn_stage4", near.parent) == beside


def test_the_folders_of_a_project_are_siblings(elsewhere):
    """missions/m.yaml finds worlds/w.yaml of the same project."""
    near = write(elsewhere / "project" / "missions" / "m.yaml")
    sibling = write(elsewhere / "project" / "worlds" / "w.yaml")
    assert files.find("worlds", "w", near) == sibling


def test_the_users_folder_comes_before_the_shipped(elsewhere):
    """./worlds/NAME.yaml replaces a shipped world of that name."""
    write(elsewhere / "worlds" / "dqn_stage4.yaml")
    assert files.find("worlds", "dqn_stage4") == Path("worlds/dqn_stage4.yaml")


def test_installed_data_is_found_below_the_prefix(elsewhere, monkeypatch):
    """Where there is no checkout."""
    shared = write(elsewhere / "share" / "bt_mission" / "worlds" / "far.yaml")
    monkeypatch.setattr(sys, "prefix", str(elsewhere))
    assert files.find("worlds", "far") == shared
    assert "far" in files.names("worlds")


def test_shipped_files_are_found_by_their_paths_in_the_sources(elsewhere):
    """What the documentation writes works without a checkout, too."""
    shipped = files.find("missions", "square")
    assert files.find("missions", "missions/square.yaml") == shipped
    assert files.look_for("worlds", "missions/square.yaml") is None
    own = write(elsewhere / "missions" / "square.yaml")
    assert files.find("missions", "missions/square.yaml").resolve() == own


def test_an_unknown_name_is_told_with_the_known_ones():
    """And the nearest of them."""
    with pytest.raises(InputError) as caught:
        files.find("robots", "wafle")
    (fault,) = caught.value.diagnostics
    assert fault.file == "wafle"
    assert fault.message.startswith("no such robot (known: ")
    assert fault.hint == "did you mean 'waffle'?"


@pytest.mark.parametrize("name", ["", ".", "..", "/", "a\0b", "x" * 5000, "worlds"])
def test_names_that_are_none_find_nothing(name):
    """Neither folders nor what the file system refuses."""
    assert files.look_for("worlds", name) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "mission: square\nworld: empty_arena # flat\n",
            {"mission": "square", "world": "empty_arena"},
        ),
        ("mission: back up\n", {"mission": "back up"}),
        ("# mission: no\nmission:\n  mission: inner\n", {}),
        ("mission: $(rm) \n", {}),
        ("world: '\\e[2J'\nscenario: two words\n", {"scenario": "two words"}),
    ],
)
def test_a_first_look_takes_plain_words_alone(
    tmp_path: Path, text: str, words: dict[str, str]
) -> None:
    """Of the outermost mapping; whatever else is there waits for the parser."""
    path = tmp_path / "m.yaml"
    path.write_text(text)
    assert plain_words(path) == words
    assert plain_words(tmp_path / "m.xml") == {}
