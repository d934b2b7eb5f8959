"""What counts as found, and how near a run came to it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bt_mission.base.verdicts import Verdict
from bt_mission.commands.falsify.guide import ASSUMED, BRANCH, CLEARANCE, Aim, FoundFailure, Guide
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow

HOLDS = RequirementMargin("holds", 0.5, "m", 1.0)
USUAL = ScenarioRow(
    "0",
    0,
    seed=0,
    outcome="success",
    collisions=0,
    requirements={
        "far": HOLDS,
        "slow": RequirementMargin("holds", 2.0, "m/s", 1.0),
        "counts": RequirementMargin("holds", 0.0, "", 1.0),
        "in order": RequirementMargin("holds"),
    },
)


def changed(**changes: RequirementMargin) -> ScenarioRow:
    """Return the usual run with other margins."""
    named = {name.replace("_", " "): first for name, first in changes.items()}
    return replace(USUAL, requirements={**USUAL.requirements, **named})


@pytest.mark.parametrize(
    ("aim", "changes", "result"),
    [
        ("violated", {"outcome": "failure"}, ()),
        ("violated", {"collisions": 1}, ()),
        (
            "failed",
            {"outcome": "failure", "failed_node": "drive", "reason": "3.5 m left\nand more"},
            (FoundFailure("failed", "drive", "drive", "… m left"),),
        ),
        ("failed", {"outcome": "interrupted"}, (FoundFailure("failed", "runs until its limit"),)),
        ("orphaned", {"orphaned_goals": 1}, (FoundFailure("orphaned"),)),
        ("collision", {"collisions": 2}, (FoundFailure("collision"),)),
        ("anything", {}, ()),
        (
            "anything",
            {"collisions": 1, "orphaned_goals": 1, "outcome": "failure"},
            (
                FoundFailure("collision"),
                FoundFailure("orphaned"),
                FoundFailure("failed", "failure"),
            ),
        ),
        ("anything", {"outcome": "error", "collisions": 1}, ()),
    ],
)
def test_what_is_found(
    aim: Aim, changes: dict[str, object], result: tuple[FoundFailure, ...]
) -> None:
    """Only what is searched for; a run that could not run shows nothing."""
    assert Guide(aim, USUAL).failures(replace(USUAL, **changes)) == result  # type: ignore[arg-type]


def test_the_worst_violation_comes_first() -> None:
    """Margins are compared as shares of the usual ones; one without a margin is the worst."""
    row = changed(
        far=RequirementMargin("violated", -0.25, "m", 1.0),
        slow=RequirementMargin("violated", -0.5, "m/s", 1.0),
    )
    names = [failure.what for failure in Guide("violated", USUAL).failures(row)]
    assert names == ["far", "slow"]
    row = replace(row, requirements={**row.requirements, "in order": RequirementMargin("violated")})
    assert Guide("violated", USUAL).failures(row)[0].what == "in order"


MEASURED = replace(USUAL, requirements={name: USUAL.requirements[name] for name in ("far", "slow")})


def test_the_score_is_the_smallest_share() -> None:
    """1 is the mission as it is, -1 what is searched for."""
    guide = Guide("violated", MEASURED)
    assert guide.score(MEASURED) == 1.0
    slow = {"slow": RequirementMargin("holds", 0.5, "m/s", 1.0)}
    row = replace(MEASURED, requirements={**MEASURED.requirements, **slow})
    assert guide.score(row) == 0.25
    assert guide.smallest(row) == (0.25, "slow")
    broken = {"slow": RequirementMargin("violated", -1.0, "", 2.0)}
    assert guide.score(replace(MEASURED, requirements=broken)) == -1.0
    assert guide.score(replace(MEASURED, outcome="error", requirements={})) == 1.0


def branching(distance: float, coverage: str = "3") -> ScenarioRow:
    """Return a run of a mission whose requirement has no margin, so far from a branch."""
    verdict: Verdict = "holds" if distance > 0 else "violated"
    return replace(
        USUAL,
        coverage=coverage,
        requirements={
            "in order": RequirementMargin("holds"),
            f"{BRANCH}drive: x > 2 is true": RequirementMargin(verdict, distance),
        },
    )


def test_what_has_no_margin_is_approached_by_branches() -> None:
    """The nearer a branch that no run has taken, the better; a new place is better still."""
    guide = Guide("violated", branching(2.0))
    guide.learn(branching(2.0))
    scores = [guide.score(branching(distance)) for distance in (2.0, 1.0, 0.1)]
    assert scores == sorted(scores, reverse=True)
    assert scores[0] - scores[-1] > 0.2
    assert guide.score(branching(2.0, "7")) < scores[0] - 0.2
    guide.learn(branching(-0.5))
    assert guide.score(branching(0.1)) == guide.score(branching(2.0))


def test_rare_places_are_better_than_common_ones() -> None:
    """A place that many runs have reached is no news."""
    guide = Guide("failed", branching(2.0))
    before = guide.score(branching(2.0))
    for _ in range(10):
        guide.learn(branching(2.0))
    assert guide.score(branching(2.0)) > before


def test_what_breaks_an_assumption_does_not_count() -> None:
    """It is no find, however bad, and nothing to come nearer to."""
    guide = Guide("anything", USUAL)
    broken = {f"{ASSUMED}always x < 1": RequirementMargin("violated", -0.1)}
    row = replace(USUAL, outcome="failure", collisions=3, requirements=broken)
    assert guide.failures(row) == ()
    assert not guide.is_assumed(row)
    assert guide.score(row) == 1.0
    assert guide.smallest(row) is None


def test_the_same_failure_may_end_sooner() -> None:
    """Of a violation the end of its run does not matter; of a failed mission it does."""
    violated = FoundFailure("violated", "far", "drive", "too slow")
    assert violated.is_like(FoundFailure("violated", "far"))
    assert not violated.is_like(FoundFailure("violated", "slow"))
    assert not FoundFailure("failed", "drive", "drive", "too slow").is_like(
        FoundFailure("failed", "drive")
    )


def test_a_collision_is_approached_by_clearance() -> None:
    """Its guide is no requirement that can be violated; other margins do not matter."""
    usual = replace(USUAL, requirements={**USUAL.requirements, CLEARANCE: HOLDS})
    guide = Guide("collision", usual)
    row = replace(
        usual, requirements={"far": HOLDS, CLEARANCE: RequirementMargin("holds", 0.1, "m", 1.0)}
    )
    assert guide.smallest(row) == (0.2, CLEARANCE)
    violated = replace(row, requirements={CLEARANCE: RequirementMargin("violated", -0.01, "m", 1)})
    assert guide.failures(violated) == ()
    assert Guide("anything", usual).failures(violated) == ()
