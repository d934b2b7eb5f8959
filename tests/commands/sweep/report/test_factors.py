"""How success depends on what was varied, as numbers and as figures."""

from __future__ import annotations

import json
import random

import numpy as np
import pytest

from bt_mission.commands.sweep.columns import SweepColumns
from bt_mission.commands.sweep.report.charts import (
    histogram_figure,
    pair_figure,
    plain,
    success_figure,
)
from bt_mission.commands.sweep.report.explanation import results_as_dict, short_between
from bt_mission.commands.sweep.report.factors import (
    MOST_LEVELS,
    MOST_NAMES,
    factor,
    factors_of,
    pairs_of,
    round_edges,
)
from bt_mission.scenarios.statistics import wilson
from tests.commands.sweep.conftest import some_rows
from tests.support.rows import failed, row


def passes(*values):
    """Rows that all differ: whether each has passed."""
    return SweepColumns([row(n) if first else failed(n) for n, first in enumerate(values)])


def test_each_number_is_a_level():
    """By size, with its rate and the interval of that."""
    made = factor("speed", [0.2, 0.1, 0.2, 0.2], passes(1, 0, 0, 1))
    assert made.is_number
    assert [(level.label, level.passed, level.total) for level in made.levels] == [
        ("0.1", 0, 1),
        ("0.2", 2, 3),
    ]
    assert made.levels[1].interval == wilson(2, 3)
    assert made.indices.tolist() == [1, 0, 1, 1]


def test_identical_rows_of_a_level_are_one_sample():
    """The rate is that of all rows, the interval as wide as for the distinct ones."""
    results = SweepColumns(
        [row(0, sample="5"), row(1, sample="5"), row(2, sample="6"), failed(3, sample="5")]
    )
    first, second = factor("speed", [0.1, 0.1, 0.1, 0.2], results).levels
    assert (first.total, first.samples, second.samples) == (3, 2, 1)
    assert first.interval == wilson(3, 3, 2)


def test_of_many_numbers_stretches_are_levels():
    """With round ends; each row is in one of them, the greatest too."""
    values = np.linspace(0.05, 0.25, 1000)
    made = factor("speed", values.tolist(), passes(*values > 0.1))
    assert len(made.levels) <= MOST_LEVELS
    assert (made.levels[0].label, made.levels[-1].label) == ("0.04\u20130.06", "0.24\u20130.26")
    assert sum(level.total for level in made.levels) == 1000
    assert made.levels[0].rate == 0
    assert made.levels[-1].rate == 1


@pytest.mark.parametrize(
    ("values", "is_number", "labels"),
    [
        (
            [*np.linspace(0, 1, 50), *np.linspace(9, 10, 50)],
            True,
            ["0\u20131", "1\u20132", "9\u201310"],
        ),
        ([True, False, True], False, ["true", "false"]),
        (["hall", None], False, ["hall"]),
    ],
    ids=["stretches without a row are left out", "truth is no number", "rows without a value"],
)
def test_what_is_a_level(values, is_number, labels):
    """Rows that an error has no value of are in none."""
    made = factor("x", values, passes(*[1] * len(values)))
    assert (made.is_number, [level.label for level in made.levels]) == (is_number, labels)
    assert [index < 0 for index in made.indices] == [value is None for value in values]


def test_of_very_many_names_the_worst_are_shown():
    """And it is known that others are not."""
    names = [f"w{number:03}" for number in range(MOST_NAMES * 2)]
    made = factor("world", names, passes(*(number % 2 for number in range(len(names)))))
    assert made.is_cut
    assert len(made.levels) == MOST_NAMES
    assert not any(level.passed for level in made.levels)


def test_parameters_with_several_values_and_plans_of_faults_are_factors():
    """What has one value is not varied, and has no chart."""
    columns = SweepColumns(row(n, parameters={"a": 1, "b": n % 2}) for n in range(4))
    assert [varied.name for varied in factors_of(columns)] == ["b"]
    assert pairs_of(columns) == ([], 0)
    of_all = factors_of(SweepColumns(some_rows()))
    assert [varied.name for varied in of_all] == ["speed", "world", "plan of faults"]


