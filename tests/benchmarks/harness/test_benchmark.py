"""What is declared of a benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.harness.benchmark import Aim, Benchmark, Figure, Target

FOLDER = Path("/somewhere")


def of(*commands: str, smoke: tuple[str, ...] = ("a.py",), names: tuple[str, ...] = ("*",)):
    """A benchmark with these commands and figures."""
    return Benchmark("a", "it", commands, smoke, tuple(map(Figure, names)))


def test_a_script_with_rounds_is_started_once():
    """It repeats by itself what it measures."""
    assert of("a.py --rounds {rounds}").processes(4, FOLDER, smoke=False) == [
        ["a.py", "--rounds", "4"]
    ]


def test_a_script_without_rounds_is_started_for_each():
    """So that there is a spread of every figure."""
    assert of("a.py", "b.py").processes(2, FOLDER, smoke=False) == [["a.py"], ["b.py"]] * 2


def test_the_smoke_is_started_once_whatever_the_rounds():
    """With its own words; a folder is filled in, quoted words stay together."""
    smoke = ("a.py --into {folder}/x --only 'two words'",)
    found = of("a.py", smoke=smoke).processes(9, FOLDER, smoke=True)
    assert found == [["a.py", "--into", "/somewhere/x", "--only", "two words"]]


def test_figures_that_are_missing_or_unknown_are_complained_of():
    """A star stands for any part of a name; what is optional may be missing."""
    benchmark = Benchmark(
        "a",
        "it",
        ("a.py",),
        ("a.py",),
        (Figure("* nodes"), Figure("x"), Figure("y", optional=True)),
    )
    assert benchmark.complaints(["10 nodes", "x"]) == []
    assert benchmark.complaints(["10 nodes", "z"]) == [
        "it has not given 'x'",
        "it has given 'z', which benchmarks/harness/catalogue.py does not declare",
    ]


def test_the_first_figure_that_covers_a_name_is_meant():
    """So an exception stands before the rule."""
    benchmark = of(names=("big: cost", "*: cost"))
    assert [benchmark.figure(name) for name in ("big: cost", "small: cost", "none")] == [
        Figure("big: cost"),
        Figure("*: cost"),
        None,
    ]


@pytest.mark.parametrize(
    ("kind", "value", "is_met"),
    [
        (Aim.AT_LEAST, 0.35, True),
        (Aim.AT_LEAST, 0.34, False),
        (Aim.AT_MOST, 0.35, True),
        (Aim.AT_MOST, 0.36, False),
        (Aim.OF_OLD, 0.36, False),
    ],
)
def test_a_target_is_met_on_its_side(kind, value, is_met):
    """The bound itself is enough."""
    assert Target(kind, must=0.35).is_met(value) is is_met


def test_an_aim_alone_is_not_judged():
    """It is what is hoped for."""
    assert Target(Aim.AT_MOST, aim=1).is_met(2) is None
