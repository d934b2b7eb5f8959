"""Help fits the terminal, and an error says what was probably meant."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.cli.main import make_parser


def error_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[str, str]:
    """The first words of the usage, and the error, of a command line that is refused."""
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 2
    (said,) = capsys.readouterr().err.splitlines()
    return said.partition(": error: ")[0], said


@pytest.mark.parametrize(
    ("arguments", "command", "hint"),
    [
        (["rnu"], "bt-mission", "'rnu'; did you mean 'run'? (choose from run, watch,"),
        (["actions", "lst"], "bt-mission actions", "did you mean 'list'?"),
        (["run", "square", "--sped", "1"], "bt-mission run", "did you mean '--speed'?"),
        (["run", "square", "--wrold=x"], "bt-mission run", "did you mean '--world'?"),
        (["actions", "list", "--jsno"], "bt-mission actions list", "mean '--json'?"),
        (["serve", "--on-new-goal", "relpace"], "bt-mission serve", "mean 'replace'?"),
    ],
)
def test_a_word_that_is_nearly_right_gets_the_right_one(
    capsys: pytest.CaptureFixture[str], arguments: list[str], command: str, hint: str
) -> None:
    """On one line, with the command whose help says more."""
    shown, error = error_of(capsys, *arguments)
    assert shown == command
    assert error.endswith(f"; see '{shown} --help'")
    assert hint in error


def test_a_word_too_many_gets_no_hint(capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing is near it."""
    _, error = error_of(capsys, "run", "square", "circle")
    assert error == (
        "bt-mission run: error: unrecognized arguments: circle; see 'bt-mission run --help'"
    )


HELP = [
    [],
    ["run"],
    ["watch"],
    ["convert"],
    ["serve"],
    ["actions"],
    ["actions", "send"],
    ["services"],
    ["replay"],
]


@pytest.mark.parametrize("command", HELP, ids=" ".join)
def test_help_is_wrapped(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    """Only a command of an example, which is to be copied, may be longer than the line."""
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([*command, "--help"])
    lines = capsys.readouterr().out.splitlines()
    long = [line for line in lines if len(line) > 80]
    assert [line for line in long if not line.startswith("  bt-mission ") or "   " in line] == []


def test_the_main_command_teaches_by_examples(capsys: pytest.CaptureFixture[str]) -> None:
    """Each of them is one that is understood."""
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    said = capsys.readouterr().out.partition("\nexamples:\n")[2].splitlines()
    examples = [line.split("  ")[1] for line in said if line.startswith("  bt-mission run ")]
    assert len(examples) >= 5
    for example in examples:
        parsed = make_parser().parse_args(shlex.split(example)[1:])
        assert parsed.file.name


def test_a_paragraph_of_help_is_filled_as_a_whole(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However its lines are broken in the source."""
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main(["--help"])
    assert capsys.readouterr().out.splitlines()[-3:] == [
        "exit codes: 0 success, 1 mission failed, 2 bad input or an output that cannot",
        "be written, 130 interrupted; those of actions and services are in their own",
        "help",
    ]


@pytest.mark.parametrize(("words", "shown"), [([], "  run "), (["actions"], "  send ")])
def test_without_a_command_the_commands_are_shown(
    capsys: pytest.CaptureFixture[str], words: list[str], shown: str
) -> None:
    """As help, which is also an error."""
    with pytest.raises(SystemExit) as left:
        main(words)
    assert left.value.code == 2
    assert any(shown in line for line in capsys.readouterr().err.splitlines())


def test_an_unknown_option_without_a_command_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """Rather than the command that is missing."""
    _, error = error_of(capsys, "--verson")
    hint = "unrecognized arguments: --verson; did you mean '--version'?"
    assert error == f"bt-mission: error: {hint}; see 'bt-mission --help'"


def test_a_file_with_the_other_suffix_is_suggested(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of shipped missions, and of files that lie there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("mission: m\ntree: {wait: 1}\n", encoding="utf-8")
    for name, other in (("explore.yml", "explore.yaml"), ("mine.yml", "mine.yaml")):
        assert main(["run", name]) == 2
        assert f"no such file; did you mean '{other}'?" in capsys.readouterr().err
    assert main(["sweep", "square", "--vary", "speed=0.1:0.2"]) == 2
    assert "write 'speed=0.1..0.2'" in capsys.readouterr().err
