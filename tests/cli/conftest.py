"""The command line, as the tests of commands call it."""

from pathlib import Path

import pytest

from tests.support.command_line import CommandLine


@pytest.fixture
def cli(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> CommandLine:
    """Commands in an empty folder, which is the working one."""
    monkeypatch.chdir(tmp_path)
    return CommandLine(tmp_path, capsys)
