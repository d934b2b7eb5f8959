"""Requirements of a mission on the stage: watched at every control step, and acted on."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from bt_mission.requirements.checks import with_requirements
from bt_mission.requirements.monitor import Monitors
from bt_mission.ros.signals import LiveSignals
from bt_mission.testing.stages import Stages
from tests.support.thorough import sample

MISSION = """\
mission: look and drive
world: dqn_stage4
requirements:
  keeps its distance: always clearance > 0.10
  is never hit: never collisions > 0
  gets on: 'eventually within 60 s: succeeded("drive")'
  looks before it drives: 'whenever running("drive"): previously succeeded("look around")'
  stops when blind: {{whenever: age("scan") > 0.5, then: speed < 0.01, within: 0.6,
    may_not_apply: true}}
  {}
tree:
  sequence:
    - turn: {{angle: 45}}
      name: look around
      timeout: 20
    - explore_forward: {{fwd_velocity: 0.2, stopping_distance: 0.5}}
      name: drive
      timeout: 20
"""
OTHER = "never runs: always speed < 1"


def test_what_holds_is_told_with_its_margin(stage: Stages) -> None:
    """Each requirement has a verdict, and how near it came to being violated."""
    run = stage.run(MISSION.format(OTHER))
    run.until_done()
    assert run.succeeded
    result = run.requirements
    verdicts = {name: each.verdict for name, each in result.items()}
    assert verdicts == dict.fromkeys(result, "holds") | {"stops when blind": "not applicable"}
    least = min(moment.clearance for moment in run.moments)
    assert result["keeps its distance"].margin == pytest.approx(least - 0.10, abs=1e-6)
    assert result["gets on"].margin is None
    reports = json.loads(json.dumps(run.report.as_dict()))["requirements"]
    assert [report["name"] for report in reports] == list(result)
    assert {"name", "verdict", "margin", "at"} <= reports[0].keys()


def test_a_violation_is_said_at_once_and_the_mission_goes_on(stage: Stages) -> None:
    """That is the default: it is in the log, the trace, the report and the verdict."""
    run = stage.run(MISSION.format("slow: always speed < 0.15"))
    run.expect_violation("slow")
    run.until_done()
    slow = run.requirements["slow"]
    assert (run.succeeded, slow.verdict) == (True, "violated")
    (event,) = run.events("requirement")
    assert event["name"] == "slow"
    assert event["t"] == run.stage.start_ns + round((slow.violated_at or 0) * 1e9)
    assert [text for text in run.log if text.startswith("requirement slow: violated by")]
    assert "requirement slow: violated by" in run.report.as_text()


@pytest.mark.parametrize(("action", "goal"), [("fail", "canceled"), ("halt", "aborted")])
def test_a_violation_ends_the_mission_and_its_goals(stage: Stages, action: str, goal: str) -> None:
    """A halt stops the servers as well: nothing moves until they are released."""
    formula = f"slow: {{formula: always speed < 0.15, on_violation: {action}}}"
    run = stage.run(MISSION.format(formula))
    run.expect_violation("slow", "gets on")
    report = run.until_done()
    assert (report.status, report.goals_left_behind) == ("failure", 0)
    assert report.reason.startswith("requirement slow: violated by")
    assert run.goals[-1].status == goal


def test_a_blind_robot_that_stops_meets_its_requirement(stage: Stages) -> None:
    """A fault makes the requirement look: its margin is that of the stop."""
    run = stage.run(MISSION.format(OTHER))
    run.expect_violation("gets on")
    run.at(2.0, stage.faults.drop("scan"))
    run.until_done()
    blind = run.requirements["stops when blind"]
    assert (blind.verdict, blind.unit) == ("holds", "m/s")


def test_a_node_is_as_it_ended_until_it_is_entered_again(stage: Stages) -> None:
    """A loop resets its nodes for a new round before it enters them: that is none of their ends."""
    run = stage.run(
        "mission: rounds\nrequirements:\n"
        "  stays: 'whenever previously succeeded(''b''): succeeded(''b'') or running(''b'')'\n"
        "tree:\n  repeat: {count: 2}\n  do:\n    sequence:\n"
        "      - {wait: 1, name: a}\n      - {wait: 1, name: b}\n"
    )
    run.until_done()
    assert run.requirements["stays"].verdict == "holds"


def test_the_first_control_step_has_heard_what_was_sent(stage: Stages) -> None:
    """Topics are subscribed to before it."""
    run = stage.run(
        "mission: rest\nrequirements:\n  hears: always age('odom') < 0.01\ntree:\n  wait: 1\n"
    )
    run.until_done()
    assert run.requirements["hears"].margin == 0.01


def test_an_unknown_name_lists_the_requirements(stage: Stages) -> None:
    """As everywhere in tests."""
    run = stage.run(MISSION.format(OTHER))
    with pytest.raises(Exception, match="unknown requirement 'slw'"):
        run.expect_violation("slw")
    run.step()


@pytest.mark.parametrize(
    ("formula", "body", "line"),
    [
        (
            "always turn_rate < 0.1",
            "run.until_done()",
            "*requirements failed: slow: violated by * rad/s at * s*",
        ),
        (
            "always speed < 0.3",
            "run.expect_violation('slow'); run.until_done()",
            "*expected violations are missing: slow: holds by * m/s at * s",
        ),
        (
            "eventually within 500 s: speed > 1",
            "run.expect_violation('slow'); run.advance(1.0)",
            "*expected violations are missing: slow: open at * s: *",
        ),
    ],
)
def test_a_violation_and_an_expected_one_that_is_missing_fail_a_test(
    pytester: pytest.Pytester, formula: str, body: str, line: str
) -> None:
    """Without a word in the test; the verdict at the end of the run counts."""
    Path(pytester.path, "slow.yaml").write_text(
        "mission: turns\nworld: empty_arena\n"
        f"requirements:\n  slow: '{formula}'\ntree:\n  turn: {{angle: 20}}\n"
    )
    pytester.makepyfile(f"def test_it(stage):\n    run = stage.run('slow.yaml')\n    {body}\n")
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider", "-p", "no:xdist")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([line])


SHIPPED = """\
requirements:
  keeps its distance: always clearance > 0.10
  sees its distance: always scan_clearance > 0.14
  is never hit: never collisions > 0
  gets on: 'eventually within 200 s: succeeded("{first}")'
  is in order: 'whenever running("{later}"): previously succeeded("{first}")'
  stops when blind: {{whenever: age("scan") > 0.5, then: speed < 0.01, within: 0.6,
    may_not_apply: true}}
  is slow: always speed < 0.3
  is too slow: always speed < 0.15
  comes far: eventually distance > 1
