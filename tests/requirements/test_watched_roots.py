"""Requirements that are evaluated together, against each by itself."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

import pytest

from bt_mission.language.requirements.formula import Formula, Requirement
from bt_mission.language.requirements.syntax import SignalValue
from bt_mission.requirements.comparisons import Reader
from bt_mission.requirements.monitor import Monitor, Monitors, RequirementResult
from tests.requirements.test_semantics import checked_formula, drawn_formula

STEP_NS = 50_000_000
BATCHES = 8
SETS = 150
SIMPLE = (
    "always x < {}",
    "never x > {}",
    "always y > {}",
    "eventually y > {}",
    "eventually within 0.3 s: x > {}",
    "always for 0.3 s: y >= {}",
    "always between 0.1 s and 0.4 s: x <= {}",
    "whenever x > {}: previously running('a')",
    "whenever y > {}: x < 0 within 0.2 s",
    "always running('a')",
    "eventually not running('a')",
)


class SharedSignals:
    """Signals whose values a test sets, each with one reader for all."""

    def __init__(self) -> None:
        self.values: dict[str, float | bool | None] = {}
        self.reads: dict[str, int] = {}
        self._readers: dict[str, Reader] = {}

    def reader(self, signal: SignalValue) -> Reader | str:
        """Return what reads a signal."""
        key = signal.key

        def read() -> float | bool | None:
            self.reads[key] = self.reads.get(key, 0) + 1
            return self.values[key]

        return self._readers.setdefault(key, read)

    def at_least(self, _signal: SignalValue) -> Callable[[], float | None] | None:
        """None of them has a bound that costs less."""
        return None


def requirements(*texts: str) -> list[Requirement]:
    """Return requirements with these formulas, named by their numbers."""
    return [Requirement(f"{n}", text, Formula(text).root) for n, text in enumerate(texts)]


def drawn_set(draw: random.Random) -> list[Requirement]:
    """Up to eight requirements, most of them simple ones."""
    texts = []
    for _ in range(draw.randint(1, 8)):
        simple = draw.choice(SIMPLE).format(draw.choice((-1, 0, 0.5, 1)))
        texts.append(simple if draw.random() < 0.7 else drawn_formula(draw))
    return requirements(*(text for text in texts if checked_formula(text) is not None))


def drawn_values(draw: random.Random) -> list[dict[str, float | bool | None]]:
    """Signals at every control step: noise, plain numbers of which many are equal, and gaps.

    Some creep, by steps that a margin may be too coarse to show.
    """
    kind = draw.choice(("noise", "noise", "plain", "plain", "creeping"))
    has_gaps = draw.random() < 0.3
    place, ahead = draw.uniform(-0.1, 0.1), draw.choice((-1, 1))

    def number() -> float | None:
        nonlocal place
        if has_gaps and draw.random() < 0.2:
            return None
        if kind == "creeping":
            place += draw.choice((0, 1e-18, 1e-17, 3e-10, 1e-3)) * draw.choice(
                (ahead, ahead, -ahead)
            )
            return place
        return draw.gauss(0, 1) if kind == "noise" else draw.randint(-2, 2) / 2

    return [
        {"x": number(), "y": number(), "running('a')": draw.random() < 0.5}
        for _ in range(draw.randint(1, 40))
    ]


def _teller(told: list[str]) -> Callable[[Requirement, RequirementResult], None]:
    return lambda one, _: told.append(one.name)


@pytest.mark.parametrize("batch", range(BATCHES))
def test_together_they_come_to_what_each_comes_to_alone(batch: int) -> None:
    """Verdicts, margins and instants are the same at any step, and are told in the same order."""
    draw = random.Random(f"together {batch}")
    for _ in range(SETS):
        wanted, signals = drawn_set(draw), SharedSignals()
        looks_often = draw.random() < 0.5
        alone = [Monitor(one, signals) for one in wanted]
        told: list[str] = []
        together = Monitors(wanted, signals, _teller(told))
        expected: list[str] = []
        for step, values in enumerate(drawn_values(draw)):
            signals.values = values
            before = [one.violated_ns for one in alone]
            for monitor in alone:
                monitor.step(step * STEP_NS)
            together.step(step * STEP_NS)
            expected += [
                one.requirement.name
                for one, was_ns in zip(alone, before, strict=True)
                if one.violated_ns != was_ns
            ]
            assert told == expected
            if looks_often or draw.random() < 0.1:  # what nobody asks for may be left for later
                assert together.results == tuple(one.result for one in alone)
        is_complete = draw.random() < 0.5
        for monitor in alone:
            monitor.finish(is_complete=is_complete)
        together.finish(is_complete=is_complete)
        assert together.results == tuple(one.result for one in alone)


def reads_of(texts: Sequence[str], values: Sequence[dict[str, float | bool | None]]) -> int:
    """Return how often signals are read at the last of these instants."""
    signals = SharedSignals()
    monitors = Monitors(requirements(*texts), signals)
    for step, signals.values in enumerate(values):
        signals.reads.clear()
        monitors.step(step * STEP_NS)
    return sum(signals.reads.values())


def test_a_value_is_read_once_for_all() -> None:
    """However many requirements compare it, and also where it was never as good, or as bad."""
    texts = [f"always x < {limit}" for limit in range(1, 21)]
    assert reads_of(texts, [{"x": 0.5}, {"x": 0.4}]) == 1
    assert reads_of(texts, [{"x": 0.5}, {"x": 0.6}]) == 1


def test_what_nothing_can_change_any_more_reads_nothing() -> None:
    """As a violation without a measure, an event that has come about, and a window that is over."""
    done: dict[str, float | bool | None] = {"running('a')": True, "x": 1.0}
    assert reads_of(["never running('a')"], [done, done]) == 0
    assert reads_of(["eventually running('a')"], [done, done]) == 0
    assert reads_of(["always for 0.05 s: x > 0"], [done, done, done]) == 0
    assert reads_of(["whenever x > 0: previously running('a')"], [done, done]) == 0
    assert reads_of(["whenever x > 0: previously running('a')"], [done]) > 0
