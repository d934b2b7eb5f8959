"""Values of figures, round by round."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.harness.benchmark import Aim, Benchmark, Figure, Target
from benchmarks.harness.measurement import Given, Measurement, Spread, WrongCodeError, read_figures

ONE = Benchmark("one", "it", ("one.py",), ("one.py",), (Figure("cost"),))


def given(*values: float) -> dict[str, Given]:
    """What a round has given."""
    return {"cost": Given("ms", list(values))}


@pytest.mark.parametrize(
    ("values", "unit", "text"),
    [
        ((3, 1, 2), "ms", "2.00 ms (1.00 to 3.00)"),
        ((1234.6,), "us", "1235 us"),
        ((0.1234, 0.25), "", "0.187 (0.123 to 0.250)"),
        ((0, 0), "", "0"),
        ((float("inf"),), "s", "inf s"),
    ],
)
def test_a_spread_has_the_digits_that_say_something(values, unit, text):
    """And no brackets where all values look alike."""
    assert Spread.of(values).text(unit) == text


def test_ratios_are_of_rounds_in_which_both_were_measured():
    """New to old: the medians of each round."""
    measurement = Measurement(ONE)
    measurement.add(given(2, 4, 9), given(8))
    measurement.add(given(6))
    measurement.add(given(1), given(0))
    values = measurement.figures["cost"]
    assert values.new == [2, 4, 9, 6, 1]
    assert values.old == [8, 0]
    assert values.ratios == [0.5]


def test_a_target_of_the_old_one_is_judged_by_the_ratio():
    """And not at all where nothing was compared."""
    target = Target(Aim.OF_OLD, must=0.8)
    alone, beside = Measurement(ONE), Measurement(ONE)
    alone.add(given(1))
    beside.add(given(100), given(200))
    assert alone.figures["cost"].is_met(target) is None
    assert beside.figures["cost"].is_met(target) is True


def test_figures_of_several_processes_are_joined(tmp_path: Path):
    """Those with the same name are values of one figure."""
    code = tmp_path / "tree"
    file = tmp_path / "figures"
    lines = [("a", [1.0]), ("b", [2.0]), ("a", [3.0])]
    file.write_text(
        "".join(
            json.dumps(
                {"figure": name, "unit": "s", "values": values, "code": str(code / "bt_mission")}
            )
            + "\n"
            for name, values in lines
        ),
        encoding="utf-8",
    )
    assert read_figures(file, code) == {"a": Given("s", [1.0, 3.0]), "b": Given("s", [2.0])}


def test_a_process_that_measured_another_copy_is_refused(tmp_path: Path):
    """An installed copy would be compared with itself."""
    file = tmp_path / "figures"
    line = {"figure": "a", "unit": "", "values": [1], "code": "/usr/lib/bt_mission"}
    file.write_text(json.dumps(line), encoding="utf-8")
    with pytest.raises(WrongCodeError, match=r"imported /usr/lib/bt_mission: .* environment of"):
        read_figures(file, tmp_path)


def test_nothing_given_is_no_figure(tmp_path: Path):
    """The file is made by the first figure."""
    assert read_figures(tmp_path / "none", tmp_path) == {}
