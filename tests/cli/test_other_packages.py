"""The package of somebody else brings a command, through an entry point."""

from __future__ import annotations

import re
import string
import sys
from collections.abc import Iterator

import pytest

from bt_mission.base import commands
from bt_mission.base.error_catalogue import catalogue
from bt_mission.views.manual import manual
from tests.support.command_line import CommandLine

ROW = """\
from bt_mission.base.commands import CommandRow, FileFormat

ROW = CommandRow(
    "hello",
    "greet whoever a file names",
    "greetings.command",
    ("hello",),
    ways={"greeting": "`bt-mission hello {}`"},
    kinds={
        "greeting": FileFormat(
            "a greeting",
            keys=frozenset(("greet",)),
            check="greetings.command:check",
            schema="greetings.command:schema",
        )
    },
)
"""
COMMAND = """\
from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read
from bt_mission.cli.argument_types import input_file
from bt_mission.cli.parser import Command, Option
from bt_mission.sessions.file_checks import CheckedFile


def check(path, _robot=None, _world=None):
    document = read(path)
    if not isinstance(document.data["greet"], str):
        raise InputError([document.diagnostic("BT-9901", ("greet",), "expected a name")])
    return CheckedFile(str(path), document.data["greet"], "one name"), ()


def schema():
    return {"title": "greeting"}


def hello(options):
    print(f"hello, {check(options.file)[0].name}")
    return 0


COMMANDS = {
    "hello": Command(hello, "Greets.", (Option("file", "whom", input_file, takes=("greeting",)),))
}
"""
ERRORS = """\
[groups]
99 = "Greetings"

[BT-9901]
title = "Nobody to greet"
cause = "A greeting names nobody."
cure = "Write a name."
wrong = "greet: 1"
right = "greet: world"
line = 1
"""
PAGE = "# Hello\n\nGreets whoever a file names.\n"


def forget() -> None:
    """Look for packages again."""
    for cached in (commands._others, commands.all_rows, catalogue):
        cached.cache_clear()


@pytest.fixture
def _greetings(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    """An installed package with the command `hello`, and one that is broken."""
    site = tmp_path_factory.mktemp("site")
    files = {
        "greetings/__init__.py": ROW,
        "greetings/command.py": COMMAND,
        "greetings/errors.toml": ERRORS,
        "greetings/hello.md": PAGE,
        "torn/__init__.py": ROW.replace("hello", "torn").replace("greetings", "torn"),
        "torn/errors.toml": "[BT-9902",
        "greetings-1.dist-info/METADATA": "Name: greetings\nVersion: 1\n",
        "greetings-1.dist-info/entry_points.txt": (
            "[bt_mission.commands]\nhello = greetings:ROW\nlost = greetings:LOST\n"
            "odd = json:dumps\ntorn = torn:ROW\n"
        ),
    }
    for name, text in files.items():
        (site / name).parent.mkdir(exist_ok=True)
        (site / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(site)
    monkeypatch.delitem(sys.modules, "bt_mission.commands.schema", raising=False)
    forget()
    yield
    forget()


@pytest.mark.usefixtures("_greetings")
def test_a_package_brings_a_command(cli: CommandLine) -> None:
    """Its help, its kind of file with check and schema, its error and its page."""
    good, bad = cli.write("good.yaml", "greet: world\n"), cli.write("bad.yaml", "greet: 1\n")
    assert re.search(r"^    hello +greet whoever a file names$", cli("--help"), re.MULTILINE)
    assert cli(f"hello {good}") == "hello, world\n"
    assert cli(f"check {good}") == f"{good}: greeting 'world' is valid (one name)\n"
    assert cli.call(f"check {bad}") == 2
    assert "bad.yaml:1:8: error: expected a name [BT-9901]" in cli.err
    assert cli.call(f"run {good}") == 2
    assert "is a greeting; expected a mission, a scenario or a fleet; " in cli.err
    assert f"use `bt-mission hello {good}` [BT-111]" in cli.err
    assert cli("explain 9901").startswith("BT-9901: Nobody to greet")
    assert "greeting" in cli("schema greeting")
    assert "Greets whoever a file names." in manual().page("hello").sections[0].text


@pytest.mark.thorough
@pytest.mark.usefixtures("_greetings")
def test_a_broken_row_is_reported(cli: CommandLine) -> None:
    """The rest works, and `doctor` says what is wrong."""
    cli.call("doctor")
    assert "greetings:LOST: AttributeError" in cli.out
    assert "json:dumps: expected a CommandRow, got function" in cli.out
    assert "torn/errors.toml: TOMLDecodeError: " in cli.out
    assert "of other packages: hello" in cli.out


def test_what_commands_add_exists() -> None:
    """A misspelled point, or a name that is not there, would add nothing."""
    known = {point.rstrip(string.ascii_uppercase).rstrip(".") for point in commands.POINTS}
    for row in commands.ROWS:
        for point, target in row.adds.items():
            assert point.partition(".")[0] in known, (row.name, point)
            assert commands.loaded(target) is not None
        assert {commands.row_of(name).name for name in row.needs} == {*row.needs}
