"""What `bt-mission prove` writes: outcomes of nodes, a page, and where a revision is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main
from bt_mission.commands.prove.outcomes import outcome_rows
from bt_mission.commands.prove.proof import ProofOptions, prove
from bt_mission.sessions.load import load
from tests.support.report_pages import data_of

NAMED_TREE = """mission: m
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
    proof = prove(load(NAMED_TREE), ProofOptions(faults=0, with_outcomes=True))
    assert list(outcome_rows(proof.outcomes, "utf-8")) == [
        "outcomes of nodes: ✓ some run reaches it, · none does",
        "  ? m  ✓ success  ✓ 1 turn  · 2 log  · 3 log",
        "    ▣ turn  ✓ success  · failure",
        "    ¶ log  · success",
        "    ¶ log  · success",
        "tree turn:",
        "  ▶ turn  ✓ succeeded  · succeeded late  · aborted  · rejected  · canceled by timeout",
        f"      {BY_OTHER}  · server not available  · no answer to the goal  · server lost",
        "      · cancel refused  · unconfirmed",
    ]


def test_one_fault_reaches_more_outcomes_and_json_has_them() -> None:
    """A terminal without the signs gets others."""
    proof = prove(load(NAMED_TREE), ProofOptions(faults=1, with_outcomes=True))
    rows = list(outcome_rows(proof.outcomes, "ascii"))
    assert rows[1] == "  ? m  + success  + 1 turn  + 2 log  - 3 log"
    tree = proof.as_dict()["tree"]
    assert tree[0] == {
        "node": "0 m",
        "reached": ["success", "1 turn", "2 log"],
        "missing": ["3 log"],
    }
    assert "tree" not in prove(load(NAMED_TREE), ProofOptions(faults=0)).as_dict()


UNSET = """\
mission: <m>
tree:
  sequence:
    - fallback:
        - turn: {angle: 90}
          name: <turn>
          timeout: 9
          outputs: {error_code: code}
        - log: no turn
    - log: $code
"""


def test_the_page_names_properties_findings_and_outcomes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names are text, not markup; the run of the finding can be played."""
    monkeypatch.chdir(tmp_path)
    Path("m.yaml").write_text(UNSET, encoding="utf-8")
    assert main(["prove", "m.yaml", "-o", "out"]) == 1
    assert "the page: out/proof.html" in capsys.readouterr().err
    page = Path("out/proof.html").read_text(encoding="utf-8")
    assert "<m>" not in page
    assert '<td>unset_variable</td><td class="violated">violated</td>' in page
    assert '<td>ends</td><td class="proved">proved</td>' in page
    assert "<li>/turn rejects the goal</li>" in page
    assert '<span class="yes">rejected</span>' in page
    assert '<span class="no">canceled by another client</span>' in page
    (run,) = Path("out").glob("*_unset_variable.html")
    assert f'<a href="{run.name}">the run, step by step</a>' in page
    assert data_of(run)[""]["messages"]


TIDY = """\
mission: tidy
tree:
  sequence:
    - turn: {angle: 90}
      name: left
      timeout: 60
    - finally: {timeout: 5}
      do: {log: body}
      then: {turn: {angle: -30}, name: home, timeout: 60}
"""


@pytest.mark.parametrize(
    ("change", "cancels", "reasons"),
    [
        (("log: body", "log: other"), [], []),
        (("angle: 90", "angle: 45"), ["left"], []),
        (
            ("angle: -30", "angle: -45"),
            ["home"],
            ["the clean-up of 'finally' is under way, and would change; wait until it has ended"],
        ),
    ],
)
def test_the_states_in_which_it_is_refused(
    change: tuple[str, str],
    cancels: list[str],
    reasons: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With a shortest way to the first of them; the exploration is the same as without it."""
    monkeypatch.chdir(tmp_path)
    Path("m.yaml").write_text(TIDY, encoding="utf-8")
    Path("n.yaml").write_text(TIDY.replace(*change), encoding="utf-8")
    code = main(["prove", "m.yaml", "--faults", "0", "--json", "--revision", "n.yaml"])
    proof = json.loads(capsys.readouterr().out)
    main(["prove", "m.yaml", "--faults", "0", "--json"])
    alone = json.loads(capsys.readouterr().out)
    revision = proof.pop("revision")
    assert proof == alone
    assert (code, revision["cancels"]) == (1 if reasons else 0, cancels)
    assert [refusal["reason"] for refusal in revision["refusals"]] == reasons
    for refusal in revision["refusals"]:
        assert refusal["steps"][:2] == ["/turn accepts the goal", "/turn succeeds"]
        assert 0 < refusal["states"] < revision["states"]
