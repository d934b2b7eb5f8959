"""What shells complete, asked of the shells themselves."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from bt_mission.base.files import names
from bt_mission.cli.main import make_parser
from bt_mission.commands.completion import FILES, KINDS, SHELLS, known, script
from tests.support.command_cases import cases
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S

BASH = """\
source "$1"
shift
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_shtab_bt_mission
printf '%s\\n' "${COMPREPLY[@]}"
"""


def asked(program: list[str], folder: Path | None = None) -> list[str]:
    """What a shell prints, with our command in its path."""
    here = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        program,
        env=os.environ | here,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.stderr == ""
    return done.stdout.split("\n")[:-1]


@pytest.fixture(scope="module")
def bash(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[str]]:
    """What bash completes behind our command: ``bash("run", "pat")``."""
    path = tmp_path_factory.mktemp("completion") / "script"
    path.write_text(script(make_parser(), "bash"), encoding="utf-8")

    def complete(*words: str, folder: Path | None = None, lines: str = BASH) -> list[str]:
        return asked(["/bin/bash", "-c", lines, "bash", str(path), "bt-mission", *words], folder)

    return complete


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["ru"], ["run"]),
        (["run", "explore_f"], ["explore_fixed", "explore_frontiers"]),
        (["run", "scen"], sorted(name for name in known("runs") if name.startswith("scen"))),
        (["run", "patrol", "--world", "nav"], ["nav_arena"]),
        (["sim", "--robot", "b"], ["burger"]),
        (["tree", "patrol", "--format", "s"], ["svg"]),
        (["completion", "z"], ["zsh"]),
        (["run", "scenarios/ba"], ["scenarios/back_up.scenario.yaml"]),
        (["run", "square", "--set", "s"], ["side=", "speed="]),
        (["run", "--seed", "3", "sweep", "--set", "a"], ["angle="]),
        (["missions", "copy", "sources/wa"], ["sources/waypoint_tour.yaml"]),
        (["worlds", "copy", "nav"], ["nav_arena"]),
        *cases("COMPLETED"),
    ],
)
def test_bash_completes(
    bash: Callable[..., list[str]], words: list[str], expected: list[str]
) -> None:
    """Commands, options, choices, and the names of missions, worlds and robots."""
    assert bash(*words) == expected


@pytest.mark.process
def test_bash_leaves_room_for_a_value(bash: Callable[..., list[str]]) -> None:
    """After the name of an input there is no blank; `compopt` says so, where bash completes."""
    lines = BASH.replace("_shtab_bt_mission\n", "compopt() { echo $*; }\n_bt_mission_complete\n")
    assert bash("run", "square", "--set", "side", lines=lines) == ["-o nospace", "side="]
    assert bash("run", "square", "--set", "s", lines=lines) == ["side=", "speed="]


@pytest.mark.process
def test_bash_completes_files_of_ones_own(bash: Callable[..., list[str]], tmp_path: Path) -> None:
    """Missions have the suffixes of their formats; folders lead to more."""
    (tmp_path / "own").mkdir()
    for name in ("own/mine.yaml", "own/mine.xml", "own/mine.txt", "one.yml"):
        (tmp_path / name).touch()
    assert bash("check", "own/m", folder=tmp_path) == ["own/mine.yaml", *cases("COMPLETED_FILES")]
    assert sorted(bash("check", "o", folder=tmp_path)) == ["one.yml", "own"]


@pytest.mark.process(always=True)
def test_bash_is_given_no_word_that_it_would_expand_or_run(
    bash: Callable[..., list[str]], tmp_path: Path
) -> None:
    """Words go onto the line without quotes, and Enter runs the line."""
    (tmp_path / "own").mkdir()
    for name in (
        *("$(id)", "`id`", "a;id", "a|id", "a&id"),
        *("a>b", "!1", "'a", "\\a", "{a,b}", "\x1b]"),
    ):
        (tmp_path / "own" / f"{name}.yaml").touch()
    (tmp_path / "own" / "mine-1_2,ä=@+%.yaml").touch()
    lines = BASH.replace("_shtab_bt_mission\n", "_bt_mission_complete 2>/dev/null\n")
    for command in (["check"], ["run", "--record"]):
        offered = bash(*command, "own/", folder=tmp_path, lines=lines)
        assert offered == ["own/mine-1_2,ä=@+%.yaml"]


@pytest.mark.process
@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_fish_completes(tmp_path: Path) -> None:
    """The same."""
    path = tmp_path / "script.fish"
    path.write_text(script(make_parser(), "fish"), encoding="utf-8")
    lines = {
        "bt-mission run expl": "explore",
        "bt-mission run square --set s": "side=",
        **dict(cases("COMPLETED_BY_FISH")),
    }
    for line, expected in lines.items():
        results = asked(["fish", "--no-config", "-c", f"source {path}; complete -C '{line}'"])
        assert expected in [result.partition("\t")[0] for result in results]


@pytest.mark.process
@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_reads_its_script(tmp_path: Path) -> None:
    """Its completion needs a terminal; here it only has to be well-formed."""
    path = tmp_path / "script.zsh"
    path.write_text(script(make_parser(), "zsh"), encoding="utf-8")
    assert asked(["zsh", "-n", str(path)]) == []


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_is_in_every_script(shell: str) -> None:
    """Those below others, too."""
    text = script(make_parser(), shell)
    (commands,) = (
        action.choices for action in make_parser()._actions if isinstance(action.choices, dict)
    )
    for command in (*commands, *cases("WORDS_BELOW")):
        assert command in text
    for kind in KINDS:
        assert f"--names {kind}" in text


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("bt-mission run square --set", ["side=", "speed="]),
        ("/usr/bin/bt-mission run --set x=1 square --set", ["side=", "speed="]),
        ("run sweep --set", ["angle=", "images="]),
        ("bt-mission run scenarios/square.scenario.yaml --set", ["side=", "speed="]),
        ("bt-mission run mine.yaml --set", ["a="]),
        ("bt-mission run own.scenario.yaml --set", ["a="]),
        ("bt-mission run 'square --set", ["side=", "speed="]),
        ("bt-mission run torn.yaml --set", []),
        ("bt-mission run none.yaml --set", []),
        ("bt-mission run m.xml --set", []),
        ("bt-mission run round.scenario.yaml --set", []),
        ("bt-mission run list.yaml --set", []),
        (
            "bt-mission run place.yaml --set",
            ["to=", "to=A", "to=B", "to=C", "to=D", "to=dock", "laps="],
        ),
        ("bt-mission run --set", []),
        ("", []),
    ],
)
def test_inputs_are_those_of_the_mission_of_the_line(
    cli: CommandLine, line: str, expected: list[str]
) -> None:
    """What cannot be read has none, and what a shell would expand is left out."""
    texts = {
        "mine.yaml": "mission: m\ninputs: {a: 1, $(touch x): 2, b c: 3}\n",
        "own.scenario.yaml": "scenario: s\nmission: mine.yaml\n",
        "round.scenario.yaml": "scenario: s\nmission: round.scenario.yaml\n",
        "torn.yaml": "mission: [\n",
        "m.xml": "<root/>",
        "list.yaml": "mission: m\ninputs: [a]\n",
        "place.yaml": "mission: m\nworld: nav_arena\nplaces: {dock: [0, 0]}\n"
        "inputs: {to: zone B, laps: 2}\n",
    }
    for name, text in texts.items():
        cli.write(name, text)
    assert known("inputs", line) == expected


@pytest.mark.parametrize("kind", FILES)
def test_names_are_printed_for_scripts(cli: CommandLine, kind: str) -> None:
    """One a line."""
    assert cli.lines(f"completion --names {kind}") == known(kind)
    assert set(names("missions")) < set(known("runs"))
