"""All candidates of a search: each is drawn, part by part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from bt_mission.faults.planned import AtTime, PlannedFault
from bt_mission.faults.values import planned_fault
from bt_mission.search.candidate import OBSTACLES, Candidate
from bt_mission.search.kinds import actions_of, faults_of, leaves_of
from bt_mission.search.ranges import ObstacleRanges, Ranges, Span, StartRanges
from bt_mission.search.starts import FreeSpace
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.space import Interval, Parameter
from bt_mission.testing.generators.draws import Draws, number, one_of
from bt_mission.testing.generators.faults import STEP_S, FaultChoice, drawn_fault

PartDraws = Callable[[str], Draws]
"""Gives what draws a part of a candidate, by the part's name."""

FINE = 1000
"""So many steps an interval of an input has."""

PLACE_STEP = 0.05
"""Metres between places, and sizes."""

YAW_STEP = 5.0
"""Degrees."""


class SearchSpace:
    """All scenarios that a search may try.

    Args:
        base: What is varied.
        ranges: By how much.
        parameters: Its inputs and worlds.
        latest_s: The last time of faults and obstacles where the ranges do not say, s.
    """

    def __init__(
        self,
        base: BaseScenario,
        ranges: Ranges,
        parameters: Sequence[Parameter],
        latest_s: float,
    ) -> None:
        self.base = base
        self._seeds: range = ranges.seeds
        self._parameters = tuple(parameters)
        self._start = StartRanges() if ranges.start == "anywhere" else ranges.start
        self._free = FreeSpace(base)
        self._limit = ranges.limit
        whole_run = Span(0.0, max(STEP_S, latest_s))
        usual = Span(STEP_S, whole_run.high)
        self._obstacles: ObstacleRanges = ranges.obstacles
        self._obstacle_times: Span = ranges.obstacles.times or whole_run
        self._fault_times: Span = ranges.faults.times or whole_run
        self._drawn_times = _steps(ranges.obstacles.times or usual)
        self._lasting: Span = ranges.faults.lasting
        kinds = faults_of(ranges.faults.kinds)
        leaves = leaves_of(base.mission)
        self._choice = FaultChoice(
            kinds if leaves else tuple(one for one in kinds if one != "raise_in_leaf"),
            leaves,
            actions_of(base.mission),
            _steps(ranges.faults.times or usual),
            _steps(Span(max(STEP_S, self._lasting.low), self._lasting.high)),
        )
        self._most_faults = ranges.faults.most if self._choice.names else 0

    def as_it_is(self) -> Candidate:
        """The base, with nothing varied."""
        return Candidate(limit=self._limit)

    def draw(self, parts: PartDraws) -> Candidate:
        """Draw a candidate; the same draws give the same."""
        values: dict[str, Any] = {
            one.name: one.at(parts(one.name).whole(0, FINE) / (FINE + 1))
            for one in self._parameters
        }
        seed = self._seeds[parts("seed").whole(0, len(self._seeds) - 1)]
        if self._start is not None:
            values |= self._drawn_start(parts("start"), self._start, values.get("world"))
        faults: list[PlannedFault] = []
        for slot in range(self._most_faults):
            draws = parts(f"fault {slot}")
            faults += drawn_fault(draws, self._choice) if draws.whole(0, 1) else ()
        for slot in range(self._obstacles.most):
            draws = parts(f"obstacle {slot}")
            faults += [self._drawn_obstacle(draws)] if draws.whole(0, 1) else []
        return Candidate(seed, values, tuple(faults), self._limit)

    def allows(self, candidate: Candidate) -> bool:
        """Tell whether a candidate lies within the ranges."""
        for one in self._parameters:
            value = candidate.values.get(one.name)
            if not isinstance(one, Interval) or value is None:
                continue
            if not one.low <= value <= one.high:
                return False
        return all(self._allows_fault(one) for one in candidate.faults)

    def _allows_fault(self, fault: PlannedFault) -> bool:
        time = getattr(fault.begins, "time_s", 0.0)
        if fault.name not in OBSTACLES:
            lasting = self._lasting
            is_long = fault.lasting is None or lasting.low <= fault.lasting <= lasting.high
            return is_long and self._fault_times.low <= time <= self._fault_times.high
        ranges = self._obstacles
        given = fault.arguments
        within = [(time, self._obstacle_times), (given.get("ahead", 0.0), ranges.ahead)]
        within.append((given.get("left", 0.0), ranges.left))
        size = given.get("size")
        if isinstance(size, tuple):
            within.append((size[0], ranges.size))
        return all(span.low <= value <= span.high for value, span in within)

    def _drawn_start(
        self, draws: Draws, ranges: StartRanges, world: str | None
    ) -> dict[str, float]:
        floor = self._free.floor(world)
        x = _within(draws, ranges.x or floor[0], PLACE_STEP)
        y = _within(draws, ranges.y or floor[1], PLACE_STEP)
        x, y = self._free.nearest(world, x, y)
        return {"start.x": x, "start.y": y, "start.yaw": _within(draws, ranges.yaw, YAW_STEP)}

    def _drawn_obstacle(self, draws: Draws) -> PlannedFault:
        ranges = self._obstacles
        begins = AtTime(_within(draws, self._drawn_times, STEP_S))
        ahead = _within(draws, ranges.ahead, PLACE_STEP)
        left = _within(draws, ranges.left, PLACE_STEP)
        options: dict[str, Any] = {}
        size = _within(draws, ranges.size, PLACE_STEP)
        if ranges.lasting is not None:
            options["lasting"] = max(STEP_S, _within(draws, ranges.lasting, STEP_S))
        if one_of(draws, OBSTACLES) == "spawn_box":
            options["size"] = (size, size, 0.3)
            return planned_fault(begins, "spawn_box", ahead, left, **options)
        options["radius"] = round(size / 2, 6)
        return planned_fault(begins, "spawn_cylinder", ahead, left, **options)


def _within(draws: Draws, span: Span, step: float) -> float:
    return number(draws, span.low, span.high, step)


def _steps(span: Span) -> Span:
    """Return a span of times whose ends are steps."""
    low = round(span.low / STEP_S) * STEP_S
    return Span(low, max(low, round(span.high / STEP_S) * STEP_S))