"""


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("mission", "first", "later"),
    sample([("explore", "look around", "drive"), ("patrol", "visit the zones", "log")], every=2),
)
def test_topics_tell_what_the_stage_tells_as_far_as_they_can(
    stage: Stages, tmp_path: Path, mission: str, first: str, later: str
) -> None:
    """The same run, judged by the truth and, as when attached, by topics alone."""
    require = tmp_path / "require.yaml"
    require.write_text(SHIPPED.format(first=first, later=later), encoding="utf-8")
    judged = with_requirements(stage.mission(mission), [require])
    run = stage.run(judged)
    run.expect_violation("is too slow")
    runner = run.stage.runner
    signals = LiveSignals(runner)
    monitors = Monitors(judged.requirements, signals)

    def look() -> None:
        signals.step()
        monitors.step(runner.now_ns - runner.executive.started_ns)
        signals.forget()

    runner.executive.after_tick.append(look)
    run.until_done()
    monitors.finish()
    by_topics = {entry.name: entry for entry in monitors.results}
    for name, true in run.requirements.items():
        result = by_topics[name]
        if re.search(r"\b(clearance|collisions)", true.requirement):
            assert (result.verdict, true.verdict) == ("unknown", "holds")
            assert result.why.endswith("only a simulation provides it")
            continue
        assert result.verdict == true.verdict, name
        if true.margin is not None and result.margin is not None:
            assert result.margin == pytest.approx(true.margin, abs=TOLERANCES.get(name, 1e-6)), name
    assert by_topics["is slow"].sources == ("speed by odometry",)
    assert "(speed by odometry)" in str(by_topics["is too slow"])
    assert run.requirements["is slow"].sources == ()


TOLERANCES = {
    "is slow": 0.02,
    "is too slow": 0.02,
    "stops when blind": 0.02,
    "comes far": 0.2,
}
"""By odometry, m/s and m; what both know from the same source is equal."""


def test_the_root_is_known_by_the_name_of_the_mission(stage: Stages) -> None:
    """Its success and its failure are seen by requirements."""
    text = (
        "mission: plain\nrequirements:\n  ends well: eventually succeeded('plain')\n"
        "  never fails: never failed('plain')\ntree:\n  sequence:\n    - {}\n"
    )
    good = stage.run(text.format("wait: 0.2"))
    good.until_done()
    assert {requirement.verdict for requirement in good.requirements.values()} == {"holds"}
    bad = stage.run(text.format("check: 'false'"))
    bad.expect_violation("ends well", "never fails")
    bad.until_done()
    assert {requirement.verdict for requirement in bad.requirements.values()} == {"violated"}
