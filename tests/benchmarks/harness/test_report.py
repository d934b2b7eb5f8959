"""Tables and JSON of what was measured."""

from __future__ import annotations

import json

from benchmarks.harness.benchmark import Aim, Benchmark, Figure, Target
from benchmarks.harness.measurement import Given, Measurement
from benchmarks.harness.report import document, machine_lines, markdown, step_table
from benchmarks.harness.running import Plan
from benchmarks.harness.tree import ROOT, Tree

NEW, OLD = Tree(ROOT, "abc", ()), Tree(ROOT, "old", ())
SPEED = Benchmark(
    "speed",
    "how fast",
    ("speed.py",),
    ("speed.py",),
    (
        Figure("*: share", Target(Aim.AT_LEAST, 0.35, 0.5), "share of bare"),
        Figure("start", Target(Aim.OF_OLD, 0.8), "the start"),
        Figure("size"),
    ),
)
MACHINE = {
    "processor": "a processor",
    "cores": 2,
    "python": "3.11.7",
    "mujoco": "4.0.0",
    "busy": 0,
    "load_before": 0.5,
    "load_after": 1.5,
}


def measured(*, old: bool) -> Measurement:
    """Two missions, the start and a size."""
    found = Measurement(SPEED, seconds=2.5)
    new = {
        "a: share": Given("", [0.4]),
        "b: share": Given("", [0.25, 0.25, 0.2]),
        "start": Given("s", [0.5]),
        "size": Given("MB", [3.0]),
    }
    before = {"a: share": Given("", [0.2]), "start": Given("s", [1.0])}
    found.add(new, before if old else None)
    return found


def test_the_table_has_a_row_for_each_figure():
    """With the unit, the spread, and whether the target is reached."""
    target = "at least 0.35 (aim: at least 0.5)"
    assert markdown(["on a machine"], [measured(old=False)], Plan(NEW)).splitlines() == [
        "on a machine",
        "",
        "| benchmark | figure | abc | target | reached |",
        "|---|---|---|---|---|",
        f"| speed | a: share | 0.400 | {target} | yes |",
        f"| speed | b: share | 0.250 (0.200 to 0.250) | {target} | **no** |",
        "| speed | start | 0.500 s | at most 0.8 x old |  |",
        "| speed | size | 3.00 MB |  |  |",
    ]


def test_the_table_of_targets_has_the_old_commit_beside_the_new():
    """Figures without a row of their own are not in it."""
    must = "at least 0.35 | at least 0.5"
    assert step_table([], [measured(old=True)], Plan(NEW, OLD)).splitlines() == [
        "",
        "| what | old | abc | new to old | must | aim | reached |",
        "|---|---|---|---|---|---|---|",
        f"| share of bare: a | 0.200 | 0.400 | 2.00 | {must} | yes |",
        f"| share of bare: b | none | 0.250 (0.200 to 0.250) |  | {must} | **no** |",
        "| the start | 1.00 s | 0.500 s | 0.500 | at most 0.8 x old |  | yes |",
    ]


def test_what_the_old_one_lacks_and_what_has_failed_stands_below():
    """In one line each."""
    found = measured(old=False)
    found.old_lacks = "old lacks it: no module 'x'"
    found.failures = ["speed.py ended with exit code 1:\n    Traceback"]
    assert markdown([], [found], Plan(NEW, OLD)).splitlines()[-2:] == [
        "- speed: old lacks it: no module 'x'",
        "- speed FAILED: speed.py ended with exit code 1",
    ]


def test_the_json_has_all_values():
    """And says what is not a number of JSON as null."""
    found = measured(old=True)
    found.figures["size"].new.append(float("inf"))
    text = json.dumps(document([found], Plan(NEW, OLD), dict(MACHINE)), allow_nan=False)
    told = json.loads(text)
    assert (told["format"], told["commit"], told["against"]) == (1, "abc", "old")
    (speed,) = told["benchmarks"]
    assert (speed["name"], speed["failures"], speed["seconds"]) == ("speed", [], 2.5)
    by_name = {one["name"]: one for one in speed["figures"]}
    assert by_name["start"] == {
        "name": "start",
        "unit": "s",
        "new": {"median": 0.5, "least": 0.5, "most": 0.5, "values": [0.5]},
        "old": {"median": 1.0, "least": 1.0, "most": 1.0, "values": [1.0]},
        "ratio": {"median": 0.5, "least": 0.5, "most": 0.5, "values": [0.5]},
        "target": {"kind": "at most, of the old one", "must": 0.8, "aim": None},
        "reached": True,
    }
    assert by_name["size"]["new"]["values"] == [3.0, None]
    assert by_name["size"]["old"] is None


def test_the_machine_is_told_with_its_load():
    """And that something computed beside it."""
    busy = {**MACHINE, "busy": 2}
    (line,) = machine_lines(busy, Plan(NEW, OLD))
    what, _, where = line.partition("; medians, in brackets the spread. ")
    assert what == "abc against old, in turns"
    machine, _, load = where.partition("; ")
    assert machine == "2 x a processor, Python 3.11.7, MuJoCo 4.0.0"
    assert load == "load 0.5 before, 1.5 after, 2 processes computing beside it."


def test_a_smoke_says_that_its_figures_mean_nothing():
    """Nobody is to copy them."""
    assert "mean nothing" in machine_lines(dict(MACHINE), Plan(NEW, smoke=True))[0]
