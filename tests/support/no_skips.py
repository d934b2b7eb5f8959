"""A plugin for pytest: with ``CI`` set, a skipped test fails, and nothing is left out unnoticed."""

from __future__ import annotations

import os
from collections.abc import Generator
from typing import Any

import pytest

MAY_BE_SKIPPED = (
    "rtamt is not installed; it refuses Python 3.13",  # there is no other library like it
    "the kernel does not let the peak be reset",  # of some containers, which nothing here changes
)
"""What a machine for continuous integration cannot have."""


def _refuse(report: Any) -> None:
    """Turn a skip into a failure that has its reason."""
    if os.environ.get("CI", "") in ("", "0", "false") or hasattr(report, "wasxfail"):
        return
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    if report.skipped and not reason.endswith(MAY_BE_SKIPPED):
        report.outcome = "failed"
        report.longrepr = f"with CI set, a skipped test fails: {reason}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, Any, Any]:
    """Look at each report of a test."""
    report = yield
    _refuse(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, Any, Any]:
    """Look at each report of a module, which may be skipped as a whole."""
    report = yield
    _refuse(report)
    return report
