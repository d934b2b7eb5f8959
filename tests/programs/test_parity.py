"""Programs do on the stage what they do under rclpy in real time (``campaigns/parity.py``)."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import pytest

from tests.support.project import ROOT
from tests.support.thorough import sample


@pytest.fixture
def parity(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The campaign."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "campaigns"), *sys.path])
    return importlib.import_module("parity")


@pytest.mark.process(always=True)
@pytest.mark.parametrize("number", sample(range(7, 82, 10), 8, first=7))
def test_a_program_does_the_same_on_the_stage(parity: Any, number: int) -> None:
    """It prints the same lines at the same times, and ends with the same code."""
    assert len(parity.CASES) == 82
    assert parity.trial(number)["findings"] == []
