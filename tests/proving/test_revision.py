"""`bt-mission prove --revision` tries a revision in every state that a mission can reach."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main

MISSION = """\
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
            [
                "the clean-up of 'finally' is under way, and would change; wait until it has ended",
            ],
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
    Path("m.yaml").write_text(MISSION, encoding="utf-8")
    Path("n.yaml").write_text(MISSION.replace(*change), encoding="utf-8")
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
