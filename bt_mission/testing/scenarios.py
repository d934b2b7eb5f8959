"""The part of the plugin that runs tests with many seeds, and counts how many pass.

With pytest-xdist, the process that starts the workers counts and judges; what it needs to know of
a test travels in its reports.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING

import pytest

from bt_mission.testing.rates import Rates
from bt_mission.testing.seeds import (
    FAILING,
    MARKER,
    USAGE,
    failing_seeds,
    line_to_repeat,
    parametrize,
    seeded,
)

if TYPE_CHECKING:
    from _pytest.terminal import TerminalReporter

TITLE = "scenarios: seeds that passed, as a rate with its 95 % interval"


class Scenarios:
    """Hooks of one session."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._rates = Rates()
        self._is_worker = hasattr(config, "workerinput")
        text = f"{MARKER}(seeds, at_least=1.0): run with each seed, as in {USAGE}"
        config.addinivalue_line("markers", text)

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """One test for each seed."""
        parametrize(metafunc)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Put into the report what the counting needs; tell how to repeat a failure.

        A seed that fails where some may is reported as an expected failure: whether too many
        have, is known only at the end.
        """
        report = yield
        one = seeded(item)
        if one is None or hasattr(report, "wasxfail"):
            return report
        repeat = line_to_repeat(self._config, item.nodeid)
        report.__dict__["scenario"] = {
            "seed": one.seed,
            "test": one.test,
            "function": one.function,
            "at_least": one.at_least,
            "repeat": repeat,
            "failed": report.failed,
        }
        if report.failed:
            report.sections.append(("to repeat it", repeat))
            if one.at_least is not None and report.when == "call":
                report.outcome = "skipped"
                report.wasxfail = f"at least {one.at_least:.4g} of the seeds have to pass"
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count."""
        told = getattr(report, "scenario", None)
        if told is not None and not self._is_worker:
            self._rates.add(report, told)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self) -> Generator[None, object, object]:
        """Once all tests have run, fail those of which too few seeds have passed."""
        result = yield
        for rate in self._rates.missed:
            self._config.hook.pytest_runtest_logreport(report=rate.verdict())
        return result

    def pytest_terminal_summary(self, terminalreporter: TerminalReporter) -> None:
        """Show the rates."""
        if self._rates.run:
            terminalreporter.section(TITLE)
            for line in self._rates.summary():
                terminalreporter.line(line)

    @pytest.hookimpl(wrapper=True)
    def pytest_sessionfinish(self) -> Generator[None, object, object]:
        """Remember which seeds have failed, for the next session."""
        result = yield
        cache = getattr(self._config, "cache", None)
        if cache is None or self._is_worker or not self._rates.run:
            return result
        before = failing_seeds(self._config)
        after = self._rates.failing(before)
        if after != before:
            cache.set(FAILING, after)
        missed = self._rates.missed
        if missed:  # --lf knows single tests: name those that failed
            last = cache.get("cache/lastfailed", {})
            for rate in missed:
                last.pop(rate.test, None)
                last |= {one.nodeid: True for one in rate.failures()}
            cache.set("cache/lastfailed", last)
        return result
