"""Makes a candidate small: each step is checked by running it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import aclosing
from dataclasses import replace
from typing import Any

from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.search import Search, run_all
from bt_mission.commands.falsify.space import SearchSpace
from bt_mission.requirements.language.formula import CONTROL_STEP_S
from bt_mission.scenarios.faults.planned import AtTime, Beginning, PlannedFault, Value, WhenTrue
from bt_mission.scenarios.faults.world import OF_A_BOX

AT_ONCE = 4
"""Candidates that are tried at once, however many workers there are."""

MOST_RUNS = 150
"""The default of the most runs."""

MOST_GROWTH = 1.25
"""The most growth of a number when it is rounded."""

MOST_ROUNDER = 5
"""Rounder numbers that are tried in the place of one."""


async def simplify(
    search: Search, space: SearchSpace, number: int = 0, most_runs: int = MOST_RUNS
) -> None:
    """Minimize a counterexample, as long as the same failure occurs.

    First the fewest faults and obstacles, then default values for everything else, then the
    roundest numbers, and the shortest run. `search.state` has the smallest so far at any time.

    Args:
        number: The index of the counterexample.
    """
    simplifier = _Simplifier(search, space, number, most_runs)
    await simplifier.fewest_faults()
    await simplifier.defaults()
    before = None
    while before != search.state.counterexamples[number]:
        before = search.state.counterexamples[number]
        await simplifier.round_numbers()
        await simplifier.fewest_faults()
    await simplifier.shortest()


class _Simplifier:
    """Replaces a counterexample, step by step."""

    def __init__(self, search: Search, space: SearchSpace, number: int, most_runs: int) -> None:
        self._space = space
        self._search = search
        self._number = number
        self._most = search.state.simplifying_runs + most_runs
        self._failure = search.state.counterexamples[number].failure
        self._tried: set[str] = set()

    @property
    def _now(self) -> Candidate:
        return self._search.state.counterexamples[self._number].candidate

    async def fewest_faults(self) -> None:
        """Leave faults out, half of them at once while that works (delta debugging).

        A. Zeller, R. Hildebrandt: "Simplifying and Isolating Failure-Inducing Input", IEEE
        Transactions on Software Engineering 28 (2002), 183-200.
        """
        size = len(self._now.faults)
        while size >= 1:
            faults = self._now.faults
            fewer = [
                replace(self._now, faults=_whole(faults[:start] + faults[start + size :]))
                for start in range(0, len(faults), size)
            ]
            if not await self._first_that_fails(fewer):
                size //= 2
            size = min(size, len(self._now.faults))

    async def defaults(self) -> None:
        """Use the mission's values for the seed, the world, the start and inputs."""
        now = self._now
        await self._first_that_fails([replace(now, seed=None, values={})])
        await self._first_that_fails([replace(self._now, seed=None)])
        for names in _kinds_of_values(self._now):
            left = {name: value for name, value in self._now.values.items() if name not in names}
            await self._first_that_fails([replace(self._now, values=left)])

    async def round_numbers(self) -> None:
        """Use rounder numbers, the roundest first, and omit arguments of faults."""
        for index in range(len(self._now.faults)):
            fault = self._now.faults[index]
            lasting = [] if fault.lasting is None else [LASTING]
            for name in (BEGINS, *lasting, *fault.arguments):
                fault = self._now.faults[index]
                await self._first_that_fails(
                    [_with_fault(self._now, index, simpler) for simpler in _simpler(fault, name)]
                )
        for name in self._now.values:
            value = self._now.values[name]
            if isinstance(value, float):
                rounder = ({**self._now.values, name: number} for number in rounder_numbers(value))
                await self._first_that_fails(
                    [replace(self._now, values=values) for values in rounder]
                )

    async def shortest(self) -> None:
        """End the run soon after a violation; a failure that ends the mission stays."""
        counterexample = self._search.state.counterexamples[self._number]
        margin = counterexample.row.requirements.get(self._failure.what)
        if self._failure.kind != "violated" or margin is None or margin.at is None:
            return
        ends = sorted({math.ceil(margin.at + 0.1 + more) for more in (0, 1, 3, 10)})
        sooner = [float(end) for end in ends if end < counterexample.row.virtual_s]
        latest = max(
            (getattr(fault.begins, "time_s", 0.0) for fault in self._now.faults), default=0.0
        )
        await self._first_that_fails(
            [replace(self._now, limit=limit) for limit in sooner if limit > latest]
        )

    async def _first_that_fails(self, candidates: Sequence[Candidate]) -> bool:
        """Run candidates in their order; take the first that fails in the same way."""
        search, state = self._search, self._search.state
        new = [untried for untried in candidates if self._is_worth_a_run(untried)]
        for start in range(0, len(new), AT_ONCE):
            left = self._most - state.simplifying_runs
            some = new[start : start + min(AT_ONCE, left)]
            if not some or state.is_interrupted:
                return False
            first = state.runs + state.simplifying_runs
            async with aclosing(run_all(search.base, search.runner, some, first)) as tried:
                async for candidate, row in tried:
                    state.simplifying_runs += 1
                    same = next(
                        (
                            failure
                            for failure in search.guide.failures(row)
                            if failure.is_like(self._failure)
                        ),
                        None,
                    )
                    is_found = same is not None and await search.is_fair(candidate)
                    if is_found:
                        known = state.counterexamples[self._number]
                        state.counterexamples[self._number] = replace(
                            known, candidate=candidate, row=row
                        )
                    state.is_interrupted = not search.watch(state)
                    if is_found or state.is_interrupted:
                        return is_found
        return False

    def _is_worth_a_run(self, candidate: Candidate) -> bool:
        """Return whether a candidate is new, and within the ranges."""
        is_whole = _whole(candidate.faults) == candidate.faults
        if candidate == self._now or not is_whole or not self._space.allows(candidate):
            return False
        scenario = candidate.concrete(self._search.base, 0).id
        is_new = scenario not in self._tried
        self._tried.add(scenario)
        return is_new


