"""The tree of a proof: each node with its outcomes, those that some run reaches ticked off."""

from __future__ import annotations

from bt_mission.proving.proof import ProofOptions, prove
from bt_mission.sessions.load import load
from bt_mission.views.terminal.outcomes import outcome_rows

MISSION = """mission: m
trees:
  turn: {do: {turn: {angle: 90}, timeout: 9}}
tree:
  fallback:
    - tree: turn
    - log: no turn
    - log: never
"""
BY_OTHER = "· canceled by another client"


def test_the_outcomes_of_usual_runs_are_ticked_off() -> None:
    """Nodes of named trees are listed below their name."""
    proof = prove(load(MISSION), ProofOptions(faults=0, with_outcomes=True))
    assert list(outcome_rows(proof.outcomes, "utf-8")) == [
        "outcomes of nodes: ✓ some run reaches it, · none does",
        "  ? m  ✓ success  ✓ 1 turn  · 2 log  · 3 log",
        "    ▣ turn  ✓ success  · failure",
        "    ¶ log  · success",
        "    ¶ log  · success",
        "tree turn:",
        f"  ▶ turn  ✓ succeeded  · aborted  · rejected  · canceled by timeout  {BY_OTHER}",
        "      · server not available  · no answer to the goal  · server lost  · cancel refused",
        "      · unconfirmed",
    ]


def test_one_fault_reaches_more_outcomes_and_json_has_them() -> None:
    """A terminal without the signs gets others."""
    proof = prove(load(MISSION), ProofOptions(faults=1, with_outcomes=True))
    rows = list(outcome_rows(proof.outcomes, "ascii"))
    assert rows[1] == "  ? m  + success  + 1 turn  + 2 log  - 3 log"
    tree = proof.as_dict()["tree"]
    assert tree[0] == {
        "node": "0 m",
        "reached": ["success", "1 turn", "2 log"],
        "missing": ["3 log"],
    }
    assert "tree" not in prove(load(MISSION), ProofOptions(faults=0)).as_dict()
