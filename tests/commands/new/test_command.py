"""`bt-mission new`: a project that is valid, runs and passes its tests, or nothing at all."""

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

from bt_mission.base.yaml.document import read
from bt_mission.commands.new.command import TEMPLATES
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S

NAME = "walker"
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--color=no"]


@pytest.fixture
def project(cli: CommandLine, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a new project, as the working one."""
    cli(f"new {NAME}")
    monkeypatch.chdir(NAME)
    return cli.folder / NAME


@pytest.mark.parametrize("name", ["a", NAME, "a_rather_long_name"])
def test_it_lists_what_it_has_made_and_what_to_do_next(cli: CommandLine, name: str) -> None:
    """Every file, and commands that work in the folder, explained in a column."""
    lines = cli.lines(f"new {name}")
    assert lines[0] == f"{name}: a new project"
    files = sorted(cli.files())
    assert [line.strip() for line in lines[1 : lines.index("next:")]] == files
    assert len(files) == len(TEMPLATES) + 2
    assert lines[lines.index("next:") + 1] == f"  cd {name}"
    assert [path.name for path in Path().iterdir()] == [name]
    assert len({line.index("#") for line in lines if "#" in line}) == 1


def test_where_pytest_is_not_installed_it_says_how(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is an extra, which the tests of the project need."""
    monkeypatch.setattr("bt_mission.commands.new.command.find_spec", lambda _: None)
    assert "  pip install 'bt-mission[test]'" in cli(f"new {NAME}")


@pytest.mark.usefixtures("project")
def test_its_missions_are_valid_and_run(cli: CommandLine) -> None:
    """By their names, in its folder."""
    out = cli(f"check {NAME} scenarios/box_appears.scenario.yaml")
    assert out.endswith("2 of 2 files are valid\n")
    assert cli.err == ""
    report = cli.json(f"run {NAME}")
    assert (report["world"], report["collisions"]) == ("hall", 0)
    assert {each["verdict"] for each in report["requirements"]} == {"holds"}
    assert "here     Drive to the far wall" in cli("missions")


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.usefixtures("project")
def test_it_passes_its_own_tests() -> None:
    """Three tests and a scenario, with one seed each."""
    done = subprocess.run(
        [*PYTEST, "--scenario-seeds=1"],
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


def test_a_name_of_two_lines_is_refused(cli: CommandLine) -> None:
    """Other invalid names are in transcripts/missions.txt."""
    assert "'a\\nb' is not a valid project name" in cli.refused("new 'a\nb'")
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("name", ["N", "a-1_b", "NAME", "x" * 64, "y", "square"])
def test_every_other_name_gives_a_valid_mission(
    name: str, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also that of a shipped mission, which is another one."""
    cli(f"new {name}")
    monkeypatch.chdir(name)
    assert f"missions/{name}.yaml: mission '{name}' is valid" in cli(f"check {name}")


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_exists_is_kept(kind: str, cli: CommandLine) -> None:
    """A folder, also an empty one; a file; a link to nowhere."""
    path = Path(NAME)
    if kind == "link":
        path.symlink_to("nowhere")
    else:
        path.mkdir() if kind == "folder" else path.touch()
    error = cli.refused(f"new {NAME}")
    assert error == f"{NAME} exists; give another name, or remove it first [BT-1103]\n"
    assert [each.name for each in Path().iterdir()] == [NAME]
    assert not path.is_dir() or list(path.iterdir()) == []


def test_a_disk_that_is_full_leaves_nothing(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The folder gets its name once it is whole."""
    write = Path.write_text

    def fail(path: Path, text: str, **options: Any) -> int:
        if path.name == "hall.yaml":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, text, **options)

    monkeypatch.setattr(Path, "write_text", fail)
    assert (
        cli.refused(f"new {NAME}") == f"cannot create {NAME}: No space left on device [BT-1103]\n"
    )
    assert list(Path().iterdir()) == []


def test_a_folder_that_may_not_be_written_is_named(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As for the user of a shared machine; root may write everywhere."""

    def refuse(*_: object, **__: object) -> NoReturn:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("bt_mission.commands.new.command.TemporaryDirectory", refuse)
    assert cli.refused(f"new {NAME}") == f"cannot create {NAME}: Permission denied [BT-1103]\n"


def test_inside_of_a_project_it_asks_first(
    project: Path, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also in a folder below it; `--yes` answers."""
    monkeypatch.chdir(project / "missions")
    expected = f"'other' is inside the project {project}"
    assert (
        cli.refused("new other")
        == f"{expected}; change to another folder, or add --yes [BT-1104]\n"
    )
    answers = io.StringIO("\ny\n")
    monkeypatch.setattr(answers, "isatty", lambda: True)
    monkeypatch.setattr("sys.stdin", answers)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    expected = (
        f"inside the project {project}. Create it there? [y/N] nothing was created [BT-1104]\n"
    )
    assert cli.refused("new other").endswith(expected)
    assert not Path("other").exists()
    cli("new other")
    cli("new third --yes")
    assert Path("other").is_dir()
    assert Path("third").is_dir()
