"""Requirements of a mission that was resumed: what both parts of the run tell."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bt_mission.base.verdicts import RequirementResult, Verdict
from bt_mission.language.mission import Requirement
from bt_mission.requirements.resumption import joined


def requirement(text: str) -> Requirement:
    """One with this formula."""
    return Requirement("it", text)


def result(text: str, verdict: Verdict, margin: float | None = None) -> RequirementResult:
    """What it has come to, after two seconds."""
    violated_at = 2.0 if verdict == "violated" else None
    return RequirementResult("it", text, verdict, margin, "m/s", 2.0, violated_at)


ALWAYS = "always speed < 0.3"
SOME = "eventually speed > 0.3"
AHEAD = "whenever speed > 0.3: speed < 0.1 within 2 s"
BACK = "whenever speed > 0.3: previously succeeded('look')"
FIRST = "eventually within 60 s: speed > 0.3"


@pytest.mark.parametrize("text", [ALWAYS, SOME, AHEAD, BACK, FIRST])
@pytest.mark.parametrize("after", ["holds", "violated", "open", "unknown"])
def test_what_was_decided_before_stays(text: str, after: Verdict) -> None:
    """Whatever comes: a violation is not forgotten, nor is what was reached."""
    for verdict, margin in (("violated", -0.1), ("holds", 0.1)):
        before = result(text, verdict, margin)  # type: ignore[arg-type]  # both are verdicts
        results = joined(requirement(text), before, result(text, after, 0.5))
        assert (results.verdict, results.margin) == (verdict, margin)
        assert str(results).endswith("at 2.00 s: before the mission was resumed")


@pytest.mark.parametrize(
    ("text", "after", "verdict"),
    [
        (ALWAYS, "holds", "holds"),
        (ALWAYS, "violated", "violated"),
        ("never speed > 0.3", "violated", "violated"),
        (SOME, "holds", "holds"),
        (SOME, "violated", "violated"),
        (AHEAD, "holds", "open"),  # one of its windows may have been cut off
        (AHEAD, "violated", "violated"),
        (BACK, "holds", "open"),
        (BACK, "violated", "open"),  # it may have looked before
        (FIRST, "holds", "open"),
        (FIRST, "violated", "open"),
        ("(always speed < 1) and (eventually speed > 0.3)", "violated", "open"),
        (ALWAYS, "unknown", "unknown"),
    ],
)
def test_what_spans_the_gap_is_open(text: str, after: Verdict, verdict: Verdict) -> None:
    """What speaks of each instant alone is judged by both parts."""
    results = joined(requirement(text), result(text, "open"), result(text, after))
    assert results.verdict == verdict
    assert (results.violated_at is not None) == (verdict == "violated")
    assert bool(results.why) == (verdict == "open")


def test_the_margin_is_the_worst_of_both_parts() -> None:
    """Of `eventually` the best."""
    for text, before, after, expected in (
        (ALWAYS, 0.1, 0.2, 0.1),
        (ALWAYS, 0.3, 0.2, 0.2),
        (SOME, -0.1, -0.2, -0.1),
        (SOME, -0.1, 0.2, 0.2),
    ):
        verdict: Verdict = "holds" if after > 0 else "violated"
        results = joined(
            requirement(text), result(text, "open", before), result(text, verdict, after)
        )
        assert results.margin == expected
        assert ("its margin is from before" in str(results)) == (expected == before)


@pytest.mark.parametrize(
    ("unmet_before", "verdict", "unmet"),
    [(("a", "b"), "not exercised", ("b",)), (("a",), "holds", ()), ((), "holds", ())],
)
def test_a_premise_that_came_true_in_either_part(
    unmet_before: tuple[str, ...], verdict: str, unmet: tuple[str, ...]
) -> None:
    """Only those that neither part has seen are left."""
    text = "whenever speed > 0.3: time < 9"
    before = replace(result(text, "open"), unmet=unmet_before)
    after = replace(result(text, "not exercised"), unmet=("b",), why="b")
    whole = joined(requirement(text), before, after)
    assert (whole.verdict, whole.unmet, whole.why) == (verdict, unmet, "".join(unmet))
