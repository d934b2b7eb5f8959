"""Options that contradict each other are refused, with a message that follows from their rules."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest

from bt_mission.cli.commands import load_commands
from bt_mission.cli.completion import KINDS
from bt_mission.cli.main import main, make_parser
from bt_mission.cli.parser import Option, Parser
from bt_mission.core.files import FileKind

FILES = {
    "m.yaml": "mission: m\nworld: empty_arena\ntree: {wait: 0.1}\n",
    "s.scenario.yaml": "scenario: s\nmission: m.yaml\n",
    "r.yaml": 'requirements:\n  is slow: "always speed < 1"\n',
    "f.fleet.yaml": "fleet: two\nworld: empty_arena\nrobots:\n"
    "  a: {mission: m.yaml, start: {x: 0, y: 0}}\n  b: {mission: m.yaml, start: {x: 1, y: 0}}\n",
    "t.jsonl": '{"trace_version": 3}\n',
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a file of each kind."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        # What an option needs.
        ("run m.yaml --port 1", "--port goes with --web"),
        ("watch --open", "--open goes with --web"),
        ("serve --read-only", "--read-only goes with --web"),
        ("replay x.mcap --host 127.0.0.1", "--host goes with --web"),
        ("run m.yaml --foxglove-port 1", "--foxglove-port goes with --foxglove"),
        (
            "run m.yaml --record-camera",
            "--record-camera goes with --record FILE.mcap or --report FILE.html",
        ),
        ("run m.yaml --record-raw-actions", "--record-raw-actions goes with --record FILE.mcap"),
        ("run m.yaml --attach --resume", "--resume goes with --journal FILE"),
        ("run m.yaml --journal j", "--journal goes with --attach: a simulation ends with"),
        ("run m.yaml --wall-clock", "--wall-clock goes with --attach: a simulation has a clock"),
        ("run m.yaml --namespace x", "--namespace goes with --attach: it names a robot of a"),
        ("run m.yaml --network", "--network goes with --attach or --visible: no other process"),
        ("run m.yaml --allow-duplicates", "--allow-duplicates goes with --attach: a simulation"),
        ("fork x.mcap --at 1 --tries 3", "--tries goes with --sweep-at"),
        ("fork x.mcap --sweep-at", "--sweep-at goes with --set NAME=VALUE or --mission FILE: name"),
        ("sweep m.yaml --retry-errors", "--retry-errors goes with --resume"),
        # What it excludes.
        ("run m.yaml --tui --json", "--json and --tui: choose one of them"),
        ("run m.yaml --tui --plain", "--plain and --tui: choose one of them"),
        ("run m.yaml --web --tui", "--tui and --web: choose one of them"),
        ("run m.yaml --attach --speed 2", "--speed does not go with --attach: an attached run has"),
        ("run m.yaml --attach --world x", "--world does not go with --attach: an attached run has"),
        ("run m.yaml --attach --robot x", "--robot does not go with --attach: an attached run has"),
        ("run m.yaml --attach --nature mild", "--nature does not go with --attach: an attached"),
        ("run m.yaml --attach --visible", "--visible does not go with --attach: an attached run"),
        ("run m.yaml --attach --view", "--view does not go with --attach: it shows a simulation"),
        ("run m.yaml --attach --video x.mp4", "--video does not go with --attach: it shows a"),
        ("run m.yaml --attach --fault 'at 1: drop scan'", "--fault does not go with --attach: "),
        ("watch --once --json", "--once and --json: choose one of them"),
        ("watch --json --plain", "--json and --plain: choose one of them"),
        ("watch --web --once", "--once and --web: choose one of them"),
        ("watch --foxglove robot1", "EXECUTIVE and --foxglove: choose one of them"),
        ("watch --foxglove --wait 1", "--wait and --foxglove: choose one of them"),
        ("replay x.mcap --web --plain", "--plain and --web: choose one of them"),
        ("topics echo /x --once --count 2", "--once and --count: choose one of them"),
        ("sim --robot waffle --robots a=burger@0,0,0", "--robot and --robots: choose one of them"),
        ("fork x.mcap --at 1 --sweep-at --set a=1", "--at and --sweep-at: choose one of them"),
        (
            "fork x.mcap --sweep-at --set a=1 --fault 'at 3: drop scan'",
            "--sweep-at does not go with --fault: a fault has an instant of its own; use --set",
        ),
        ("falsify m.yaml --cover --find failed", "--find does not go with --cover: it lists what"),
        ("falsify m.yaml --cover -o x", "--output does not go with --cover: it lists what"),
        ("falsify m.yaml --cover --reference x", "--reference does not go with --cover: it lists"),
        ("falsify m.yaml --cover --keep-going 2", "--keep-going does not go with --cover: "),
        ("sweep m.yaml --scheduler a --workers 2", "--workers does not go with --scheduler: "),
        ("sweep-report . --scenario 3 --json", "--json and --scenario: choose one of them"),
        # The kinds of file to which it does not apply.
        ("run s.scenario.yaml --attach", "--attach does not apply to scenario files: a scenario"),
        ("run f.fleet.yaml --attach", "--attach does not apply to fleet files: a fleet has its"),
        ("run f.fleet.yaml --robot burger", "--robot does not apply to fleet files: write it into"),
        ("run f.fleet.yaml --video x.mp4", "--video does not apply to fleet files: videos are"),
        ("check f.fleet.yaml --robot x", "--robot does not apply to fleet files: write it into"),
        ("check s.scenario.yaml --against", "--against does not apply to scenario files: only"),
        ("check r.yaml --against", "--against does not apply to requirements files: only"),
        (
            "replay t.jsonl --once",
            "--once does not apply to trace files: they have no tree; take a",
        ),
        ("replay t.jsonl --web", "--web does not apply to trace files: they have no tree; take a"),
        # What its file may be called.
        ("run m.yaml --record x.txt", "--record: recordings are MCAP files, call it x.mcap"),
        ("run m.yaml --report x.txt", "--report: a report is a page of HTML, call it x.html"),
        ("run m.yaml --video x.avi", "--video: videos are MP4 files, call it x.mp4"),
    ],
)
def test_a_contradiction_is_refused(
    line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything starts, with both options and the reason."""
    assert main(shlex.split(line)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert message in said.err


@pytest.mark.parametrize(
    ("command", "lines"),
    [
        (
            ["run"],
            [
                "--port N with --web: listen on this port",
                "--resume with --journal: continue where a mission was",
                "--record-camera [{compressed,raw}] with --record or --report: the camera's",
                "as fast as it goes) (not with --attach)",
            ],
        ),
        (["watch"], ["one JSON object a line (not with --once)", "--web, EXECUTIVE, --wait)"]),
        (["check"], ["--network find processes"]),
    ],
)
def test_help_names_what_an_option_needs_and_excludes(
    command: list[str],
    lines: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of the options that the command has."""
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit):
        main([*command, "--help"])
    said = " ".join(capsys.readouterr().out.split())
    for line in lines:
        assert line in said


def _declared(action: argparse.Action) -> Iterator[tuple[Parser, Option]]:
    """Yield all options of the commands below an argument, each with the parser that has it."""
    if isinstance(action.choices, dict):
        for parser in action.choices.values():
            yield from ((parser, option) for option in parser.options)
            for inner in parser._actions:
                yield from _declared(inner)


def test_rules_name_options_kinds_and_names_that_exist() -> None:
    """A rule with a wrong name would never apply."""
    declared = list(_declared(load_commands(make_parser())))
    assert len(declared) > 250
    known = {option.attribute for _, option in declared}
    kinds = {*get_args(FileKind), "trace"}
    for _, option in declared:
        assert {*option.needs, *option.excludes} <= known, option.form
        assert {*option.not_for} <= kinds, option.form
        assert option.completes in {"", "folders", *KINDS}, option.form


def test_an_option_that_needs_another_is_in_commands_that_have_it() -> None:
    """Else nobody could give it, or its rule would not hold there."""
    for parser, option in _declared(load_commands(make_parser())):
        names = {one.attribute for one in parser.options}
        assert not option.needs or names & {*option.needs}, (parser.prog, option.form)
