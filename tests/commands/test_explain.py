"""The catalogue of errors: every example has its mistake, and no code is missing or unused."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from bt_mission.base.error_catalogue import GROUPS, PROMPT, CatalogueEntry, catalogue
from sim.views.window import DISPLAYS
from tests.support.command_line import CommandLine
from tests.support.thorough import sample

ROOT = Path(__file__).resolve().parents[2]
ENTRIES = list(catalogue().values())
FILES = [entry for entry in ENTRIES if entry.wrong and not entry.is_command]
CALLS = [entry for entry in ENTRIES if entry.is_command]
WITHOUT_EXAMPLE = {
    *("BT-902", "BT-904"),  # of a middleware that is not installed, of tests in Python
    *("BT-711", "BT-713", "BT-807", "BT-809", "BT-810"),
    # Where the commands of their examples are taken away.
    *("BT-708", "BT-712", "BT-901", "BT-1204"),
    *(
        "BT-908",
        "BT-909",
        "BT-912",
        "BT-914",
        "BT-915",
        "BT-916",
        "BT-917",
    ),  # of other processes of a graph
    *("BT-919", "BT-920"),  # of servers whose code would be long
    "BT-1104",  # of a terminal
    *("BT-1301", "BT-1302", "BT-1303"),  # of the page of the editor
    *(f"BT-{number}" for number in range(1401, 1411)),  # of sites, agents and approvers
}
"""Codes whose examples would be longer than an explanation; tests of their rooms raise them."""


WARNINGS = {"BT-511", "BT-814"}
"""Codes of warnings, with which a command succeeds."""

TAKE_A_CODE = {"ExpressionError", "HintedError", "InputError"}
"""Errors whose first argument is a code, or whose diagnostics have codes."""


def write(folder: Path, entry: CatalogueEntry, content: str) -> None:
    """Write an example and the files beside it."""
    for name, text in {**entry.beside, entry.file: content}.items():
        (folder / name).write_text(text.removeprefix("\n"), encoding="utf-8")


def checked(cli: CommandLine, entry: CatalogueEntry, content: str) -> list[tuple[int, str, str]]:
    """Return line, code and severity of every diagnostic of an example."""
    write(cli.folder, entry, content)
    cli.call(f"check --json {entry.file}")
    diagnostics = json.loads(cli.out)
    return [(each["line"], each["code"], each["severity"]) for each in diagnostics]


@pytest.mark.parametrize("entry", sample(FILES, 4), ids=lambda entry: entry.code)
def test_an_example_has_its_mistake_and_no_other(cli: CommandLine, entry: CatalogueEntry) -> None:
    """At its line; the corrected example has no error and no warning of this code."""
    diagnostics = checked(cli, entry, entry.wrong)
    assert [(line, code) for line, code, _ in diagnostics if code == entry.code] == [
        (entry.line, entry.code)
    ], diagnostics
    assert {code for _, code, severity in diagnostics if severity == "error"} <= {entry.code}
    assert checked(cli, entry, entry.right) == []


def without_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the import of ROS types fail."""
    monkeypatch.setitem(sys.modules, "bt_mission.ros.interface_types", None)