# ---- simpler faults ------------------------------------------------------------------------

BEGINS, LASTING = "begins", "lasting"
NEEDED = ("ahead", "at", "box")
"""Arguments that stay: places, and which obstacle it is."""


def _whole(faults: tuple[PlannedFault, ...]) -> tuple[PlannedFault, ...]:
    """Return faults without those of obstacles that no longer appear."""
    names = {fault.arguments.get("name", fault.name.removeprefix("spawn_")) for fault in faults}
    return tuple(
        fault
        for fault in faults
        if fault.name not in OF_A_BOX or fault.arguments.get("box", "box") in names
    )


def _with_fault(candidate: Candidate, index: int, fault: PlannedFault) -> Candidate:
    faults = (*candidate.faults[:index], fault, *candidate.faults[index + 1 :])
    return replace(candidate, faults=faults)


def _simpler(fault: PlannedFault, part: str) -> Iterator[PlannedFault]:
    """Yield a fault with a part omitted or rounded, the simplest first."""
    if part == BEGINS:
        yield from (
            replace(fault, begins=beginning) for beginning in _simpler_beginnings(fault.begins)
        )
    elif part == LASTING:
        assert fault.lasting is not None, "it has one"
        for lasting in rounder_numbers(fault.lasting):
            if lasting > 0:
                yield replace(fault, lasting=lasting)
    elif part in fault.arguments:
        parameter = fault.kind.parameters.get(part)
        if parameter and not parameter.is_required and part not in NEEDED:
            left = {name: argument for name, argument in fault.arguments.items() if name != part}
            yield replace(fault, arguments=left)
        for value in _rounder_values(fault.arguments[part]):
            yield replace(fault, arguments={**fault.arguments, part: value})


def _simpler_beginnings(begins: Beginning) -> Iterator[Beginning]:
    if isinstance(begins, WhenTrue):
        if begins.held_s:
            yield WhenTrue(begins.condition)
        for held in rounder_numbers(begins.held_s):
            if held >= CONTROL_STEP_S:
                yield WhenTrue(begins.condition, held)
        return
    for time in rounder_numbers(begins.time_s):
        if time >= 0:
            yield AtTime(time)


def _rounder_values(value: Value) -> Iterator[Value]:
    if isinstance(value, float):
        yield from rounder_numbers(value)
    elif isinstance(value, int) and not isinstance(value, bool) and value > 1:
        yield 1


def _kinds_of_values(candidate: Candidate) -> list[tuple[str, ...]]:
    """Return the names of values that are omitted together: a start is one place."""
    start = tuple(name for name in candidate.values if name.startswith("start."))
    others: list[tuple[str, ...]] = [
        (name,) for name in candidate.values if not name.startswith("start.")
    ]
    return [*others, *([start] if start else [])]


def rounder_numbers(value: float) -> list[float]:
    """Return numbers near one with fewer digits, the roundest first."""
    rounded: dict[float, Any] = {}
    size = 10.0 ** math.floor(math.log10(abs(value))) if value else 1.0
    for unit in (10 * size, 5 * size, size, size / 2, size / 10):
        for share in (math.floor(value / unit), math.ceil(value / unit)):
            rounder = round(share * unit, 6)
            if _digits(rounder) < _digits(value) and abs(rounder) <= MOST_GROWTH * abs(value):
                rounded.setdefault(rounder)
    return sorted(rounded, key=lambda number: (_digits(number), abs(number - value)))[:MOST_ROUNDER]


def _digits(value: float) -> int:
    """Return the number of digits of a number; zeros at its ends do not count."""
    return len(f"{abs(value):.6f}".rstrip("0").replace(".", "").strip("0"))
