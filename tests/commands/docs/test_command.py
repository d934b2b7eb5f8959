"""`bt-mission docs`: the list, a page, a section, a search; in a pipe and on a terminal."""

from __future__ import annotations

import argparse
import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_mission.base.commands import ROWS
from bt_mission.cli.main import make_parser
from bt_mission.cli.parser import Parser
from bt_mission.cli.subparsers import load_commands
from bt_mission.views.manual import Manual
from tests.support.command_line import CommandLine
from tests.support.installed import run_in
from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

INDEX = """\
# Pages

All.

## Tutorials: learn

| | |
|---|---|
| [First steps](tutorials/first.md) | from nothing to a `run` |
| [Rules](tutorials/rules.md) | write a rule |

## Reference: look up

| | |
|---|---|
| [Rules](reference/rules.md) | every [rule](x.md) |
"""
FIRST = """\
# First steps

This page starts. See [rules](../reference/rules.md#of-the-road) and
[the list](../reference/rules.md), [a site](https://example.com) or [a file](../../a.yaml).

![a robot](../images/robot.png)

## Install `it`

```bash
# Not a heading
pip install it   # [no](link.md)
```

### On Debian

Brake with `set_brake`.

## Drive

Go.

## Drive

Again.
"""
PAGES_OF_TEST = {
    "README.md": INDEX,
    "tutorials/first.md": FIRST,
    "tutorials/rules.md": "# Write a rule\n\nDo it.\n",
    "reference/rules.md": "# Rules\n\nAll rules.\n\n## Of the road\n\nKeep braking distance.\n",
}


@pytest.fixture
def docs(cli: CommandLine, monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """A command line with a few pages only."""
    for name, text in PAGES_OF_TEST.items():
        cli.write(f"share/bt_mission/docs/{name}", text)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(cli.folder))
    monkeypatch.setattr("bt_mission.base.files._IS_INSTALLED", True)
    return cli


def test_the_list_has_every_page_with_its_name(docs: CommandLine) -> None:
    """In the order of the index; two pages with one name have their folders."""
    assert docs("docs") == (
        "Tutorials: learn\n"
        "  first            from nothing to a run\n"
        "  tutorials/rules  write a rule\n"
        "\n"
        "Reference: look up\n"
        "  reference/rules  every rule\n"
        "\n"
        "bt-mission docs PAGE shows a page, bt-mission docs WORDS searches\n"
    )


@pytest.mark.parametrize(
    "name", ["first", "first.md", "tutorials/first", "docs/tutorials/first.md"]
)
def test_a_page_is_shown_by_its_name(docs: CommandLine, name: str) -> None:
    """In a pipe as it is written."""
    assert docs(f"docs {name}") == FIRST


def test_a_section_is_shown_with_those_below_it(docs: CommandLine) -> None:
    """Its anchor is that of GitHub."""
    text = docs("docs first#install-it")
    assert text == FIRST[FIRST.index("## Install") : FIRST.index("\n## Drive")]
    assert docs("docs first#drive-1") == "## Drive\n\nAgain.\n"


def test_a_search_shows_the_best_section_and_names_others(docs: CommandLine) -> None:
    """The endings of words do not count, nor does their case."""
    assert docs("docs Brake") == (
        "### On Debian\n"
        "\n"
        "Brake with `set_brake`.\n"
        "\n"
        "Also found in:\n"
        "  bt-mission docs first#on-debian              First steps > Install it > On Debian\n"
        "  bt-mission docs reference/rules#of-the-road  Rules > Of the road\n"
    )


def test_a_name_of_two_pages_finds_both_first(docs: CommandLine) -> None:
    """Each can be shown by the name with its folder."""
    result = docs("docs rules").partition("Also found in:\n")[2].splitlines()
    assert {line.split()[2] for line in result[:2]} == {"reference/rules", "tutorials/rules"}


def test_a_word_may_be_the_beginning_of_one(docs: CommandLine) -> None:
    """Where no page has the word itself."""
    assert docs("docs distan").startswith("## Of the road\n")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            "debain",
            "no page has 'debain'; did you mean 'debian'? (bt-mission docs lists all pages)",
        ),
        ("'fly me'", "no page has 'fly me' (bt-mission docs lists all pages)"),
        ("'\"*'", "no page has '\"*' (bt-mission docs lists all pages)"),
        ("first#drvie", "the page first has no section 'drvie'; did you mean 'drive'?"),
        (
            "tutorials/rules#zzz",
            "the page tutorials/rules has no section 'zzz'; sections: none",
        ),
    ],
)
def test_what_is_not_there_exits_with_1_and_a_hint(
    docs: CommandLine, words: str, expected: str
) -> None:
    """Nothing goes to standard output."""
    assert docs(f"docs {words}", 1) == ""
    assert docs.err == f"{expected}\n"


def test_a_page_that_is_listed_and_not_there_is_an_error(docs: CommandLine) -> None:
    """As is an installation without pages."""
    share = docs.folder / "share" / "bt_mission" / "docs"
    (share / "tutorials" / "first.md").unlink()
    assert docs.refused("docs first") == (
        f"cannot read {share / 'tutorials' / 'first.md'}: No such file or directory [BT-101]\n"
    )