def without_web(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the command need a package that is not installed."""
    monkeypatch.setattr("bt_mission.cli.web.NEEDED", ("absent_package",))


def without_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """Remove the variables that name a display."""
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)


MACHINES: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "BT-511": without_ros,
    "BT-905": without_web,
    "BT-907": without_display,
}
"""The state of the machine on which the command of a code is wrong."""


def call_all(cli: CommandLine, example: str) -> int:
    """Run the commands of an example, as a shell does; return the exit code of the last."""
    code = 0
    for line in example.strip().splitlines():
        words = shlex.split(line.removeprefix(PROMPT))
        with pytest.MonkeyPatch.context() as environment:
            while "=" in words[0]:
                environment.setenv(*words.pop(0).split("=", 1))
            if words[0] == "bt-mission":
                code = cli.call(shlex.join(words[1:]))
            else:
                code = subprocess.run(words, cwd=cli.folder, check=True).returncode
    return code


@pytest.mark.parametrize("entry", sample(CALLS, 18), ids=lambda entry: entry.code)
def test_a_command_is_refused_with_its_code(cli: CommandLine, entry: CatalogueEntry) -> None:
    """The corrected command succeeds."""
    for name, text in entry.beside.items():
        (cli.folder / name).write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as machine:
        MACHINES.get(entry.code, lambda _: None)(machine)
        code = call_all(cli, entry.wrong)
    assert f"[{entry.code}]" in cli.out + cli.err, cli.out + cli.err
    assert code or entry.code in WARNINGS
    assert call_all(cli, entry.right) == 0, cli.err


def uncoded_errors(text: str) -> list[str]:
    """Return the errors of a text without a code: classes, and direct uses of the root class."""
    tree, root = ast.parse(text), "BtMissionError"
    classes = [
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and root in map(ast.unparse, node.bases)
        and not any(
            isinstance(line, ast.Assign) and ast.unparse(line.targets[0]) == "code"
            for line in node.body
        )
    ]
    calls = [
        ast.unparse(node)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) == root
        and not any(keyword.arg == "code" for keyword in node.keywords)
    ]
    return sorted({*classes, *calls} - TAKE_A_CODE)


def test_every_error_has_a_code() -> None:
    """An error of a class without a code gets one where it is raised."""
    uncoded = {
        path.relative_to(ROOT).as_posix(): errors
        for package in ("bt_mission", "action_servers", "sim")
        for path in sorted((ROOT / package).rglob("*.py"))
        if "BtMissionError" in (text := path.read_text(encoding="utf-8"))
        and (errors := uncoded_errors(text))
    }
    assert uncoded == {}


def test_an_error_without_a_code_is_found() -> None:
    """Both forms are found."""
    text = "class LateError(BtMissionError):\n    pass\nraise BtMissionError('late')\n"
    assert uncoded_errors(text) == ["BtMissionError('late')", "LateError"]


def test_every_code_of_the_sources_is_in_the_catalogue_and_none_is_unused() -> None:
    """A new error touches the place that raises it, and the catalogue."""
    used = {
        code
        for package in ("bt_mission", "action_servers", "sim")
        for path in (ROOT / package).rglob("*.py")
        for code in re.findall(r'"(BT-[0-9]+)"', path.read_text(encoding="utf-8"))
    }
    assert used == set(catalogue())
    assert {entry.code for entry in ENTRIES if not entry.wrong} <= WITHOUT_EXAMPLE


def test_codes_are_in_order_and_texts_are_sentences() -> None:
    """Each is in a group, with a cause and a cure."""
    numbers = [int(entry.code.removeprefix("BT-")) for entry in ENTRIES]
    assert numbers == sorted(numbers)
    groups = {number // 100: entry.group for number, entry in zip(numbers, ENTRIES, strict=True)}
    assert GROUPS.items() <= groups.items()
    for entry in ENTRIES:
        assert entry.title[0].isupper()
        assert not entry.title.endswith(".")
        for text in (entry.cause, entry.cure):
            assert text[0].isupper() or text[0] == "`"
            assert text.endswith((".", "`."))


@pytest.mark.parametrize("code", ["BT-203", "bt-203", "203", "BT203"])
def test_a_code_is_explained_however_it_is_written(cli: CommandLine, code: str) -> None:
    """With title, cause, example, cure and the corrected example."""
    entry = catalogue()["BT-203"]
    out = cli(f"explain {code}")
    assert out.startswith(f"BT-203: {entry.title}\n")
    assert "    trun: {angle: 90}" not in entry.right
    assert "      trun: {angle: 90}\n" in out
    assert "      turn: {angle: 90}\n" in out


def test_without_a_code_all_are_listed(cli: CommandLine) -> None:
    """By groups, and as JSON."""
    out = cli("explain")
    assert all(f"  {entry.code:8} {entry.title}\n" in out for entry in ENTRIES)
    assert all(f"{group}\n" in out for group in GROUPS.values())
    listed = json.loads(cli("explain --json"))
    assert [each["code"] for each in listed] == list(catalogue())
    (entry,) = json.loads(cli("explain --json 203"))
    assert entry["title"] == catalogue()["BT-203"].title


def test_an_unknown_code_is_refused_with_the_nearest(cli: CommandLine) -> None:
    """Three of them."""
    cli("explain BT-999", 2)
    assert cli.err.count("BT-") >= 3


@pytest.mark.parametrize("words", ["xyzzy", "''"])
def test_words_that_no_error_is_about_are_refused(cli: CommandLine, words: str) -> None:
    """The message names the list of all codes."""
    cli(f"explain {words}", 2)
    assert "`bt-mission explain` lists all codes" in cli.err


def test_editors_get_the_code_and_a_link_to_its_explanation(cli: CommandLine) -> None:
    """The link leads to a heading of a page of errors."""
    cli.write("m.yaml", "mission: m\ntree: {trun: 1}\n")
    (diagnostic,) = json.loads(cli("check --json m.yaml", 2))
    assert diagnostic["code"] == "BT-203"
    page, _, anchor = diagnostic["url"].partition("#")
    assert anchor == "bt-203"
    text = Path(page.removeprefix("file://")).read_text(encoding="utf-8")
    assert "\n## BT-203\n" in text


def test_codes_are_completed(cli: CommandLine) -> None:
    """All of them."""
    assert cli.lines("completion --names codes") == list(catalogue())


def test_words_of_a_message_find_their_codes(cli: CommandLine) -> None:
    """The best first, with or without quotes; words that no error has are refused."""
    for words in ("'No such field'", "no such field"):
        out = cli(f"explain {words}")
        assert out.startswith("about 'n" if words[0] == "n" else "about 'N")
        assert out.splitlines()[1].split()[0] == "BT-502", out
    first, *_ = json.loads(cli("explain no such field --json"))
    assert first["code"] == "BT-502"
    assert cli.call("explain zzzz") == 2
    assert "no error is about 'zzzz'; `bt-mission explain` lists all codes" in cli.err
