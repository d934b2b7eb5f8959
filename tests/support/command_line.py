"""`bt-mission` called in this process, in a folder of the test's own."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main


class CommandLine:
    """Commands, each one line of text as in a shell.

    Attributes:
        out, err: The output of the last command.
    """

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self._capsys = capsys
        self.out = self.err = ""

    def write(self, name: str, text: str) -> str:
        """Write a file of the folder; returns its name."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return name

    def files(self) -> dict[str, bytes]:
        """Return the contents of all files of the folder, by their names."""
        files = (path for path in sorted(self.folder.rglob("*")) if path.is_file())
        return {path.relative_to(self.folder).as_posix(): path.read_bytes() for path in files}

    def call(self, line: str) -> int:
        """Run a command; returns its exit code."""
        self._capsys.readouterr()
        try:
            code = main(shlex.split(line))
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        self.out, self.err = self._capsys.readouterr()
        assert "Traceback" not in self.out + self.err
        return code

    def __call__(self, line: str, code: int = 0) -> str:
        """Run a command that ends with a code; returns its standard output."""
        assert self.call(line) == code, self.out + self.err
        return self.out

    def lines(self, line: str, code: int = 0) -> list[str]:
        """Run a command; returns the lines of its standard output."""
        return self(line, code).splitlines()

    def json(self, line: str, code: int = 0) -> Any:
        """Run a command with `--json`; returns what its standard output holds."""
        return json.loads(self(f"{line} --json", code))

    def refused(self, line: str) -> str:
        """Run a command that is refused as bad input; returns its standard error."""
        assert self(line, 2) == ""
        return self.err


@pytest.fixture
def cli(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> CommandLine:
    """Commands in an empty folder, which is the working one."""
    monkeypatch.chdir(tmp_path)
    return CommandLine(tmp_path, capsys)
