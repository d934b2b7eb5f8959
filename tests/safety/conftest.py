"""The trials of benchmarks/safety.py, for tests that run a few of them."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import pytest

from tests.support.project import ROOT

BENCHMARKS = ROOT / "benchmarks"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Import a module of the benchmark: ``benchmark("safety_trials")``."""
    monkeypatch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
    return importlib.import_module
