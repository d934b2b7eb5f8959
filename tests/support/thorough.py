"""Thorough tests repeat on every case, or at length, what others show on a sample of cases.

They run with `--thorough`, and when a test is chosen by its name (`FILE::TEST`). Tests of processes
are among them, but for those marked `process(always=True)`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

LONG = ("obstacle_appears", "odometry_lost", "patrol", "scan_lost", "sweep", "tight_turn")
"""Scenarios that draw pictures or take long."""


def sample(values: Iterable[Any], every: int, *, first: int = 0) -> list[Any]:
    """Return parameters; without `--thorough` only one of each `every` of them runs."""
    return [
        value if number % every == first % every else _later(value)
        for number, value in enumerate(values)
    ]


def _later(value: Any) -> Any:
    """Return a parameter for thorough tests only."""
    if isinstance(value, type(pytest.param())):
        marks = (*value.marks, pytest.mark.thorough)
        return pytest.param(*value.values, marks=marks, id=value.id)
    row = value if isinstance(value, tuple) else (value,)
    return pytest.param(*row, marks=pytest.mark.thorough)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--thorough`."""
    parser.addoption("--thorough", action="store_true", help="run the thorough tests, too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave thorough tests out unless somebody asks for them."""
    if config.getoption("thorough") or any("::" in argument for argument in config.args):
        return
    for item in items:
        if item.path.name.endswith(".scenario.yaml") and item.name in LONG:
            item.add_marker("thorough")
    thorough = {item for item in items if is_thorough(item)}
    if thorough:
        config.hook.pytest_deselected(items=list(thorough))
        items[:] = [item for item in items if item not in thorough]


def is_thorough(item: pytest.Item) -> bool:
    """Return whether a test runs with `--thorough` only."""
    process = item.get_closest_marker("process")
    rarely = process is not None and not process.kwargs.get("always", False)
    return rarely or item.get_closest_marker("thorough") is not None
