"""Requirements are checked of a run, and say when they were violated, and how the tree stood."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.thorough import sample

WAITS = """
mission: waits
inputs: {most: 2}
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


@pytest.mark.parametrize(
    "requirement",
    sample(
        [
            "never collisions > 0",
            "always between 0.6 s and 1.5 s running('second')",
            "running('first') until running('second')",
            "eventually within 0.55 s running('second')",
            "whenever succeeded('first'): running('second') or succeeded('second')",
            "may not apply: whenever time > 5: x > 1",
            "always open_goals == 0 and $most > 1 and nearest != 'box'",
            "always abs(odometry.x - x) < 1 cm",
        ],
        2,
    ),
)
def test_a_requirement_that_holds(run: Any, requirement: str) -> None:
    """It can name nodes, variables, and what is true in the simulation."""
    assert run.check(requirement)
    assert run.broken == []


def test_a_requirement_that_is_violated_shows_its_signals(run: Any) -> None:
    """In one line, and with the tree; it is kept for the report of the test."""
    verdict = run.check("always running('first') or time < 0.2")
    line = "violated by 1.35 s at 1.55 s, first at 0.55 s: running('first') = False, time = 0.55"
    assert repr(verdict) == f"<{line}>"
    assert (verdict.t, verdict.margin) == (0.55, -1.35)
    assert verdict.details.splitlines() == [
        f"always running('first') or time < 0.2: {line}",
        "▶ waits",
        "  ✓ first  0.0 s left",
        "  ▶ second",
    ]
    assert run.broken == [verdict]
    assert verdict.details in run.describe()


@pytest.mark.parametrize(
    ("requirement", "line"),
    [
        ("eventually within 0.5 s running('second')", "violated, first at 0.50 s: running("),
        ("eventually time > 3", "violated by 1.45 s at 1.55 s: time = 1.55"),
        ("whenever running('second'): time > 9 within 5 s", "open"),
        ("always age('scan') < 1", "unknown: age('scan'): write it under 'requirements' of the"),
    ],
)
def test_a_requirement_that_does_not_hold(run: Any, requirement: str, line: str) -> None:
    """A window that the end cuts off does not hold, nor does what moments do not have."""
    verdict = run.check(requirement)
    assert not verdict
    assert verdict.line.startswith(line)


def test_a_run_without_a_step_fulfils_nothing(stage: Any) -> None:
    """There is nothing to evaluate."""
    run = stage.run(WAITS)
    assert repr(run.check("always x < 9")) == "<the run has no control step to check>"
    run.step()


@pytest.mark.parametrize(
    ("requirement", "message"),
    [
        ("always spead > 1", r"always spead > 1: unknown signal 'spead' .*did you mean 'speed'"),
        ("never running('third')", "unknown node 'third'"),
        ("always topic('imu', 'x') > 1", "/imu is not recorded"),
        ("always $least > 1", "variable 'least'"),
    ],
)
def test_an_invalid_requirement_is_an_error(run: Any, requirement: str, message: str) -> None:
    """Also a node, variable or topic that the run does not have."""
    with pytest.raises(ScenarioError, match=message):
        run.check(requirement)
