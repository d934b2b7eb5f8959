"""Requirements on nodes, goals, variables, order and count are proved or violated."""

from __future__ import annotations

import pytest

from bt_mission.commands.prove.proof import Proof, ProofOptions, prove
from bt_mission.sessions.load import load
from tests.support.thorough import sample

TURN = "{turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}"
MOVE = "{move: {secs: 1, linear_velocity: 0.1}, timeout: 9}"
IN_ORDER = f"  sequence:\n    - {TURN}\n    - {MOVE}"
EITHER = f"  fallback:\n    - {TURN}\n    - {MOVE}"
AGAIN = f"  retry: {{attempts: 3}}\n  do: {MOVE}"
LOOP = f"  repeat: {{count: 500}}\n  do: {MOVE}"


def proof_of(tree: str, requirement: str, **options: object) -> Proof:
    """Prove a tree with one requirement."""
    head = f"mission: m\nrequirements:\n  wanted: {requirement!r}\n"
    return prove(load(f"{head}tree:\n{tree}\n"), ProofOptions(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("tree", "requirement", "verdict"),
    sample(
        [
            (IN_ORDER, 'whenever running("move"): previously succeeded("turn")', "proved"),
            (IN_ORDER, 'never running("turn") and running("move")', "proved"),
            (IN_ORDER, 'eventually succeeded("move")', "violated"),
            (IN_ORDER, "never open_goals > 1", "proved"),
            (IN_ORDER, "never open_goals > 0", "violated"),
            (IN_ORDER, "never goals_at_base > 1", "proved"),
            (EITHER, "never goals_at_base > 1", "violated"),
            (EITHER, 'never running("move")', "violated"),
            (EITHER, 'whenever running("move"): previously failed("turn")', "proved"),
            (EITHER, 'whenever running("move"): outcome("turn") == "rejected"', "violated"),
            (EITHER, 'whenever accepted("move"): previously failed("turn")', "proved"),
            (IN_ORDER, "never $code > 5", "violated"),
            (IN_ORDER, 'always $code <= 5 or running("m")', "violated"),
            (AGAIN, 'always count(starts(running("move"))) <= 3', "proved"),
            (AGAIN, 'always count(starts(running("move"))) <= 2', "violated"),
            (LOOP, 'always count(starts(running("move"))) <= 3', "violated"),
            (LOOP, 'not failed("m") until running("move")', "proved"),
        ],
        3,
    ),
)
def test_what_follows_from_answers_is_decided(tree: str, requirement: str, verdict: str) -> None:
    """In all runs with at most two faults."""
    proof = proof_of(tree, requirement)
    assert [entry.verdict for entry in proof.requirements] == [verdict]
    assert proof.exhaustive
    assert [entry.requirement for entry in proof.findings if entry.property == "requirement"] == (
        ["wanted"] if verdict == "violated" else []
    )


@pytest.mark.parametrize(
    ("requirement", "why"),
    [
        ("never speed > 1", "'speed': speed ahead, m/s"),
        ("never time > 100", "'time': since the mission's start, s"),
        ('whenever running("turn"): succeeded("turn") within 5', "'eventually' has a window"),
        ('always count(starts(running("turn"))) within 9 s so far <= 3', "'count' depends on"),
    ],
)
def test_what_depends_on_the_robot_or_on_seconds_needs_physics(requirement: str, why: str) -> None:
    """It is named with the reason, and is no finding."""
    proof = proof_of(IN_ORDER, requirement)
    assert [entry.verdict for entry in proof.requirements] == ["needs physics"]
    assert proof.requirements[0].why.startswith(why)
    assert proof.findings == ()


def test_a_violation_has_the_shortest_way() -> None:
    """One rejection leads to the second child."""
    proof = proof_of(EITHER, 'never running("move")')
    written = proof.findings[0].as_dict()
    assert (written["property"], written["node"], written["requirement"]) == (
        "requirement",
        None,
        "wanted",
    )
    assert written["text"] == "'wanted' is violated: never running(\"move\")"
    assert written["steps"] == ["/turn rejects the goal"]


def test_without_the_fault_it_is_proved() -> None:
    """A violation that needs a fault is outside of the bound of none."""
    proof = proof_of(EITHER, 'never running("move")', faults=0)
    assert [entry.verdict for entry in proof.requirements] == ["proved"]


def test_a_cut_exploration_proves_nothing() -> None:
    """The count of rounds is cut, so the requirement counts as not violated only."""
    proof = proof_of(LOOP, "never open_goals > 1", faults=0, rounds=2)
    assert [entry.verdict for entry in proof.requirements] == ["not violated"]
