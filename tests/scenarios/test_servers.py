"""Scripted servers of a scenario answer each goal as it is written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.testing import Stages
from tests.support.thorough import sample

HEAD = "scenario: s\nmission:\n  mission: m\n  tree: {TREE}\nexpect: {outcome: any, EXPECT}\n"
TURN = "turn: {angle: 90}, timeout: 5, outputs: {angle_turned: angle}"
LATE = (
    "'turn' succeeded late: /turn succeeded after its timeout of 5 s, {:g} s after its acceptance"
)
LOST = "; orphaned goals: /turn goal a93875fe of 'turn' (lost)"


def outcome(servers: str, tree: str = TURN, expect: str = "orphaned_goals: any") -> tuple[Any, ...]:
    """Return time, status and reason of a run."""
    text = HEAD.replace("TREE", tree).replace("EXPECT", expect) + servers
    result = run_scenario(load_scenario(read_text(text, "s.scenario.yaml")))
    return round(result.report.virtual_s, 2), result.report.status, result.report.reason


@pytest.mark.parametrize(
    ("goal", "time", "reason"),
    sample(
        [
            ("{}", 0.15, ""),
            ("{after: 2}", 2.05, ""),
            ("{answer: reject}", 0.1, "'turn' rejected: /turn: its server gave no reason"),
            (
                "{answer: none}",
                5.05,
                "'turn' no answer to the goal: /turn did not answer the goal within 2 s" + LOST,
            ),
            ("{answer_after: 1, after: 3}", 3.05, ""),
            ("{end: abort, after: 0.5}", 0.55, "'turn' aborted: /turn"),
            (
                "{end: abort, result: {error_code: 7, error_msg: no}}",
                0.15,
                "'turn' aborted: /turn: no (code 7)",
            ),
            (
                "{end: cancel, after: 1}",
                1.05,
                "'turn' canceled by another client: /turn: somebody else cancelled",
            ),
            ("{end: never}", 5.15, "'turn' canceled by timeout: not done within 5 s"),
            ("{end: never, cancel: succeed}", 5.15, LATE.format(5.05)),
            ("{cancel: ignore, after: 7}", 7.05, LATE.format(6.95)),
            (
                "{end: never, cancel: abort}",
                5.15,
                "'turn' aborted: /turn, after its timeout of 5 s",
            ),
            (
                "{end: never, cancel: ignore}",
                11.1,
                "'turn' unconfirmed: not done within 5 s, "
                "but /turn did not confirm the cancel in 3 s" + LOST,
            ),
        ],
        2,
    ),
)
def test_each_answer_has_its_outcome(goal: str, time: float, reason: str) -> None:
    """At its time, to the tick."""
    status = "failure" if reason else "success"
    assert outcome(f"servers: {{turn: [{goal}]}}") == (time, status, reason)


def test_goals_are_answered_in_their_order_and_then_as_usual() -> None:
    """The second goal of three fails."""
    tree = f"sequence: [{{{TURN}}}, {{invert: {{{TURN}}}}}, {{{TURN}}}]"
    assert outcome("servers: {turn: [{}, {answer: reject}]}", tree) == (0.3, "success", "")


def test_results_and_feedback_have_the_written_fields() -> None:
    """A condition reads the feedback, a check the result; names may be dotted."""
    tree = (
        "sequence: [{turn: {angle: 90}, timeout: 5, cancel_when: current_angle > 3, "
        "on_cancel: success, outputs: {angle_turned: angle}}, {check: angle == 4}]"
    )
    goal = "{end: never, feedback: [{after: 1, every: 0.5, values: {current_angle: 2.0}}, "
    goal += "{after: 3, values: {current_angle: 3.5}}], result: {angle_turned: 4.0}}"
    assert outcome(f"servers: {{turn: [{goal}]}}", tree) == (3.1, "success", "")


def test_a_server_that_a_fault_kills_comes_back() -> None:
    """The mission waits for it."""
    servers = "servers: {turn: []}\nfaults: ['at 0: kill_server turn lasting 2']"
    assert outcome(servers) == (2.15, "success", "")


def test_the_fixture_runs_the_same(stage: Stages, tmp_path: Path) -> None:
    """With the same trace; what cannot be repeated names the server."""
    text = HEAD.replace("TREE", TURN).replace("EXPECT", "") + "servers: {turn: [{after: 1}]}"
    scenario = load_scenario(read_text(text, str(tmp_path / "s.scenario.yaml")))
    assert list(map(str, scenario.servers)) == ["the scripted server of turn"]
    traces = {
        result.report.trace_sha256
        for result in (run_scenario(scenario), stage.run_scenario(scenario))
    }
    assert len(traces) == 1


UNUSED = "sequence: [{log: hi}, {wait: 0.1}]"


@pytest.mark.parametrize(
    ("servers", "tree", "place", "what"),
    sample(
        [
            ("{turn: []}", UNUSED, "6:11", "the scripted server of turn got no goal"),
            ("{turn: [{}]}", UNUSED, "6:11", "the scripted server of turn got no goal"),
            (
                "{turn: [{}, {}]}",
                TURN,
                "6:22",
                "answer 2 of the scripted server of turn got no goal",
            ),
            ("{turn: [{}, {may_not_be_asked: true}]}", TURN, "", ""),
            ("{turn: [{may_not_be_asked: true}]}", UNUSED, "", ""),
        ],
        3,
    ),
)
def test_a_run_without_a_goal_for_an_answer_does_not_pass(
    servers: str, tree: str, place: str, what: str, stage: Stages
) -> None:
    """It has shown nothing of it; the error is at the place of the answer."""
    text = HEAD.replace("TREE", tree).replace("EXPECT", "") + f"servers: {servers}\n"
    scenario = load_scenario(read_text(text, "s.scenario.yaml"))
    for result in (run_scenario(scenario), stage.run_scenario(scenario)):
        assert result.report.conclusion[0] == ("untested" if what else "success")
        assert result.report.untested == ((what,) if what else ())
        errors = [f"s.scenario.yaml:{place}: error: not tested: {what}"] if what else []
        assert [each.headline.partition("; ")[0] for each in result.differences] == errors


@pytest.mark.parametrize(
    ("servers", "message"),
    [
        ("{trun: []}", "no action is named 'trun' (known: turn, "),
        ("{turn: [{result: {angel: 1}}]}", "no field 'angel'"),
        ("{turn: [{feedback: [{values: {current_angle: far}}]}]}", "current_angle"),
        ("{turn: [{answer: no thanks}]}", "expected one of accept, reject, none"),
    ],
)
def test_a_mistake_has_its_place(servers: str, message: str) -> None:
    """Before anything runs."""
    text = HEAD.replace("TREE", TURN).replace("EXPECT", "") + f"servers: {servers}"
    with pytest.raises(InputError) as caught:
        load_scenario(read_text(text, "s.scenario.yaml"))
    assert message in str(caught.value)
    assert "s.scenario.yaml:6:" in str(caught.value)
