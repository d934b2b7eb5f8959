"""Why runs have not passed."""

from __future__ import annotations

import pytest

from bt_mission.scenarios.cause import kind_of, masked
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("108 deg remained", "… deg remained"),
        ("the last is 1.05 s old (code 902)", "the last is … s old (code 902)"),
        ("1,200 of -3e-5, (1.5, -0.5), inf m", "… of …, (…, …), … m"),
        ("'leg2' in dqn_stage4 after 66deg", "'leg2' in dqn_stage4 after …deg"),
        ("information: nan", "information: …"),
    ],
)
def test_all_numbers_are_masked(text, shown):
    """Names with digits and error codes stay."""
    assert masked(text) == shown


@pytest.mark.parametrize(
    ("tree", "more", "kind"),
    [
        ("{wait: 1}", "", None),
        ("{check: 1 > 2}", "", "failed"),
        ("{wait: 9}", "limit: 1", "interrupted"),
        ("{wait: 1}", "requirements: {fast: always speed > 5}", "violated"),
        ("{check: 1 > 2}", "EXPECT, requirements: {fast: always speed > 5}", "violated"),
        ("{wait: 1}", "EXPECT", "unexpected"),
    ],
)
def test_the_kind_of_a_cause(tmp_path, tree, more, kind):
    """A mission that fails as expected is not the cause."""
    parts = [f"scenario: one, mission: {{mission: m, tree: {tree}}}"]
    if more:
        parts.append(more.replace("EXPECT", "expect: {outcome: failure}"))
    path = tmp_path / "one.scenario.yaml"
    path.write_text(f"{{{', '.join(parts)}}}")
    assert kind_of(run_scenario(load_scenario(path))) == kind
