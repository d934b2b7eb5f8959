"""Rows are added up one by one, and come to the same in any order."""

from __future__ import annotations

import json
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from bt_mission.base.verdicts import VERDICTS
from bt_mission.commands.sweep.columns import PLAN, SweepColumns
from bt_mission.commands.sweep.report.explanation import MOST_VALUES, results_as_dict
from bt_mission.commands.sweep.summary import MOST_GROUPS, percent
from bt_mission.scenarios.statistics import wilson
from tests.commands.sweep.conftest import write_results
from tests.support.rows import LOST, failed, margin, row


def test_of_nothing_there_is_no_rate():
    """A sweep without rows has neither a rate nor an interval."""
    reported = results_as_dict(SweepColumns([]))
    assert reported["scenarios"] == 0
    assert reported["success_rate"] is None
    assert reported["interval"] is None


def test_successes_failures_and_errors_are_counted():
    """What could not run is neither a success nor a failure, and lowers the rate."""
    rows = [row(0), row(1), failed(2), row(3, outcome="error", passed=False, reason="no world")]
    reported = results_as_dict(SweepColumns(rows))
    counted = [reported[name] for name in ("scenarios", "succeeded", "failed", "errors")]
    assert counted == [4, 2, 1, 1]
    assert reported["success_rate"] == 0.5
    assert reported["interval"] == wilson(2, 4)


def test_goals_collisions_and_times_are_added():
    """Where the collisions of a run are unknown, they add nothing."""
    rows = [
        row(0, collisions=2, orphaned_goals=1, virtual_s=10.5),
        row(1, collisions=None, orphaned_goals=2, distance_m=None),
    ]
    reported = results_as_dict(SweepColumns(rows))
    assert (reported["collisions"], reported["orphaned_goals"]) == (2, 3)
    assert (reported["virtual_s"], reported["distance_m"]) == (30.5, 2.0)


def test_values_of_a_parameter_are_in_order():
    """Numbers by size and not by their texts; true and 1 are two values."""
    values = [10, 9.5, "b", True, 1]
    rows = [row(number, parameters={"speed": value}) for number, value in enumerate(values)]
    reports = results_as_dict(SweepColumns(rows))["parameters"]["speed"]
    assert [report["value"] for report in reports] == [1, 9.5, 10, True, "b"]


def test_very_many_values_are_told_by_stretches():
    """A sampled parameter has no line for each draw; no scenario is left out."""
    rows = [
        row(n, passed=n % 2 == 0, parameters={"speed": n / 1000}) for n in range(MOST_VALUES * 3)
    ]
    reports = results_as_dict(SweepColumns(rows))["parameters"]["speed"]
    assert len(reports) == MOST_VALUES
    assert (reports[0]["from"], reports[0]["to"]) == (0.0, 0.002)
    assert sum(report["scenarios"] for report in reports) == len(rows)
    assert sum(report["succeeded"] for report in reports) == len(rows) // 2


def test_plans_are_counted_by_name():
    """Scenarios without a plan of faults have no line."""
    rows = [row(0, plan="lost"), failed(1, plan="lost"), row(2)]
    reported = results_as_dict(SweepColumns(rows))["plans"]
    assert {name: first["succeeded"] for name, first in reported.items()} == {"lost": 1}


def test_failures_are_grouped_by_leaf_and_reason():
    """The most frequent comes first; its example is the run with the smallest number."""
    rows = [failed(5), failed(3), failed(1, failed_path="explore > drive", failed_node="drive")]
    groups = SweepColumns(rows).tally.failures
    assert [(group.count, group.node, group.example.number) for group in groups] == [
        (2, "look around", 3),
        (1, "drive", 1),
    ]
    assert groups[0].reason == LOST


