"""Where text goes out: no other way than through the borders, and none of them can be forgotten."""

from __future__ import annotations

import argparse
import ast
import io
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.impl.rcutils_logger import RcutilsLogger

from bt_mission.base.ros_log import EscapingLogger
from bt_mission.base.text import escape_control, escape_lines
from bt_mission.cli.main import main, make_parser
from bt_mission.cli.subparsers import load_commands
from bt_mission.commands.doctor import CheckResult, DoctorCheck, report_on
from bt_mission.views.terminal.console import EscapingConsole
from bt_mission.views.terminal.streams import escaped_output, unescaped
from tests.support.command_cases import cases
from tests.support.hostile import ATTACKS, HOSTILE, MARK, escape_nothing, filled, leaks
from tests.support.project import ROOT
from tools import check_layers

KNOWN = check_layers.modules()

BORDERS = {
    "rich.console.Console": "bt_mission.views.terminal.console",
    "rich.get_console": "",
    "rich.text.Text.from_ansi": "bt_mission.views.terminal.console",
    "rich.text.Text.from_markup": "",
    "textual.app.App": "bt_mission.views.terminal.screen",
    "html.escape": "bt_mission.base.text",
    "xml.sax.saxutils": "",
    "sys.__stdout__": "bt_mission.programs.signals",  # of pdb, in the program of a user
    "sys.__stderr__": "",
    "*.get_logger": "bt_mission.base.ros_log",
    "unicodedata.category": "bt_mission.base.text",
}
"""What writes, or escapes, in a way of its own, and the one module that may use it."""

TYPES_ONLY = (
    "bt_mission.commands.doctor",
    "bt_mission.views.terminal.live_view",
    *cases("TAKE_A_CONSOLE"),
)
"""Modules that take a console, and make none: they import its class for annotations."""


def dotted_names(text: str) -> Iterator[str]:
    """Each dotted name that is read, with local names replaced by what they were imported as."""
    tree = ast.parse(text)
    bound: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            bound |= {alias.asname: alias.name for alias in node.names if alias.asname}
        elif isinstance(node, ast.ImportFrom) and node.module:
            bound |= {
                imported.asname or imported.name: f"{node.module}.{imported.name}"
                for imported in node.names
            }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            first, dot, rest = ast.unparse(node).partition(".")
            yield bound.get(first, first) + dot + rest
    yield from (name for name, _ in check_layers.imported_names(tree))


def strays(module: str, text: str) -> list[str]:
    """Name what a module uses past the borders."""
    results = []
    for name in set(dotted_names(text)):
        for border, owner in BORDERS.items():
            is_it = name.endswith(border[1:]) if border[0] == "*" else name.startswith(border)
            if is_it and module != owner and not (border in name and module in TYPES_ONLY):
                results.append(f"{module}: {name}; use {owner or 'print'}")
    return results


def test_text_goes_out_through_the_borders_only():
    """Consoles, applications, loggers and markup are made in one place each."""
    words = {border.rpartition(".")[2] for border in BORDERS}
    sources = {name: path.read_text(encoding="utf-8") for name, path in KNOWN.items()}
    suspects = {name: text for name, text in sources.items() if any(word in text for word in words)}
    assert [line for name, text in suspects.items() for line in strays(name, text)] == []


@pytest.mark.parametrize(
    "text",
    [
        "from rich.console import Console\nConsole().print(1)\n",
        "import html\nhtml.escape('a')\n",
        "from html import escape\n",
        "def f(node):\n    node.get_logger().info('a')\n",
        "import sys\nprint(1, file=sys.__stderr__)\n",
        "from textual.app import App\nclass A(App): ...\n",
    ],
)
def test_a_way_past_them_is_found(text):
    """Each of these would be a hole."""
    assert strays("bt_mission.views.new", text)


# ---- the function ----------------------------------------------------------------------------


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=ATTACKS)
def test_attacks_are_escaped_once(attack):
    """A text stays as it is when it is escaped again, so that two borders do no harm."""
    shown = escape_control(attack)
    assert leaks(shown) == []
    assert escape_control(shown) == shown
    assert leaks(escape_lines(attack).replace("\nFORGED", "")) == []


@pytest.mark.parametrize("text", ["", "größer 走 ✓", "e\u0301 \u00a0\u3000x", "⚠\ufe0f", "a\\nb"])
def test_other_texts_stay_as_they_are(text):
    """Letters of any script, accents, blanks, signs."""
    assert escape_control(text) == escape_lines(text) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\tb\r\n", "a\\tb\\r\\n"),
        ("\x1b\x9b\x7f", "\\x1b\\x9b\\x7f"),
        ("\u202e\u2028", "\\u202e\\u2028"),
        ("\U000e0041", "\\U000e0041"),
        ("\udc80", "\\udc80"),
    ],
)
def test_escapes_are_those_of_python(text, shown):
    """So that one can be looked up, or pasted."""
    assert escape_control(text) == shown


