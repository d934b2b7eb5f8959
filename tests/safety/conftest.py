"""The trials of campaigns/safety.py, for tests that run a few of them."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import pytest

from tests.support.project import ROOT

CAMPAIGNS = ROOT / "campaigns"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Import a module of the campaign: ``benchmark("safety_trials")``."""
    monkeypatch.setattr(sys, "path", [str(CAMPAIGNS), *sys.path])
    return importlib.import_module
