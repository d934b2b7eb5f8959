"""Claims hold, or say when they broke first, on what, and how the tree stood."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.faults.errors import ScenarioError

WAITS = """
mission: waits
tree:
  sequence:
    - wait: 0.5
      name: first
    - wait: 1
      name: second
"""


@pytest.fixture
def run(stage: Any) -> Any:
    """A run that has ended, after 1.55 s."""
    run = stage.run(WAITS)
    run.until_done()
    return run


def test_always(run: Any) -> None:
    """At all control steps, or at those that are asked for."""
    assert repr(run.always(lambda s: s.collisions == 0)) == "<held at all 31 control steps>"
    assert run.always(lambda s: s.leaf("second").running, after=0.6, before=1.5)
    assert run.always(lambda s: s.leaf("first").running, until=lambda s: s.leaf("second").running)
    assert not run.always(lambda s: s.leaf("first").running)


def test_a_broken_claim_tells_what_it_saw(run: Any) -> None:
    """In one line, and with the tree; a claim that broke is kept for the report of the test."""
    verdict = run.always(lambda s: s.leaf("first").running or s.x > 1 or s.distance_to(0, 0) > 1)
    assert repr(verdict) == (
        "<did not hold at 0.55 s: leaf('first').running = False, x = -2.293e-07, "
        "distance_to(0, 0) = 2.293e-07>"
    )
    assert verdict.t == 0.55
    assert verdict.details.splitlines() == [
        "did not hold at 0.55 s:",
        "  leaf('first').running = False",
        "  x = -2.293e-07",
        "  distance_to(0, 0) = 2.293e-07",
        "▶ waits",
        "  ✓ first  0.0 s left",
        "  ▶ second",
    ]
    assert run.broken == [verdict]
    assert verdict.details in run.describe()


def test_never(run: Any) -> None:
    """At no control step."""
    assert repr(run.never(lambda s: s.collisions)) == "<held at none of 31 control steps>"
    verdict = run.never(lambda s: "second" in s.running)
    assert repr(verdict) == "<held at 0.55 s: running = ('second',)>"
    assert run.never(lambda s: "second" in s.running, before=0.5)


def test_eventually(run: Any) -> None:
    """At the first control step that will do, if it comes in time."""
    verdict = run.eventually(lambda s: s.leaf("second").running)
    assert (verdict.holds, verdict.t) == (True, 0.55)
    assert run.eventually(lambda s: s.leaf("second").running, within=0.55)
    assert repr(run.eventually(lambda s: s.leaf("second").running, within=0.5)) == (
        "<never held within 0.5 s; last seen at 0.50 s: leaf('second').running = False>"
    )
    assert repr(run.eventually(lambda s: s.x > 1, after=1)) == (
        "<never held until the end after 1 s; last seen at 1.55 s: x = -2.293e-07>"
    )


def test_whenever(run: Any) -> None:
    """Something follows each time, in time; a time that is not over counts, too."""
    assert (
        repr(
            run.whenever(
                lambda s: s.leaf("first").succeeded, lambda s: s.leaf("second").running, within=0
            )
        )
        == "<followed all 1 times>"
    )
    assert repr(
        run.whenever(
            lambda s: s.leaf("first").succeeded, lambda s: s.leaf("second").succeeded, within=0.9
        )
    ) == (
        "<did not follow within 0.9 s of 0.55 s; last seen at 1.50 s: "
        "leaf('second').succeeded = False>"
    )
    assert not run.whenever(lambda s: s.t > 1.5, lambda s: s.t > 9, within=5)
    assert run.whenever(lambda s: s.t > 5, lambda s: False, within=5)


def test_a_claim_about_nothing_does_not_hold(stage: Any, run: Any) -> None:
    """Else a test that never moves its run would pass."""
    assert repr(stage.run(WAITS).always(lambda s: True)) == (
        "<there is no control step at which to look>"
    )
    assert not run.never(lambda s: True, after=100)
    assert not run.eventually(lambda s: True, after=100)


def test_a_condition_that_raises_says_when(run: Any) -> None:
    """What a test asks for and is not there keeps its own words."""
    with pytest.raises(ScenarioError, match=r"condition raised ZeroDivisionError: .*, at 0.05 s"):
        run.always(lambda s: 1 / 0)
    with pytest.raises(ScenarioError, match="there is no node 'third', but: waits, first, second"):
        run.always(lambda s: s.leaf("third").running)