def test_every_code_point_is_judged_as_by_the_test():
    """Beyond the attacks: none of those that mean anything; planes 4 to 13 are empty."""
    everything = "".join(map(chr, (*range(0x40000), *range(0xE0000, 0xE1000))))
    assert leaks(escape_control(everything)) == []


# ---- the borders -----------------------------------------------------------------------------


def test_standard_output_and_error_are_escaped(capfdbinary):
    """Whatever is printed, by whomever; bytes and the stream for libraries stay as they are."""
    with escaped_output():
        sys.stdout.write(HOSTILE)
        sys.stderr.write(HOSTILE)
        sys.stdout.writelines([HOSTILE])
        during = sys.stdout
    assert unescaped(during) is sys.stdout
    assert during.encoding == sys.stdout.encoding
    written = capfdbinary.readouterr()
    assert leaks((written.out + written.err).decode().replace("\nFORGED", "")) == []


def test_logs_of_ros_are_escaped(capfd):
    """On the terminal and on /rosout, from every level; a child's, too."""
    log = EscapingLogger(RcutilsLogger("test_escaping")).get_child("part")
    log.info(HOSTILE)
    log.warning(HOSTILE)
    log.error(HOSTILE)
    written = capfd.readouterr()
    lines = (written.out + written.err).splitlines()
    assert sum(MARK in line for line in lines) == 3
    assert leaks("\n".join(lines).replace("\nFORGED", "")) == []


def test_two_calls_of_a_log_are_throttled_apart(capfd):
    """Rclpy tells calls apart by their place, which is that of the caller."""
    log = EscapingLogger(RcutilsLogger("test_throttling"))
    for _ in range(3):
        log.warning("first", throttle_duration_sec=60.0)
        log.warning("second", throttle_duration_sec=60.0)
    written = capfd.readouterr()
    assert (written.out + written.err).count("first") == 1
    assert (written.out + written.err).count("second") == 1


def test_the_doctor(monkeypatch):
    """What it finds is said by other programs and by the environment."""
    stream = io.StringIO()
    checks = [DoctorCheck(HOSTILE, lambda: filled(CheckResult))]
    report_on(EscapingConsole(stream, width=5000), checks)
    shown = stream.getvalue()
    assert shown.count(MARK) == 3
    assert leaks(shown.replace("\nFORGED", "")) == []


def test_names_for_completion(tmp_path, monkeypatch, capsys):
    """Bash expands what it is given: a name that is more than a word is not offered."""
    (tmp_path / "missions").mkdir()
    for name in ("good-1", "a b", "$(touch owned)", "`id`", "x;y", "a\x1b[2Jb", "q'", "\u202eb"):
        (tmp_path / "missions" / f"{name}.yaml").touch()
    monkeypatch.chdir(tmp_path)
    assert main(["completion", "--names", "missions"]) == 0
    offered = capsys.readouterr().out.split("\n")
    assert "good-1" in offered
    assert not [name for name in offered if set(name) & set(" $`;'\x1b\u202e")]


# ---- every argument of every command ---------------------------------------------------------


def arguments(parser: argparse.ArgumentParser, words: tuple[str, ...] = ()) -> Iterator[Any]:
    """Each option and each word of each command, with a hostile value."""
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for name, inner in action.choices.items():
                yield from arguments(inner, (*words, name))
        elif action.nargs != 0:
            yield [*words, *action.option_strings[-1:], HOSTILE.replace("\0", "")]
    yield [*words, "--" + HOSTILE]


PARSER = make_parser()
load_commands(PARSER)
EVERY = list(arguments(PARSER))


def refused(words: list[str]) -> int:
    """Parse words as the command line does, and no more."""
    with escaped_output():
        try:
            options, rest = PARSER.parse_known_args(words)
            if rest:
                options.parser.refuse(rest)
        except SystemExit:
            return 1
    return 0


def test_arguments_of_commands(capsys):
    """What is said of one that is refused: choices, numbers, unknown options."""
    assert len(EVERY) > 80
    assert sum(map(refused, EVERY)) > 40
    shown = capsys.readouterr()
    assert MARK in shown.err
    assert leaks(shown.out + shown.err) == []


FILES = ("run", "check", "tree", "replay", "report", "diff", *cases("FILES_THAT_ARE_NOT_THERE"))


@pytest.mark.parametrize("command", FILES)
def test_names_of_files_that_are_not_there(command, capsys, tmp_path, monkeypatch):
    """Refused with the name, in one line."""
    monkeypatch.chdir(tmp_path)
    name = HOSTILE.replace("\0", "").replace("/", "").replace("\n", "")[:120]
    main([command, name, *([name] if command == "diff" else [])])
    shown = capsys.readouterr()
    assert MARK in shown.err
    assert leaks(shown.out + shown.err) == []


def test_the_command_line_can_leak(capsys, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    main(["check", HOSTILE.replace("\0", "")])
    assert leaks(capsys.readouterr().err)


def test_the_walk_covers_the_checkout():
    """The modules that are looked at are those of the product."""
    assert {Path(path).relative_to(ROOT).parts[0] for path in KNOWN.values()} >= {
        "bt_mission",
        "action_servers",
        "sim",
    }
