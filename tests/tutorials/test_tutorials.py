"""docs/tutorials, and how to start a project: what they say to type gives what stands below."""

from __future__ import annotations

import contextlib
import re
import shlex
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from bt_mission.cli import main
from tests.support.project import ROOT

OWN_PROJECT = ROOT / "docs" / "how-to" / "own-project.md"
PAGES = [*sorted((ROOT / "docs" / "tutorials").glob("*.md")), OWN_PROJECT]
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
    code = ROOT / "docs" / "tutorials" / "code"
    assert shown == {f"code/{path.name}" for path in code.iterdir() if path.is_file()}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    """Within the project."""
    for target in re.findall(r"\]\((?!https:)([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target
