"""Commands with all that they print: `transcripts/*.txt`, ``tests/commands/NAME/cli/*.txt``.

A transcript begins with the files of the folder. The output of a command is its standard output,
then its standard error, then its exit code if that is not 0.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.support.command_line import CommandLine
from tests.support.project import ROOT
from tests.support.transcripts import assert_transcript, head_of, transcripts_of

NO_ANSWER = re.compile(r"\((Timed out trying [^)]*|TimeoutError)\)")
"""Which of two limits of a second ends first is chance."""

WALL_TIME = re.compile(r"in [\d.]+ s of wall time \([\d.]+ x real time\)")


CHOICES = re.compile(r"(argument command: [^(]*)\(choose from [^)]*\)")
"""Commands that are there are listed."""

OF_COMMANDS = sorted((ROOT / "tests/commands").glob("*/cli/*.txt"))


@pytest.mark.parametrize(
    "path",
    [*transcripts_of(__file__), *OF_COMMANDS],
    ids=lambda path: f"{path.parts[-3]}-{path.stem}",
)
def test_every_command_prints_what_its_transcript_says(
    path: Path, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bad input changes no file."""
    monkeypatch.setattr("bt_mission.scenarios.concrete.pool.CONNECT_S", 1.0)
    _, *files = re.split(r"^-- (.+) --\n", head_of(path), flags=re.MULTILINE)
    for name, text in zip(files[::2], files[1::2], strict=True):
        cli.write(name, text)

    def output_of(line: str) -> str:
        before = cli.files()
        code = cli.call(line)
        output = WALL_TIME.sub("in W s of wall time (R x real time)", cli.out + cli.err)
        output = CHOICES.sub(r"\1(choose from COMMANDS)", output)
        output = NO_ANSWER.sub("(no answer within a second)", output)
        assert code != 2 or cli.files() == before, line
        return output.replace(str(ROOT), "SHIPPED") + (f"[{code}]\n" if code else "")

    assert_transcript(path, output_of)