def test_pairs_count_each_cell():
    """Rows are levels of the second parameter, columns those of the first."""
    rows = [
        row(n, parameters={"a": a, "b": b}, passed=a == b)
        for n, (a, b) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 1)))
    ]
    ((pair,), left_out) = pairs_of(SweepColumns(rows))
    assert left_out == 0
    assert pair.total.tolist() == [[1, 0], [1, 2], [1, 0]]
    assert pair.passed.tolist() == [[1, 0], [0, 2], [0, 0]]


def test_the_pairs_that_tell_most_come_first():
    """That is where two parameters together decide what neither does alone."""
    rows = [
        row(n, parameters={"idle": n % 2, "a": n // 2 % 2, "b": n // 4 % 2},
            passed=(n // 2 % 2) != (n // 4 % 2))
        for n in range(8)
    ]  # fmt: skip
    (pair,), left_out = pairs_of(SweepColumns(rows), most=1)
    assert (pair.first.name, pair.second.name, left_out) == ("a", "b", 2)


@pytest.mark.parametrize(
    ("low", "high", "most"),
    [(0.05, 0.26, 9), (-1.3, 2.0, 12), (1e-9, 3e-9, 8), (0, 1e6, 40), (3, 3, 12)],
)
def test_ends_of_stretches_are_round(low, high, most):
    """They hold all values, are few enough, and 0 is one of them if it lies between."""
    edges = round_edges(low, high, most)
    assert edges[0] <= low
    assert edges[-1] >= high * (1 - 1e-9)
    assert len(edges) - 1 <= most
    if low <= 0 <= high:
        assert 0 in edges


# ---- figures: what Plotly is told, and that it takes it --------------------------------------


PASSED = SweepColumns([row(0), failed(1), row(2), row(3)])


def check(figure):
    """Have Plotly's own checks look at a figure, where it is installed; return it."""
    graph_objects = pytest.importorskip("plotly.graph_objects")
    graph_objects.Figure(json.loads(json.dumps(figure, allow_nan=False)))
    return figure


def test_success_over_numbers_is_a_curve_with_its_interval():
    """The band is between the interval's ends."""
    figure = check(success_figure(factor("speed", [0.1, 0.1, 0.2, 0.2], PASSED)))
    high, low, rate = figure["data"]
    assert (rate["x"], rate["y"]) == ([0.1, 0.2], [0.5, 1.0])
    assert low["y"][0] < 0.5 < high["y"][0]
    assert low["fill"] == "tonexty"


def test_success_by_names_is_bars_with_their_interval():
    """Whiskers reach from the rate to the interval's ends."""
    figure = check(success_figure(factor("world", ["a", "a", "b", "b"], PASSED)))
    (bars,) = figure["data"]
    assert bars["x"] == [0.5, 1.0]
    assert bars["error_x"]["array"][1] == 0.0
    assert figure["layout"]["yaxis"]["ticktext"] == ["a", "b"]


def test_a_pair_without_scenarios_is_an_empty_cell():
    """And not one of success 0."""
    columns = SweepColumns(
        varied for varied in some_rows() if varied.parameters != {"speed": 0.1, "world": "hall"}
    )
    pair = next(drawn for drawn in pairs_of(columns)[0] if drawn.second.name == "world")
    (heat,) = check(pair_figure(pair))["data"]
    hall = [level.label for level in pair.second.levels].index("hall")
    assert heat["z"][hall][0] is None
    assert heat["text"][hall][0] == ""
    assert "no scenario" in heat["customdata"][hall][0]


def test_a_share_in_a_cell_is_100_only_for_all():
    """One failure of a thousand shows."""
    columns = SweepColumns(some_rows())
    pair = pairs_of(columns)[0][0]
    pair.passed[0, 0], pair.total[0, 0] = 999, 1000
    (heat,) = pair_figure(pair)["data"]
    assert heat["text"][0][0] == "99"


def test_failed_runs_are_marked_in_a_distribution():
    """By colour and by hatching; together they are all runs that have a value."""
    values = np.array([-0.1, 0.2, 0.3, np.nan])
    figure = check(
        histogram_figure(values, np.array([False, True, True, True]), "m", marks_zero=True)
    )
    good, bad = figure["data"]
    assert (sum(good["y"]), sum(bad["y"])) == (2, 1)
    assert bad["marker"]["pattern"]["shape"]
    assert figure["layout"]["shapes"][0]["x0"] == 0


def test_no_bar_reaches_over_zero():
    """Else violated and held margins would be in one bar."""
    values = np.linspace(-0.013, 0.4, 500)
    figure = histogram_figure(values, values > 0, "m", marks_zero=True)
    good, bad = figure["data"]
    assert min(x for x, y in zip(good["x"], good["y"], strict=True) if y) > 0
    assert max(x for x, y in zip(bad["x"], bad["y"], strict=True) if y) < 0
    assert not any(g and b for g, b in zip(good["y"], bad["y"], strict=True))


def test_a_figure_does_not_grow_with_the_rows():
    """A hundred thousand values are some bars."""
    values = np.random.default_rng(1).normal(size=100_000)
    assert len(json.dumps(histogram_figure(values, values > 0, "m"))) < 10_000


def test_texts_are_no_markup_for_plotly():
    """Which takes some tags, and breaks lines at <br>."""
    name = '<a href="javascript:x">%{y}</a>'
    figure = success_figure(factor(name, [name, "b", "b", "b"], PASSED))
    texts = json.dumps(figure)
    assert "<a" not in texts
    assert all(
        "%{" not in trace["hovertemplate"].replace("%{text}", "") for trace in figure["data"]
    )


def test_a_long_text_is_cut():
    """A name of a thousand letters leaves room for the chart."""
    assert plain("x" * 100, 10) == "xxxxxxxxx…"
    assert plain("a\x1b\u202e") == "a\\x1b\\u202e"


# ---- the factor that explains a cause ----------------------------------------------------------


def explained(rows) -> list[str | None]:
    """What explains each cause, in words."""
    failures = results_as_dict(SweepColumns(rows))["failures"]
    return [failure["explained_by"] for failure in failures]


def drawn(count: int, fails, seed: int = 1):
    """Rows with two numbers and a name; those fail for which the function says so."""
    draw = random.Random(seed)
    for number in range(count):
        values: dict[str, object] = {
            "gap": round(draw.uniform(0, 1), 3),
            "speed": round(draw.uniform(0.1, 0.2), 3),
        }
        values["world"] = draw.choice(("hall", "yard"))
        made = failed if fails(values, draw) else row
        yield made(number, parameters=values)


def test_the_factor_that_decides_is_named_with_its_end():
    """In a sentence, with the share of the others beside it."""
    (sentence,) = explained(drawn(200, lambda values, _: values["gap"] < 0.4))
    assert sentence == "100 % of these have gap < 0.4 (0 % of the other runs)"


def test_a_factor_that_decides_mostly_is_named():
    """With the share that it explains."""

    def fails(values, draw):
        return draw.random() < (0.9 if values["world"] == "yard" else 0.05)

    (sentence,) = explained(drawn(200, fails))
    assert sentence == "97 % of these have world = yard (10 % of the other runs)"


def test_what_nature_has_drawn_explains_with_its_unit():
    """It is a factor as the parameters are."""
    rows = [
        (failed if number > 60 else row)(number, nature={"lidar_noise": number / 1000})
        for number in range(100)
    ]
    assert explained(rows) == [
        "100 % of these have lidar_noise >= 0.0605 m (0 % of the other runs)"
    ]


@pytest.mark.parametrize("seed", range(5))
def test_chance_explains_nothing(seed):
    """Where failures do not depend on a factor, nothing is said."""
    assert explained(drawn(100, lambda _, draw: draw.random() < 0.2, seed)) == [None]


def test_identical_runs_are_no_evidence():
    """Fifty seeds that change nothing are one run for each value."""
    rows = [
        (failed if speed else row)(2 * seed + speed, parameters={"speed": speed}, sample=f"{speed}")
        for seed in range(50)
        for speed in (0, 1)
    ]
    assert explained(rows) == [None]


def test_a_single_factor_value_or_failure_explains_nothing():
    """Neither where nothing varies, nor where too little has failed."""
    assert explained(failed(n, parameters={"speed": 1}, passed=False) for n in range(9)) == [None]
    rows = [row(n, parameters={"a": n}) for n in range(50)]
    assert explained([*rows, failed(50, parameters={"a": 50})]) == [None]


@pytest.mark.parametrize(
    ("low", "high", "result"),
    [(0.391, 0.412, 0.4), (1, 2, 2), (-3.01, -2.99, -3), (0.1, 0.1001, 0.1001)],
)
def test_the_end_is_short(low, high, result):
    """As few digits as lie between two neighbours."""
    assert short_between(low, high) == result
