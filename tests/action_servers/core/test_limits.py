"""Limits of goals: what they accept, and how they say so."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from action_servers.camera.colours import HUES_DEG
from action_servers.core.limits import COLOURS, NumberLimit, faults


def test_the_colours_are_those_with_a_hue():
    """In the same order."""
    assert tuple(HUES_DEG) == COLOURS


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (NumberLimit(field="a", low=1, high=5, unit="s", source=""), "from 1 to 5 s"),
        (
            NumberLimit(field="a", low=0, high=5, unit="s", source="", above=True),
            "above 0 and at most 5 s",
        ),
        (NumberLimit(field="a", low=0, high=float("inf"), unit="s", source=""), "0 s or more"),
    ],
)
def test_a_limit_has_words(limit, words):
    """What is accepted."""
    assert limit.words == words


def test_a_zero_with_a_meaning_is_accepted():
    """Beside the range, and only 0."""
    limit = NumberLimit(field="a", low=1, high=5, unit="s", source="", zero="the default")
    assert [limit.fault(value) is None for value in (0.0, 0.5, 1.0)] == [True, False, True]


def test_a_duration_counts_in_seconds():
    """As a message has it."""
    limit = NumberLimit(field="time", low=0, high=float("inf"), unit="s", source="")
    goal = SimpleNamespace(time=SimpleNamespace(sec=-2, nanosec=500_000_000))
    assert list(faults(goal, (limit,))) == ["time must not be negative, got -1.5 s"]
