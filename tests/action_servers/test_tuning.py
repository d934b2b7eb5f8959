"""Facts about limits, tolerances and rates that are a matter of choice."""

from __future__ import annotations

from dataclasses import fields

import pytest

from action_servers.tuning import RANGES, TUNING, Tuning


@pytest.mark.parametrize("name", [one.name for one in fields(Tuning)])
def test_each_has_a_range_that_its_default_lies_in_and_a_description(name):
    """Which says the unit, where there is one."""
    allowed = RANGES[name]
    assert allowed.low <= getattr(TUNING, name) <= allowed.high
    assert allowed.description.endswith(".")
