"""Facts about limits, tolerances and rates that are a matter of choice."""

from __future__ import annotations

from dataclasses import fields

import pytest

from action_servers.core.tuning import FrontierTuning, MapperTuning, NavigationTuning, Tuning
from bt_mission.core.parameters import specs

ALL = (Tuning, NavigationTuning, FrontierTuning, MapperTuning)


@pytest.mark.parametrize(
    ("tunings", "name"), [(tunings, field.name) for tunings in ALL for field in fields(tunings)]
)
def test_each_has_a_range_that_its_default_lies_in_and_a_description(tunings, name):
    """Which says the unit, where there is one."""
    _, allowed = specs(tunings)[name]
    assert allowed.low <= getattr(tunings(), name) <= allowed.high
    assert allowed.description.endswith(".")
