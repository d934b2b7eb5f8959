"""Scenarios that are run: what comes out, beside what must."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest

import bt_mission
from bt_mission.base.diagnostics import InputError
from bt_mission.scenarios.cause import kind_of, masked
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import look_for_names, run_scenario
from tests.support.thorough import sample

INLINE = """\
scenario: it
mission:
  mission: turns
  world: empty_arena
  tree: {turn: {angle: 90}, name: turn, timeout: 20}
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Any:
    """Write a scenario of one turn, which takes 1.95 s: ``scenario(text)`` gives its path."""

    def write(text: str = "") -> Path:
        path = tmp_path / "it.yaml"
        path.write_text(INLINE + text, encoding="utf-8")
        return path

    return write


def test_a_scenario_is_run_in_one_line(scenario: Any) -> None:
    """What must come out is success, where nothing else is said."""
    result = bt_mission.run_scenario(scenario())
    assert result.passed
    assert str(result) == "scenario it: passed"
    assert result.report.status == "success"


def test_its_faults_happen_and_its_requirements_are_watched(scenario: Any) -> None:
    """Both are in the report."""
    result = run_scenario(
        scenario(
            "faults:\n  - at 0.5: shove turn 1.0\n"
            "requirements:\n  never turns: never turn_rate > 0.1\n"
            "expect: {violated: [never turns]}\n"
        )
    )
    assert result.passed, str(result)
    assert [fault.began for fault in result.report.faults] == [0.5]
    assert result.violated == ("never turns",)
    assert result.requirements["never turns"].verdict == "violated"


def test_start_and_obstacles_are_there_from_the_beginning(scenario: Any) -> None:
    """The robot stands where the scenario says, before a box."""
    text = (
        "start: {x: 1, y: 0.5, yaw: 0}\n"
        "obstacles: [{at: [1.5, 0.5], size: [0.2, 0.2, 0.3]}]\n"
        "requirements:\n"
        "  starts there: 'always for 0.1 s: abs(x - 1) < 0.01 and abs(y - 0.5) < 0.01'\n"
        "  has a box before it: 'always for 0.1 s: clearance < 0.4'\n"
    )
    result = run_scenario(scenario(text))
    assert result.passed, str(result)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    sample(
        [
            ("expect: {outcome: failure}\n", 6, "expected failure, got success, at 1."),
            ("expect: {reason: lost}\n", 6, "expected a reason with 'lost', got ''"),
            (
                "expect: {outcome: any, failed: turn}\n",
                6,
                "expected a failure of 'turn', got no failure",
            ),
            ("expect: {after: 50}\n", 6, "expected the end at 50 s or later, got 1."),
            ("expect: {before: 1}\n", 6, "expected the end at 1 s or earlier, got 1."),
            ("expect: {orphaned_goals: 1}\n", 6, "expected 1 orphaned goals, got 0"),
            ("expect: {collisions: 1}\n", 6, "expected 1 collisions, got 0"),
            ("requirements:\n  a: never speed < 9\n", 7, "requirement a: violated"),
            (
                "requirements:\n  a: always speed < 9\nexpect: {violated: [a]}\n",
                8,
                "expected a violation of 'a', got: a: holds",
            ),
            ("limit: 1.0\n", 1, "expected success, got interrupted: its time is up"),
        ],
        3,
    ),
)
def test_what_comes_out_otherwise_has_its_place(
    scenario: Any, text: str, line: int, message: str
) -> None:
    """In the scenario's file, at what is expected."""
    result = run_scenario(scenario(text))
    (difference,) = result.differences
    assert message in difference.message
    assert difference.line == line
    assert not result.passed
    assert str(result).endswith("scenario it: failed")


def test_names_that_are_not_there_are_errors_before_the_start(scenario: Any) -> None:
    """At their places; also where nothing is to be run."""
    path = scenario("faults:\n  - at 1: drop scna\n  - at 1: kill_server trun\n")
    for find in (run_scenario, lambda file: look_for_names(load_scenario(file))):
        with pytest.raises(InputError) as caught:
            find(path)
        assert [(fault.line, fault.column) for fault in caught.value.diagnostics] == [
            (7, 16),
            (8, 23),
        ]


