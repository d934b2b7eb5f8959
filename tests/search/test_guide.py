"""What counts as found, and how near a run came to it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bt_mission.search.guide import CLEARANCE, Aim, Failure, Guide, default_aim
from bt_mission.sweeps.row import RequirementMargin, ScenarioRow

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
    named = {name.replace("_", " "): one for name, one in changes.items()}
    return replace(USUAL, requirements={**USUAL.requirements, **named})


@pytest.mark.parametrize(
    ("aim", "changes", "found"),
    [
        ("violated", {"outcome": "failure"}, ()),
        ("violated", {"collisions": 1}, ()),
        ("failed", {"outcome": "failure", "failed_node": "drive"}, (Failure("failed", "drive"),)),
        ("failed", {"outcome": "interrupted"}, (Failure("failed", "goes on to its limit"),)),
        ("orphaned", {"orphaned_goals": 1}, (Failure("orphaned"),)),
        ("collision", {"collisions": 2}, (Failure("collision"),)),
        ("anything", {}, ()),
        (
            "anything",
            {"collisions": 1, "orphaned_goals": 1, "outcome": "failure"},
            (Failure("collision"), Failure("orphaned"), Failure("failed", "failure")),
        ),
        ("anything", {"outcome": "error", "collisions": 1}, ()),
    ],
)
def test_what_is_found(aim: Aim, changes: dict[str, object], found: tuple[Failure, ...]) -> None:
    """Only what is searched for; a run that could not run shows nothing."""
    assert Guide(aim, USUAL).failures(replace(USUAL, **changes)) == found  # type: ignore[arg-type]


def test_the_worst_violation_comes_first() -> None:
    """Margins are compared as shares of the usual ones; one without a margin is the worst."""
    row = changed(
        far=RequirementMargin("violated", -0.25, "m", 1.0),
        slow=RequirementMargin("violated", -0.5, "m/s", 1.0),
    )
    names = [one.what for one in Guide("violated", USUAL).failures(row)]
    assert names == ["far", "slow"]
    row = replace(row, requirements={**row.requirements, "in order": RequirementMargin("violated")})
    assert Guide("violated", USUAL).failures(row)[0].what == "in order"


def test_the_score_is_the_smallest_share() -> None:
    """1 is the mission as it is, -1 what is searched for; counts that hold say nothing."""
    guide = Guide("violated", USUAL)
    assert guide.score(USUAL) == 1.0
    row = changed(slow=RequirementMargin("holds", 0.5, "m/s", 1.0))
    assert guide.score(row) == 0.25
    assert guide.smallest(row) == (0.25, "slow")
    assert guide.score(changed(counts=RequirementMargin("violated", -1.0, "", 2.0))) == -1.0
    assert guide.score(replace(USUAL, outcome="error", requirements={})) == 1.0


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


def test_the_default() -> None:
    """A violated requirement where there are any."""
    assert default_aim(has_requirements=True) == "violated"
    assert default_aim(has_requirements=False) == "anything"
