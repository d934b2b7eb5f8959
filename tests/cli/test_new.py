"""``bt-mission new``: a project that is valid, runs and passes its tests, or nothing at all."""

from __future__ import annotations

import errno
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NoReturn

import pytest
from jsonschema import Draft202012Validator

from bt_mission.cli import main
from bt_mission.cli.new import TEMPLATES
from bt_mission.core.yaml.document import read
from tests.support.processes import PATIENCE_S

NAME = "walker"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def project(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Path:
    """The folder of a new project, as the working one."""
    assert main(["new", NAME]) == 0
    capsys.readouterr()
    monkeypatch.chdir(NAME)
    return folder / NAME


def test_it_says_what_it_has_made_and_what_to_do_next(capsys: pytest.CaptureFixture[str]) -> None:
    """Every file, and commands that work in the folder; nothing else lies there."""
    assert main(["new", NAME]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "walker: a new project"
    files = [path.as_posix() for path in sorted(Path().rglob("*")) if path.is_file()]
    assert [line.strip() for line in said[1 : said.index("next:")]] == sorted(files)
    assert len(files) == len(TEMPLATES) + 2
    assert said[said.index("next:") + 1] == "  cd walker"
    assert [path.name for path in Path().iterdir()] == [NAME]


@pytest.mark.parametrize("name", ["a", "a_rather_long_name"])
def test_what_it_says_of_commands_stands_in_a_column(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """However long the name is."""
    assert main(["new", name]) == 0
    said = capsys.readouterr().out
    columns = {line.index("#") for line in said.splitlines() if "#" in line}
    assert len(columns) == 1


def test_where_pytest_is_not_installed_it_says_how(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is an extra, which the tests of the project need."""
    monkeypatch.setattr("bt_mission.cli.new.find_spec", lambda _: None)
    assert main(["new", NAME]) == 0
    assert "  pip install 'bt-mission[test]'" in capsys.readouterr().out


def test_its_missions_are_valid_and_run(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By their names, in its folder."""
    assert main(["check", NAME, "scenarios/box_appears.scenario.yaml"]) == 0
    said = capsys.readouterr()
    assert said.out.endswith("2 of 2 files are valid\n")
    assert said.err == ""
    assert main(["run", NAME, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["world"], report["collisions"]) == ("hall", 0)
    assert {one["verdict"] for one in report["requirements"]} == {"holds"}
    assert main(["missions"]) == 0
    assert "here     Drive to the far wall" in capsys.readouterr().out


@pytest.mark.process
def test_it_passes_its_own_tests(project: Path) -> None:
    """Three tests and a scenario, without a setting of ours."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--color=no"],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stdout
    assert "4 passed" in done.stdout


def test_its_schemas_hold_for_its_files(project: Path) -> None:
    """The editor's settings and the first line of each file name the schema that is for it."""
    settings = json.loads((project / ".vscode/settings.json").read_text(encoding="utf-8"))
    for name, pattern in settings["yaml.schemas"].items():
        schema = json.loads((project / name).read_text(encoding="utf-8"))
        (file,) = project.glob(pattern)
        Draft202012Validator(schema).validate(read(file).data)
        _, _, beside = file.read_text(encoding="utf-8").splitlines()[0].partition("$schema=")
        assert (file.parent / beside).resolve() == (project / name).resolve()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a/b", "'a/b' has the parts of a path: expected letters, digits, '_' and '-'"),
        ("/elsewhere/x", "so change to the folder that it is to lie in"),
        ("..", "'..' has the parts of a path"),
        (".", "'.' has the parts of a path"),
        ("", "'' is no name of a project"),
        ("1st", "'1st' is no name of a project"),
        ("a b", "'a b' is no name of a project"),
        ("a\nb", "'a\\nb' is no name of a project"),
        ("größe", "is no name of a project"),
        ("x" * 65, "64 characters at most"),
        ("Yes", "'Yes' is a value in YAML"),
    ],
)
def test_a_name_that_is_none_is_refused(
    name: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """With what is expected; nothing is made."""
    assert main(["new", name]) == 2
    assert words in capsys.readouterr().err
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("name", ["N", "a-1_b", "NAME", "x" * 64, "y", "square"])
def test_every_other_name_gives_a_valid_mission(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also that of a shipped mission, which is another one."""
    assert main(["new", name]) == 0
    monkeypatch.chdir(name)
    assert main(["check", name]) == 0
    assert f"missions/{name}.yaml: mission '{name}' is valid" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_exists_is_kept(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder, also an empty one; a file; a link to nowhere."""
    there = Path(NAME)
    if kind == "folder":
        there.mkdir()
    elif kind == "file":
        there.write_text("mine")
    else:
        there.symlink_to("nowhere")
    assert main(["new", NAME]) == 2
    assert capsys.readouterr().err == f"{NAME} exists; give another name, or remove it first\n"
    assert [path.name for path in Path().iterdir()] == [NAME]
    assert not there.is_dir() or list(there.iterdir()) == []


def test_a_disk_that_is_full_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The folder comes to its place as a whole."""
    write = Path.write_text

    def fail(path: Path, text: str, **options: Any) -> int:
        if path.name == "hall.yaml":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, text, **options)

    monkeypatch.setattr(Path, "write_text", fail)
    assert main(["new", NAME]) == 2
    assert capsys.readouterr().err == f"cannot make {NAME}: No space left on device\n"
    assert list(Path().iterdir()) == []


def test_a_folder_that_may_not_be_written_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As for the user of a shared machine; root may write everywhere."""

    def refuse(*_: object, **__: object) -> NoReturn:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("bt_mission.cli.new.TemporaryDirectory", refuse)
    assert main(["new", NAME]) == 2
    assert capsys.readouterr().err == f"cannot make {NAME}: Permission denied\n"


def test_inside_of_a_project_it_asks_first(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also in a folder below it; whoever means it says so."""
    monkeypatch.chdir(project / "missions")
    assert main(["new", "other"]) == 2
    said = capsys.readouterr().err
    assert said == (
        f"'other' would be made inside the project {project}; change to another folder, or add "
        "--yes\n"
    )
    answers = io.StringIO("\ny\n")
    monkeypatch.setattr(answers, "isatty", lambda: True)
    monkeypatch.setattr("sys.stdin", answers)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert main(["new", "other"]) == 2
    said = capsys.readouterr().err
    assert said.endswith(f"inside the project {project}. Make it there? [y/N] nothing was made\n")
    assert not Path("other").exists()
    assert main(["new", "other"]) == 0
    assert main(["new", "third", "--yes"]) == 0
    assert Path("other").is_dir()
    assert Path("third").is_dir()
