"""Standard output that cannot be written."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import pytest

from bt_mission.cli import main

MISSION = "mission: rest\ntree:\n  wait: 0.1\n"


def _stream(file: int | str, *, is_buffered: bool) -> io.TextIOWrapper:
    raw = io.FileIO(file, "w")
    if is_buffered:
        return io.TextIOWrapper(io.BufferedWriter(raw))
    return io.TextIOWrapper(raw, write_through=True)  # as with python -u


@pytest.mark.parametrize(
    ("words", "is_buffered"),
    [
        ("schema", True),
        ("schema", False),
        ("check rest.yaml", True),
        ("run rest.yaml --json", True),
        ("run rest.yaml --json", False),
        ("run rest.yaml --plain", True),
        ("run rest.yaml --plain", False),
        ("--help", True),
        ("--version", False),
    ],
)
def test_a_full_disk_is_named(
    words: str,
    is_buffered: bool,  # noqa: FBT001 - of parametrize
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """/dev/full takes nothing; what is still buffered is dropped."""
    monkeypatch.chdir(tmp_path)
    Path("rest.yaml").write_text(MISSION)
    with _stream("/dev/full", is_buffered=is_buffered) as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main(words.split()) == 2
    output = capsys.readouterr().err
    assert output.splitlines()[-1] == "cannot write standard output: No space left on device"
    assert "doctor" not in output


@pytest.mark.parametrize("words", ["schema", "--help"])
def test_a_closed_pipe_is_an_interruption(
    words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is printed: its reader has left."""
    reader, writer = os.pipe()
    os.close(reader)
    with _stream(writer, is_buffered=True) as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        assert main([words]) == 130
    assert capsys.readouterr().err == ""
