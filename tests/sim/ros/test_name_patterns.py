"""Patterns of names: what is matched, and what would cost more than a simulator has."""

from __future__ import annotations

import pytest

from sim.ros.name_patterns import PatternError, matching

NAMES = ["box_1", "box_22", "my box", "waffle"]


@pytest.mark.parametrize(
    ("pattern", "result"),
    [
        ("^box_[0-9]+$", ["box_1", "box_22"]),
        ("^box_[0-9]{2}$", ["box_22"]),
        ("(f+le|my )", ["my box", "waffle"]),
        ("^(b|o|x|_|1){5}$", ["box_1"]),
        ("([0-9])+$", ["box_1", "box_22"]),
    ],
)
def test_patterns_with_repetitions_match(pattern, result):
    """Of characters, of sets and of groups."""
    assert matching(pattern, NAMES) == result


@pytest.mark.parametrize(
    "pattern",
    [
        "a" + "+" * 14,
        "(" * 10 + "a" + "+)" * 10,
        "((a{1,20}\n?){1,20}\n?){1,20}",
        "a{1,999}",
        "(aaaaaaaaaa){1,40}",
        "a{0,255}{0,255}",
    ],
)
def test_a_pattern_that_multiplies_its_repetitions_is_refused(pattern):
    """A repetition is compiled to copies: 31 of them, one after the other, take all memory."""
    with pytest.raises(PatternError, match="its repetitions are too many"):
        matching(pattern, NAMES)
