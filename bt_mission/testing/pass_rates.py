"""How many seeds of a scenario passed, with what certainty, and which did not."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from bt_mission.scenarios.statistics import samples_as_text, wilson

SHOWN_IN_FULL = 3
SHOWN_IN_LINES = 10
SHOWN_SEEDS = 10
_NUMBER = re.compile(r"\d+(\.\d+)?")


@dataclass(frozen=True)
class Failure:
    """A seed that failed.

    Args:
        repeat: What to type to run it again.
        line: Why, in one line.
        text: The report of the test; none where it has been shown as an error.
    """

    seed: int
    nodeid: str
    repeat: str
    line: str
    text: str


@dataclass
class PassRate:
    """The results of one test with several seeds."""

    test: str
    function: str
    at_least: float | None
    location: tuple[str, int | None, str]
    passed: set[int] = field(default_factory=set)
    failed: dict[int, Failure] = field(default_factory=dict)
    samples: dict[int, str] = field(default_factory=dict)
    """By seed, a text that is equal for seeds whose runs have the same outcomes and signals."""

    @property
    def total(self) -> int:
        """How many seeds ran."""
        return len(self.passed) + len(self.failed)

    @property
    def reached(self) -> bool:
        """Did enough of them pass?"""
        wanted = 1.0 if self.at_least is None else self.at_least
        return len(self.passed) >= wanted * self.total - 1e-9

    @property
    def distinct(self) -> int:
        """How many of the seeds gave runs that differ; seeds without a run count each."""
        return len({self.samples.get(seed) or seed for seed in (*self.passed, *self.failed)})

    @property
    def line(self) -> str:
        """The rate, its interval, how many runs are distinct, and the rate that is required."""
        low, high = wilson(len(self.passed), self.total, self.distinct)
        wanted = "" if self.at_least is None else f", at least {self.at_least:.4g} wanted"
        distinct = samples_as_text(self.total, self.distinct)
        return (
            f"{len(self.passed)} of {self.total} passed: {len(self.passed) / self.total:.3f} "
            f"({low:.3f} to {high:.3f}){wanted}{distinct and '; '}{distinct}"
        )

    def add(self, report: pytest.TestReport, summary: dict[str, Any]) -> None:
        """Count the outcome of one phase of one seed's test."""
        seed = summary["seed"]
        if summary["sample"]:
            self.samples[seed] = summary["sample"]
        if summary["failed"]:
            self.passed.discard(seed)
            text = _text(report) if report.when == "call" else ""
            failure = Failure(seed, report.nodeid, summary["repeat"], _why(report), text)
            self.failed.setdefault(seed, failure)
        elif report.when == "call" and report.passed and seed not in self.failed:
            self.passed.add(seed)

    def failures(self) -> list[Failure]:
        """The seeds that failed, in their order."""
        return [self.failed[seed] for seed in sorted(self.failed)]

    def verdict(self) -> pytest.TestReport:
        """The report of the test as a whole, where too few seeds passed: a seed of each cause."""
        causes = _by_cause([failure for failure in self.failures() if failure.text])
        parts = [self.line, *_lines(causes)]
        for first, *_ in causes[:SHOWN_IN_FULL]:
            parts += ["", f"-------- seed {first.seed} --------", first.text]
        return pytest.TestReport(
            nodeid=self.test,
            location=self.location,
            keywords={},
            outcome="failed",
            longrepr="\n".join(parts).rstrip(),
            when="call",
        )


@dataclass
class PassRates:
    """The rates of all scenarios of a session."""

    by_test: dict[str, PassRate] = field(default_factory=dict)

    def add(self, report: pytest.TestReport, summary: dict[str, Any]) -> None:
        """Count a report, with what ``scenarios`` has put into it."""
        test = summary["test"]
        if test not in self.by_test:
            path, line, name = report.location
            place = (path, line, name.partition("[")[0] + test[len(summary["function"]) :])
            self.by_test[test] = PassRate(test, summary["function"], summary["at_least"], place)
        self.by_test[test].add(report, summary)

    def __bool__(self) -> bool:
        return bool(self.run)

    @property
    def run(self) -> list[PassRate]:
        """Those of which at least one seed ran to an end."""
        return [rate for rate in self.by_test.values() if rate.total]

    @property
    def missed(self) -> list[PassRate]:
        """Tests that allow some seeds to fail, of which too few passed."""
        return [rate for rate in self.run if rate.at_least is not None and not rate.reached]

    def summary(self) -> Iterator[str]:
        """A line for each test, and one for each cause of failures, with how to repeat it."""
        width = max(len(rate.test) for rate in self.run)
        for rate in sorted(self.run, key=lambda pass_rate: pass_rate.test):
            yield f"{rate.test:{width}}  {rate.line}"
            yield from (f"  {line}" for line in _lines(_by_cause(rate.failures())))

    def failing(self, before: dict[str, list[int]]) -> dict[str, list[int]]:
        """The seeds that are to run first next time: those that failed and have not passed since.

        Args:
            before: Those of the time before, by the test's node id.
        """
        passed: dict[str, set[int]] = {}
        failed: dict[str, set[int]] = {}
        for rate in self.run:
            passed.setdefault(rate.function, set()).update(rate.passed)
            failed.setdefault(rate.function, set()).update(rate.failed)
        after = dict(before)
        for function, good in passed.items():
            now = sorted((set(before.get(function, ())) - good) | failed[function])
            if now:
                after[function] = now
            else:
                after.pop(function, None)
        return after


def _by_cause(failures: list[Failure]) -> list[list[Failure]]:
    """Return failures in groups whose lines differ in numbers only, the largest group first."""
    groups: dict[str, list[Failure]] = {}
    for failure in failures:
        groups.setdefault(_NUMBER.sub("#", failure.line), []).append(failure)
    return sorted(groups.values(), key=len, reverse=True)


def _lines(causes: list[list[Failure]]) -> Iterator[str]:
    for failures in causes[:SHOWN_IN_LINES]:
        seeds = ", ".join(str(failure.seed) for failure in failures[:SHOWN_SEEDS])
        more = f" and {len(failures) - SHOWN_SEEDS} more" if len(failures) > SHOWN_SEEDS else ""
        noun = "seed" if len(failures) == 1 else f"{len(failures)} seeds:"
        yield f"{noun} {seeds}{more}: {failures[0].line}"
        yield f"  {failures[0].repeat}"
    if len(causes) > SHOWN_IN_LINES:
        rest = sum(map(len, causes[SHOWN_IN_LINES:]))
        yield f"and {rest} seeds with other causes"


def _why(report: pytest.TestReport) -> str:
    crash = getattr(report.longrepr, "reprcrash", None)
    message = str(crash.message if crash else report.longreprtext)
    return message.strip().split("\n", 1)[0][:100]


def _text(report: pytest.TestReport) -> str:
    shown = [(name, text) for name, text in report.sections if text.strip()]
    return "\n".join(
        [report.longreprtext, *(f"---- {name} ----\n{text.rstrip()}" for name, text in shown)]
    )
