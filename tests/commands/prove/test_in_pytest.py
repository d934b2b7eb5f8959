"""Tests prove missions, by a function and by a marker."""

from __future__ import annotations

import pytest

from bt_mission.commands.prove.testing import ProofFailed, prove

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
