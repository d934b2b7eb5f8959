"""The factor that explains a cause."""

from __future__ import annotations

import random

import pytest

from bt_mission.sweeps.columns import SweepColumns
from bt_mission.sweeps.report.explanation import results_as_dict, short_between
from tests.sweeps.rows import failed, row


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
