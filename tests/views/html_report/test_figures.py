"""What is reckoned from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bt_mission.core.text import seconds
from bt_mission.recording.model import RecordedRun
from bt_mission.views.html_report import figures
from bt_mission.views.html_report.markup import number
from bt_mission.views.html_report.timeline import LineChart, thinned

S = 1_000_000_000


def test_a_robot_that_stands_has_stopped(a_run: Callable[..., RecordedRun]) -> None:
    """But not before it has moved; turning on the spot is no standing."""
    (stop,) = figures.stops(a_run().truth)
    assert stop.start_ns == 6 * S
    assert stop.x == pytest.approx(0.8)
    assert stop.seconds == pytest.approx(5.0)
    turning = replace(a_run().truth, turn=np.full(201, 0.5))
    assert figures.stops(turning) == []


def test_leaves_are_counted(a_run: Callable[..., RecordedRun]) -> None:
    """Those that have run."""
    found = [(leaf.node, dict(leaf.ends), leaf.seconds) for leaf in figures.leaves(a_run())]
    assert found == [(1, {"success": 1}, 2.0), (2, {"halted": 1}, 5.0), (3, {"failure": 1}, 0.0)]


def test_the_way_to_the_failure_ends_at_a_leaf(a_run: Callable[..., RecordedRun]) -> None:
    """And is empty where nothing has failed."""
    run = a_run()
    assert figures.way_to_failure(run) == [0, 3]
    assert figures.way_to_failure(a_run(spans=((), *run.spans[1:]))) == []


def test_the_distance_is_the_simulations_where_it_knows(a_run: Callable[..., RecordedRun]) -> None:
    """Otherwise that of the poses."""
    assert figures.distance_m(a_run()) == pytest.approx(0.8)
    assert figures.distance_m(a_run(summary={"distance_travelled_m": 3.0})) == 3.0


def test_thinning_keeps_what_the_eye_would_miss() -> None:
    """One value among a hundred thousand."""
    values = np.zeros(100_000)
    values[54_321] = 1.0
    times, kept = thinned(LineChart("x", "m", np.arange(100_000), values))
    assert len(times) < 1500
    assert times[kept.argmax()] == 54_321


@pytest.mark.parametrize(
    ("value", "text"), [(0.05, "0.05 s"), (57.15, "57.15 s"), (185.2, "185.20 s")]
)
def test_lengths_of_time_are_for_people(value: float, text: str) -> None:
    """To the hundredth, as `run` prints them."""
    assert seconds(value) == text


@pytest.mark.parametrize(("value", "text"), [(1.0, "1"), (-0.0001, "0"), (1.23456, "1.235")])
def test_numbers_are_no_longer_than_they_need(value: float, text: str) -> None:
    """Three decimals at most."""
    assert number(value) == text
