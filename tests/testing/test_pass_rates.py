from __future__ import annotations

import pytest

from bt_mission.testing.pass_rates import PassRates


def reported(seed: int, *, failed: bool = False, at_least: float | None = None, when="call"):
    """A report as ``scenarios`` leaves it; gives it with what was told."""
    tolerated = failed and at_least is not None
    report = pytest.TestReport(
        nodeid=f"a.py::test[seed{seed}]",
        location=("a.py", 4, f"test[seed{seed}]"),
        keywords={},
        outcome="passed" if not failed else "skipped" if tolerated else "failed",
        longrepr="it broke\nin the middle" if failed else None,
        when=when,
        sections=[("mission", "tree"), ("log", " ")],
    )
    answer = {
        "seed": seed,
        "test": "a.py::test",
        "function": "a.py::test",
        "at_least": at_least,
        "repeat": f"pytest 'a.py::test[seed{seed}]'",
        "failed": failed,
        "sample": "",
    }
    return report, answer


def counted(failing: list[int], total: int, at_least: float | None = None) -> PassRates:
    """Rates of one test."""
    rates = PassRates()
    for seed in range(total):
        rates.add(*reported(seed, failed=seed in failing, at_least=at_least))
    return rates


def test_failures_of_one_cause_are_one_line():
    """Their numbers aside, they have the same line; ten seeds are named, one can be repeated."""
    rates = PassRates()
    for seed in range(15):
        report, answer = reported(seed, failed=True)
        report.longrepr = "it fell" if seed == 7 else f"{seed / 3:.1f} m were left of 8"
        rates.add(report, answer)
    assert list(rates.summary())[1:] == [
        "  14 seeds: 0, 1, 2, 3, 4, 5, 6, 8, 9, 10 and 4 more: 0.0 m were left of 8",
        "    pytest 'a.py::test[seed0]'",
        "  seed 7: it fell",
        "    pytest 'a.py::test[seed7]'",
    ]


def test_many_causes_are_cut_short():
    """Ten of them, and how many seeds are left."""
    rates = PassRates()
    for seed in range(13):
        report, answer = reported(seed, failed=True)
        report.longrepr = "x" * (seed + 1)
        rates.add(report, answer)
    assert list(rates.summary())[-1] == "  and 3 seeds with other causes"


def test_a_seed_whose_fixture_fails_after_it_passed_has_failed():
    """A goal left behind, say."""
    rates = counted([], 2)
    rates.add(*reported(1, failed=True, when="teardown"))
    assert [sorted(rate.passed) for rate in rates.run] == [[0]]
    assert [sorted(rate.failed) for rate in rates.run] == [[1]]


def test_the_verdict_shows_the_failures():
    """All in a line for each cause, and the first seed of a cause in full, with its sections."""
    (missed,) = counted([1, 2, 3, 4], 5, at_least=1.0).missed
    verdict = missed.verdict()
    assert verdict.nodeid == "a.py::test"
    assert verdict.location == ("a.py", 4, "test")
    assert verdict.failed
    text = verdict.longreprtext
    assert text.startswith("1 of 5 passed: 0.200 (0.036 to 0.624), at least 1 wanted\n")
    assert "4 seeds: 1, 2, 3, 4: it broke\n  pytest 'a.py::test[seed1]'\n" in text
    assert "-------- seed 1 --------\nit broke\nin the middle\n---- mission ----\ntree" in text
    assert "seed 2 ----" not in text


def test_a_seed_that_failed_is_kept_until_it_passes():
    """Also one that did not run this time; other tests keep theirs."""
    before = {"a.py::test": [1, 2, 70], "b.py::test": [5]}
    assert counted([2, 4], 5).failing(before) == {"a.py::test": [2, 4, 70], "b.py::test": [5]}
    assert counted([], 5).failing({"a.py::test": [1, 2]}) == {}
