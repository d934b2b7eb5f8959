"""What the page about scenarios says is so."""

from __future__ import annotations

import re

import pytest

from bt_mission.faults import parse_fault
from tests.support.project import ROOT

TEXT = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
FAULTS = "".join(re.findall(r"^```faults\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)).splitlines()


@pytest.mark.parametrize("text", FAULTS)
def test_the_examples_are_read(text: str) -> None:
    """Each line."""
    assert parse_fault(text).text


def test_faults_of_the_command_line_are_read() -> None:
    """Those behind `--fault`."""
    matches = re.findall(r"--fault '([^']*)'", TEXT)
    assert len(matches) >= 2
    assert all(parse_fault(text) for text in matches)