def test_numbers_in_a_reason_make_no_group_of_their_own():
    """A measured value differs from run to run, whole or not; an error code is a name."""
    reasons = ["108 deg remained (code 902)", "1.5 deg remained (code 902)", "3 deg (code 903)"]
    groups = SweepColumns(failed(n, reason=text) for n, text in enumerate(reasons)).tally.failures
    assert [(group.count, group.reason) for group in groups] == [
        (2, "… deg remained (code 902)"),
        (1, "3 deg (code 903)"),
    ]


def test_failed_missions_and_violated_requirements_are_apart():
    """Each group has a kind; a violation is named by the requirement that was violated first."""
    late = replace(margin(-1), at=5.0)
    violations = {"slow": late, "clear": margin(-0.1), "held": margin(0.2)}
    rows = [row(0, passed=False, requirements=violations), failed(1, requirements=violations)]
    tally = SweepColumns(rows).tally
    assert tally.count.failed == 2
    assert [(group.kind, group.path, group.reason) for group in tally.failures] == [
        ("failed", "explore > look around", LOST),
        ("violated", "", "requirement violated: clear"),
    ]


def test_runs_that_are_identical_count_as_one_sample():
    """In words and in the interval; the rate is that of all runs."""
    count = SweepColumns(row(n, sample="00000000000000ab") for n in range(4)).tally.count
    assert (count.scenarios, count.samples) == (4, 1)
    assert count.interval == wilson(1, 1)
    assert str(count) == (
        "4 of 4 succeeded (100.0 %; 95 % confidence interval 20.7 to 100.0 %); "
        "4 runs, 1 distinct: the seed changes nothing"
    )


def test_what_was_varied_is_said_to_change_nothing():
    """Where parameters differ, too, it is not the seed alone."""
    rows = [row(n, sample="ab", parameters={"speed": n}) for n in range(3)]
    reported = "3 runs, 1 distinct: what was varied changes nothing"
    assert SweepColumns(rows).tally.count.samples_in_words == reported


def test_kinds_of_failures_are_bounded():
    """Reasons that all differ do not fill the memory; each failure is still counted."""
    rows = [failed(n, reason=f"goal g{n} lost") for n in range(MOST_GROUPS + 20)]
    groups = SweepColumns(rows).tally.failures
    assert len(groups) == MOST_GROUPS + 1
    assert (groups[-1].count, groups[-1].reason) == (20, "other reasons")


def test_the_smallest_margin_of_each_requirement_is_kept():
    """With the scenario that had it; verdicts are counted."""
    vacuous = margin(-9.0, "not exercised")
    rows = [
        row(0, requirements={"keeps clear": margin(0.3), "looks": margin(None)}),
        failed(1, requirements={"keeps clear": margin(-0.2), "looks": margin(None, "open")}),
        failed(2, requirements={"keeps clear": vacuous, "looks": vacuous}),
    ]
    reported = results_as_dict(SweepColumns(rows))["requirements"]
    counts = dict.fromkeys(VERDICTS, 0) | {"holds": 1, "violated": 1, "not exercised": 1}
    least = {"least_margin": -0.2, "unit": "m", "scenario": rows[1].id}
    assert reported["keeps clear"] == counts | least | {"interval": wilson(1, 2)}
    assert reported["looks"]["least_margin"] is None


def test_the_order_of_rows_does_not_matter():
    """Workers give their rows in any order."""
    rows = [
        failed(
            n,
            reason=f"{n % 3}.5 m away",
            passed=n % 4 == 0,
            plan=f"plan {n % 2}",
            parameters={"speed": n % 5},
            requirements={"keeps clear": margin(0.01 * (n % 7))},
        )
        for n in range(60)
    ]
    reported = json.dumps(results_as_dict(SweepColumns(rows)))
    Random(1).shuffle(rows)
    assert json.dumps(results_as_dict(SweepColumns(rows))) == reported


