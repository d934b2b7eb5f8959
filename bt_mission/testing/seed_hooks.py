"""The part of the plugin that runs tests with many seeds, and counts how many pass.

This module is imported in every session of pytest, and the rest when the first such test is found.

With pytest-xdist, the process that starts the workers counts and judges; what it needs to know of
a test travels in its reports.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import asdict
from typing import TYPE_CHECKING

import pytest

from bt_mission.base.text import escape_control
from bt_mission.testing.options import MARKER

if TYPE_CHECKING:
    from _pytest.terminal import TerminalReporter

    from bt_mission.testing.pass_rates import PassRates

TITLE = "scenarios: seeds that passed, as a rate with its 95 % interval"


class SeedHooks:
    """Hooks of one session."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._rates: PassRates | None = None
        self._is_worker = hasattr(config, "workerinput")
        text = f"{MARKER}(seeds, at_least=1.0): run with each seed (bt-mission: testing.md)"
        config.addinivalue_line("markers", text)

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """One test for each seed."""
        if metafunc.definition.get_closest_marker(MARKER) is not None:
            from bt_mission.testing.seeds import parametrize

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
        if item.get_closest_marker(MARKER) is None:
            return report
        from bt_mission.testing.results import sample_of_runs
        from bt_mission.testing.seeds import line_to_repeat, seeded

        test_seed = seeded(item)
        if test_seed is None or hasattr(report, "wasxfail"):
            return report
        repeat = line_to_repeat(self._config, item.nodeid)
        report.__dict__["scenario"] = asdict(test_seed) | {
            "repeat": repeat,
            "failed": report.failed,
            "sample": sample_of_runs(item) if report.when == "call" else "",
        }
        if report.failed:
            report.sections.append(("to repeat it", repeat))
            if test_seed.at_least is not None and report.when == "call":
                report.outcome = "skipped"
                report.wasxfail = f"at least {test_seed.at_least:.4g} of the seeds have to pass"
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count what a report says of a seed."""
        summary = getattr(report, "scenario", None)
        if summary is None or self._is_worker:
            return
        if self._rates is None:
            from bt_mission.testing.pass_rates import PassRates

            self._rates = PassRates()
        self._rates.add(report, summary)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Generator[None, object, object]:
        """Once all tests have run, fail those of which too few seeds have passed.

        Each such report counts as one more test, so that the progress is 100 % at the end.
        """
        result = yield
        for rate in self._rates.missed if self._rates else ():
            session.testscollected += bool(session.testscollected)
            self._config.hook.pytest_runtest_logreport(report=rate.verdict())
        return result

    def pytest_terminal_summary(self, terminalreporter: TerminalReporter) -> None:
        """Show the rates."""
        if self._rates:
            terminalreporter.section(TITLE)
            for line in self._rates.summary():
                terminalreporter.line(escape_control(line))

    @pytest.hookimpl(wrapper=True)
    def pytest_sessionfinish(self) -> Generator[None, object, object]:
        """Remember which seeds have failed, for the next session."""
        result = yield
        cache = getattr(self._config, "cache", None)
        if cache is not None and self._rates:
            _remember(cache, self._rates)
        return result


def _remember(cache: pytest.Cache, rates: PassRates) -> None:
    from bt_mission.testing.seeds import FAILING, failing_seeds

    before = failing_seeds(cache)
    after = rates.failing(before)
    if after != before:
        cache.set(FAILING, after)
    if rates.missed:  # --lf knows single tests: name those that failed
        last = cache.get("cache/lastfailed", {})
        for rate in rates.missed:
            last.pop(rate.test, None)
            last |= {failure.nodeid: True for failure in rate.failures()}
        cache.set("cache/lastfailed", last)