def test_without_pages_the_installation_is_doubted(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder of the same name beside the package is not taken for them."""
    monkeypatch.setattr("bt_mission.views.manual.docs_folder", lambda: None)
    assert cli.refused("docs") == "no pages found: is the installation complete? [BT-101]\n"


PROGRAM = """\
import sys
from bt_mission.base import files
files._IS_INSTALLED = True  # the pages are those of the test
from bt_mission.__main__ import main
sys.exit(main())
"""


def on_terminal(docs: CommandLine, *words: str, **environment: str) -> str:
    """What the command shows on a terminal with 10 lines of 80 columns."""
    main, side = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "docs", *words],
        stdin=side,
        stdout=side,
        stderr=side,
        cwd=docs.folder,
        env=os.environ | {"COLUMNS": "80", "LINES": "10", "TERM": "xterm"} | environment,
    )
    os.close(side)
    written = b""
    while True:
        try:
            written += os.read(main, 65536)
        except OSError:  # as Linux says that the other side is closed
            break
    os.close(main)
    assert process.wait(PATIENCE_S) == 0
    return written.decode().replace("\r\n", "\n")


@pytest.mark.process
def test_a_terminal_shows_formatted_text(docs: CommandLine) -> None:
    """Links name pages as the command takes them; code stays as it is."""
    text = re.sub(r"\x1b\[[\d;]*m", "", on_terminal(docs, "first", PAGER="cat"))
    assert [" ".join(line.split()) for line in text.splitlines() if line.strip()] == [
        "First steps",
        "This page starts. See rules (reference/rules#of-the-road) and the list",
        "(reference/rules), a site (https://example.com) or a file.",
        "Picture: a robot",
        "Install it",
        "# Not a heading",
        "pip install it # [no](link.md)",
        "On Debian",
        "Brake with set_brake.",
        "Drive",
        "Go.",
        "Drive",
        "Again.",
    ]


@pytest.mark.process
def test_a_long_text_goes_to_the_pager(docs: CommandLine) -> None:
    """A short one does not; without the pager the text is printed."""
    pager = "sed 's/^/| /'"
    long = on_terminal(docs, "first", PAGER=pager).splitlines()
    assert len(long) > 10
    assert all(line.startswith("| ") for line in long)
    assert "| " not in on_terminal(docs, "first#drive", PAGER=pager)
    assert "Again." in on_terminal(docs, "first", PAGER="/nosuch/pager")


@pytest.mark.process
def test_ctrl_c_is_for_the_pager(docs: CommandLine) -> None:
    """The command ends with it, as usual."""
    pager = "sh -c 'kill -INT $PPID; sed \"s/^/| /\"'"
    assert "| " in on_terminal(docs, "first", PAGER=pager)


@pytest.mark.process
def test_a_terminal_without_colours_gets_none(docs: CommandLine) -> None:
    """NO_COLOR leaves weights; a terminal that can do nothing has neither, and no pager."""
    colours = r"\x1b\[[\d;]*3\dm"
    assert re.search(colours, on_terminal(docs, "first", PAGER="cat"))
    assert not re.search(colours, on_terminal(docs, "first", PAGER="cat", NO_COLOR="1"))
    assert "\x1b" not in on_terminal(docs, "first", PAGER="false", TERM="dumb")


@pytest.mark.process
def test_a_reader_that_leaves_is_no_traceback() -> None:
    """Such as `head`."""
    line = f"{sys.executable} -m bt_mission docs files | head -1"
    done = subprocess.run(
        ["/bin/bash", "-c", line],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert (done.stdout, done.stderr) == ("# Keys of files\n", "")


def _parsers(action: argparse.Action) -> Iterator[Parser]:
    if isinstance(action.choices, dict):
        for parser in action.choices.values():
            yield parser
            for inner in parser._actions:
                yield from _parsers(inner)


def test_help_names_pages_that_exist() -> None:
    """Of every command, of options, and in what commands print."""
    names = set(Manual(ROOT / "docs").names)
    assert [row.name for row in ROWS if not row.pages] == ["docs"]
    assert {page for row in ROWS for page in row.pages} <= names
    parsers = list(_parsers(load_commands(make_parser())))
    pages = {option.page for parser in parsers for option in parser.options} - {""}
    assert {"scenarios", "recording"} <= pages <= names
    texts = [parser.format_help() for parser in parsers if not parser.prog.endswith(" docs")]
    files = ROOT.glob("bt_mission/commands/*/*.py")
    printed = [path.read_text("utf-8") for path in files if path.parent.name != "docs"]
    named = set(re.findall(r"bt-mission docs ([a-z][\w/-]*)", "\n".join([*texts, *printed])))
    assert named <= names
    assert not [text for text in texts if "docs/" in re.sub(r"docs [\w/-]+", "", text)]


def test_the_help_of_a_command_ends_with_its_pages(cli: CommandLine) -> None:
    """The commands below it have the same."""
    ending = ["read more:", "  bt-mission docs own-project", "  bt-mission docs mission-language"]
    assert cli.lines("missions --help")[-3:] == ending
    assert cli.lines("missions copy --help")[-3:] == ending


@pytest.mark.process
def test_an_installation_shows_its_pages_in_an_empty_folder(
    installed: Path, tmp_path: Path
) -> None:
    """Those of the wheel."""
    output = run_in(installed, tmp_path, "bt-mission", "docs", "two", "robots")
    assert output.startswith("# Run a fleet\n")
