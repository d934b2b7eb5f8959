"""The page about fleets: its file is the shipped one, its output that of a run, its code works."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from bt_mission.core import files
from bt_mission.core.yaml.document import read, read_text
from tests.support.project import ROOT

PAGE = (ROOT / "docs" / "how-to" / "fleet.md").read_text(encoding="utf-8")
FLEET = "fleets/two_wanderers.fleet.yaml"


def blocks(language: str) -> list[str]:
    """The blocks of the page in a language."""
    matches = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return [text for name, text in matches if name == language]


def test_the_file_is_the_shipped_one() -> None:
    """Apart from its comment."""
    (text,) = blocks("yaml")
    assert read_text(text).data == read(files.find("missions", FLEET)).data


def test_the_output_is_that_of_a_run(capsys: pytest.CaptureFixture[str]) -> None:
    """Apart from wall time."""
    shown = next(block for block in blocks("") if block.startswith("two wanderers in"))
    first, last = shown.split("...\n")
    assert main(["run", FLEET, "--plain"]) == 0
    out = re.sub(r"in [\d.]+ s of wall time \([\d.]+ x", "in W (F x", capsys.readouterr().out)
    wanted = re.sub(r"in [\d.]+ s of wall time \([\d.]+ x", "in W (F x", last)
    assert out.startswith(first)
    assert out.endswith(wanted)


def test_the_code_works(tmp_path: Path) -> None:
    """As it stands there."""
    test, steps = blocks("python")
    names: dict[str, Any] = {
        "tmp_path": tmp_path,
        "distance": lambda pose, other: math.dist(pose[:2], other[:2]),
    }
    exec(compile(test + "\ntest_they_keep_apart()\n", "fleet.md", "exec"), names)  # noqa: S102 - the page's own code
    exec(compile(steps, "fleet.md", "exec"), names)  # noqa: S102 - the page's own code
    assert names["stage"].is_done
