"""The search for the last instant at which a change saves a run."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from bt_mission.commands.fork.source import ForkSource, read_source
from bt_mission.commands.fork.sweep import SweepResult, Try, sweep
from tests.support.recordings import recording


@cache
def source() -> ForkSource:
    """A recorded run."""
    return read_source(recording())


def swept(is_saved: Callable[[int], bool], most: int = 100) -> tuple[list[int], SweepResult]:
    """What a sweep finds where forks come out so, and the steps that it tried, by their numbers."""
    numbers = {step_ns: number for number, step_ns in enumerate(source().steps_ns)}

    def attempt(step_ns: int) -> Try:
        saved = is_saved(numbers[step_ns])
        return Try(step_ns, source().seconds(step_ns), "success", "", 1.0, saved)

    tries = sweep(source(), attempt, most)
    tried = []
    while True:
        try:
            tried.append(numbers[next(tries).step_ns])
        except StopIteration as end:
            return tried, end.value


@pytest.mark.parametrize("last", [0, 1, 7, 30, 60])
def test_the_last_step_is_found_where_earlier_is_better(last: int) -> None:
    """And the one after it was tried."""
    tried, result = swept(lambda number: number <= last)
    assert result.last is not None
    assert result.next is not None
    steps = source().steps_ns
    assert (result.last.step_ns, result.next.step_ns) == (steps[last], steps[last + 1])
    assert len(tried) == len(set(tried)) == len(result.tries)


def test_every_step_at_which_a_node_changed_is_tried_from_the_last_one_back() -> None:
    """Where none saves the run, all of them."""
    tried, result = swept(lambda _: False)
    assert (result.last, result.skipped) == (None, 0)
    assert tried == sorted(tried, reverse=True)
    assert tried[-1] == 0
    more, _ = swept(lambda _: False, most=1000)
    assert more == tried


def test_so_many_are_tried_at_most() -> None:
    """The first and the last among them; the others are counted."""
    everything, _ = swept(lambda _: False)
    tried, result = swept(lambda _: False, most=3)
    assert (tried[0], tried[-1], len(tried)) == (everything[0], everything[-1], 3)
    assert result.skipped == len(everything) - 3
    first, _ = swept(lambda _: False, most=1)
    assert first == [0]


def test_a_later_island_counts() -> None:
    """What comes out need not be better the earlier the change is."""
    everything, _ = swept(lambda _: False)
    island = everything[2]
    _, result = swept(lambda number: number in (0, island))
    assert result.last is not None
    assert result.last.step_ns == source().steps_ns[island]


def test_a_run_that_is_saved_at_its_last_change() -> None:
    """The steps behind it are tried, too."""
    tried, result = swept(lambda _: True)
    assert result.next is None
    assert result.last is not None
    assert result.last.step_ns == source().steps_ns[-1]
    assert len(tried) < 20