@pytest.mark.parametrize(
    ("share", "text"),
    [(1, "100.0 %"), (0, "0.0 %"), (0.987, "98.7 %"), (0.99999, "99.999 %"), (1e-5, "0.001 %")],
)
def test_a_rare_failure_does_not_vanish_by_rounding(share, text):
    """Only all is 100 %, and only none is 0 %."""
    assert percent(share) == text


def test_the_count_as_text():
    """In a line: the count, the rate and its interval."""
    text = str(SweepColumns([row(n, passed=n > 12) for n in range(1000)]).tally.count)
    assert text == ("987 of 1,000 succeeded (98.7 %; 95 % confidence interval 97.8 to 99.2 %)")


# ---- rows as arrays, and which of them are worth a look -----------------------------------------


def test_columns_have_a_value_for_each_row():
    """Also where rows have other parameters and requirements; an infinite margin is none."""
    columns = SweepColumns(
        [
            row(0, parameters={"speed": 0.1}),
            failed(1, parameters={"world": "hall"}, plan="lost"),
            row(2, requirements={"clear": margin(0.5)}),
            row(3, requirements={"clear": margin(float("inf"))}, outcome="error", passed=False),
        ]
    )
    assert columns.values == {
        "speed": [0.1, None, None, None],
        "world": [None, "hall", None, None],
        PLAN: [None, "lost", None, None],
    }
    assert np.array_equal(columns.margins("clear"), [np.nan, np.nan, 0.5, np.nan], equal_nan=True)
    assert columns.passed.tolist() == [True, False, True, False]
    assert columns.ran.tolist() == [True, True, True, False]
    assert columns.seconds.tolist() == [20.0, 2.95, 20.0, 20.0]


def clear(*metres, **others):
    """Rows with these margins of one requirement, and some of others."""
    return [
        row(
            n,
            requirements={"clear": margin(first)} | {name: its[n] for name, its in others.items()},
        )
        for n, first in enumerate(metres)
    ]


@pytest.mark.parametrize(
    ("rows", "most", "order"),
    [
        ([*clear(0.01), failed(1), row(2)], 20, [1, 0, 2]),
        (clear(0.3, 0.1, 0.2), 2, [1, 2]),
        (clear(0.4, 0.6, 0.5, late=[margin(s, unit="s") for s in (50.0, 5.0, 55.0)]), 1, [1]),
        (clear(0.3, 0.1, 0.2, no_collision=[margin(0.0, unit="")] * 3), 20, [1, 2, 0]),
        (
            [
                *map(failed, range(50)),
                failed(50, reason="the base is worn out", failed_node="drive"),
            ],
            2,
            [0, 50],
        ),
        ([row(0, outcome="error", passed=False)], 20, []),
        ([*clear(0.2, 0.1), row(2)], 20, [1, 0, 2]),
    ],
    ids=[
        "failed runs come first, however small the margins of the others are",
        "the smallest margin is the worst",
        "metres and seconds are compared by their means",
        "a margin that is always the same tells nothing",
        "a frequent failure does not hide a rare one",
        "what could not run is left out",
        "runs without a margin are the best",
    ],
)
def test_the_worst_come_first(rows, most, order):
    """Of each kind of failure one is taken in turn, then the smallest margins."""
    assert [int(row_id, 16) for row_id in SweepColumns(rows).worst(most)] == order


def test_the_requirement_that_counts_is_named():
    """Its margin is the one that is shown."""
    late = [margin(seconds) for seconds in (50.0, 5.0, 55.0)]
    rows = clear(0.4, 0.6, 0.5, late=late, same=[margin(0.0)] * 3)
    result = SweepColumns(rows)
    assert [result.nearest(known) for known in rows] == ["clear", "late", "clear"]
    assert result.nearest(row(9)) is None


def test_the_rows_are_read_from_the_results(tmp_path):
    """In the order of the ids."""
    store = write_results(tmp_path / "r", [row(0), failed(1), failed(2)], None)
    assert [worst.number for worst in SweepColumns(store.rows()).worst_rows(store, 2)] == [1, 2]
