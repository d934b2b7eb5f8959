"""Tests prove missions, by a function and by a marker."""

from __future__ import annotations

import re

import pytest

from bt_mission.base.commands import loaded, points
from bt_mission.commands.prove.testing import ProofFailed, prove
from tests.support.project import ROOT

TURN = "{turn: {angle: 90}, timeout: 9}"
MISSION = f"mission: m\ntree:\n  sequence: [{TURN}, {TURN}]\n"
UNSET = """mission: m
tree:
  sequence:
    - fallback:
        - {turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}
        - log: no turn
    - log: $code
"""
MARKED = f"""
import pytest

@pytest.mark.prove({UNSET!r}, faults=1)
def test_it_is_proved():
    raise KeyError("the body runs")

@pytest.mark.prove({UNSET!r}, faults=0)
def test_it_is_proved_without_faults():
    pass
"""


def test_a_proof_has_its_counts() -> None:
    """All properties hold where the second turn waits for the first."""
    proof = prove(MISSION, faults=0)
    assert (proof.exhaustive, proof.faults, proof.findings) == (True, 0, ())


def test_a_finding_fails_with_its_answers() -> None:
    """The assertion has them as text."""
    with pytest.raises(ProofFailed) as caught:
        prove(UNSET, faults=1)
    lines = str(caught.value).splitlines()
    assert lines[0] == "m:"
    assert lines[1].startswith("  unset_variable: the mission ends: ")
    assert lines[2] == "    1. /turn rejects the goal"


def test_an_exploration_that_is_not_finished_fails() -> None:
    """What was not visited is not proved."""
    with pytest.raises(ProofFailed, match="the budget of 5 states is used up"):
        prove(MISSION, states=5)


def test_a_marker_proves_before_the_test(pytester: pytest.Pytester) -> None:
    """A finding fails the test, and its body does not run."""
    pytester.makepyfile(MARKED)
    result = pytester.runpytest("-p", "no:cacheprovider", "--strict-markers")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*ProofFailed: m:", "*1. /turn rejects the goal"])
    result.stdout.no_fnmatch_line("*the body runs*")


def test_the_example_of_the_page_passes(pytester: pytest.Pytester) -> None:
    """With the mission and the world of the page about tests."""
    testing = (ROOT / "docs/reference/testing.md").read_text(encoding="utf-8")
    for name, text in re.findall(r"`(\S+\.yaml)`[^`]*```\w+\n(.*?)```", testing, re.DOTALL):
        (pytester.path / name).write_text(text, encoding="utf-8")
    page = (ROOT / "docs/how-to/prove-a-mission.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (pytester.path / "test_there.py").write_text(block, encoding="utf-8")
    pytester.runpytest("-p", "no:cacheprovider").assert_outcomes(passed=2)


def test_a_notebook_shows_a_proof_as_a_page() -> None:
    """Alone, as a whole document."""
    proof = prove(MISSION, faults=0)
    name = f"{type(proof).__module__}.{type(proof).__qualname__}"
    page = loaded(points("display.")[name])(proof)
    assert page.startswith("<!doctype html>")
    assert "<title>m" in page