@pytest.mark.parametrize(("text", "place"), [("start: {x: 2.0}\n", (6, 8)), ("", (9, 10))])
def test_a_start_without_room_is_an_error(scenario: Any, text: str, place: tuple[int, int]) -> None:
    """At the scenario's start, or at the world that says where the robot starts."""
    spawn = "" if text else "  spawn: {x: 1.9}\n"
    walls = "  walls: [{name: w, from: [2, -1], to: [2, 1]}]\n"
    path = scenario(f"{text}world:\n  name: h\n  size: [6, 3]\n{spawn}{walls}")
    for find in (run_scenario, lambda file: look_for_names(load_scenario(file))):
        with pytest.raises(InputError) as caught:
            find(path)
        (fault,) = caught.value.diagnostics
        assert "does not fit at the spawn" in fault.message
        assert (fault.line, fault.column) == place


@pytest.mark.parametrize(
    ("text", "message"),
    sample(
        [
            ("obstacles:\n  - {at: [0, 0], size: [0.5, 0.5, 0.3]}\n", "it would be in the robot"),
            ("obstacles:\n  - {ahead: 0.1}\n", "it would be in the robot"),
            ("obstacles:\n  - {at: [8, 0], radius: 0.1}\n", "(8, 0) is not on the floor of 4 m"),
            ("faults:\n  - at 3: spawn_box at (8, 0)\n", "(8, 0) is not on the floor of 4 m"),
            ("faults:\n  - after 3: spawn_cylinder at (0, -8)\n", "(0, -8) is not on the floor"),
            (
                "faults:\n  - 'when time > 1: move_box at (8, 0)'\n",
                "'box': (8, 0) is not on the floor",
            ),
            ("faults:\n  - at 0: spawn_box ahead 0.1\n", "it would be in the robot"),
        ],
        3,
    ),
)
def test_an_obstacle_without_a_place_is_an_error_before_the_start(
    scenario: Any, text: str, message: str
) -> None:
    """Where nothing is to be run, too; the run takes no step."""
    path, steps = scenario(text), []
    run = partial(run_scenario, before_step=lambda: steps.append(1))
    for find in (run, lambda file: look_for_names(load_scenario(file))):
        with pytest.raises(InputError) as caught:
            find(path)
        (fault,) = caught.value.diagnostics
        assert message in fault.message
        assert fault.line == 7
    assert not steps


def test_obstacles_of_the_start_are_tried_together(scenario: Any) -> None:
    """The second of one place is refused, unless the first is removed or a free place is taken."""
    box = "  - at 0: spawn_box at (1, 0)\n"
    with pytest.raises(InputError) as caught:
        look_for_names(load_scenario(scenario(f"faults:\n{box}{box}")))
    assert [fault.line for fault in caught.value.diagnostics] == [8]
    for other in (f"  - at 0: remove_box\n{box}", "  - at 1: move_box at (8, 0) nearest_free\n"):
        look_for_names(load_scenario(scenario(f"faults:\n{box}{other}")))


def test_runs_of_one_seed_are_the_same(scenario: Any) -> None:
    """To the last byte; another seed makes another trace."""
    path = scenario("faults:\n  - at 0.2: drop odom share 0.5 lasting 1\n")
    hashes = [run_scenario(path, seed=seed).report.trace_sha256 for seed in (1, 1, 2)]
    assert hashes[0] == hashes[1] != hashes[2]


def test_what_a_run_reaches_is_recorded_where_asked_for(scenario: Any) -> None:
    """The run stays the same to the last byte."""
    path = scenario()
    plain, recorded = run_scenario(path), run_scenario(path, with_coverage=True)
    assert plain.coverage is None
    assert recorded.coverage is not None
    assert recorded.coverage.reached == ("0 turn: reached", "0 turn: outcome succeeded")
    assert "0 turn: outcome canceled by timeout" in recorded.coverage.missing
    assert recorded.report.trace_sha256 == plain.report.trace_sha256


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
