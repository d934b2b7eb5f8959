"""Figures as data: what Plotly is told, and that it takes it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bt_mission.sweeps.columns import SweepColumns
from bt_mission.sweeps.report.charts import (
    histogram_figure,
    pair_figure,
    plain,
    success_figure,
)
from bt_mission.sweeps.report.factors import factor, factors_of, pairs_of
from tests.sweeps.conftest import some_rows
from tests.sweeps.rows import failed, row

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


def test_all_factors_of_a_sweep_have_figures():
    """Parameters and plans of faults."""
    made = factors_of(SweepColumns(some_rows()))
    assert [made_factor.name for made_factor in made] == ["speed", "world", "plan of faults"]
    for made_factor in made:
        check(success_figure(made_factor))
