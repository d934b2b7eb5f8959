"""All candidates of a search: each is drawn, part by part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.material import Material, material_of
from bt_mission.commands.falsify.starts import FreeSpace
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.ranges import (
    Interval,
    ObstacleRanges,
    Parameter,
    Ranges,
    StartRanges,
    ValueChoice,
    ValueRange,
)
from bt_mission.scenarios.draws import Draws, maybe, number, one_of
from bt_mission.scenarios.faults.drawable import ACTIONS, LONGEST_S, STEP_S, Drawable
from bt_mission.scenarios.faults.drawing import (
    DEFAULT_KINDS,
    can_be_drawn,
    drawn_beginning,
    drawn_fault,
    faults_of,
)
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.faults.robot import ON_BODIES
from bt_mission.scenarios.faults.values import planned_fault
from bt_mission.scenarios.faults.world import MOST_OBSTACLES, OBSTACLES

PartDraws = Callable[[str], Draws]
"""Gives what draws a part of a candidate, by the part's name."""

FINE = 1000
"""The number of steps of an interval of an input."""

PLACE_STEP = 0.05
"""Metres between places, and sizes."""

YAW_STEP = 5.0
"""Degrees."""

TO_AHEAD, TO_LEFT = ValueRange(-0.5, 2.0), ValueRange(-1.5, 1.5)
"""The target of an obstacle that moves, m from the robot's pose when the obstacle appears."""

SLOWEST = 0.05
"""M/s, of an obstacle that moves."""


class SearchSpace:
    """All scenarios of a search.

    Args:
        base: The scenario that is varied.
        ranges: The ranges of the variation.
        parameters: The inputs and worlds.
        latest_s: The last time of faults and obstacles without one in the ranges, s.
        material: The material of the mission; None is that of the base.
    """

    def __init__(
        self,
        base: BaseScenario,
        ranges: Ranges,
        parameters: Sequence[Parameter],
        latest_s: float,
        material: Material | None = None,
    ) -> None:
        self.base = base
        given = material_of(base.mission) if material is None else material
        self._seeds: range = ranges.seeds
        self._parameters = tuple(parameters)
        self._start = StartRanges() if ranges.start == "anywhere" else ranges.start
        self._free = FreeSpace(base)
        self._limit = ranges.limit
        whole_run = ValueRange(0.0, max(STEP_S, latest_s))
        usual = ValueRange(STEP_S, whole_run.high)
        self._obstacles: ObstacleRanges = ranges.obstacles
        self._most_obstacles = min(ranges.obstacles.most, MOST_OBSTACLES - _obstacles_in(base))
        self._obstacle_times: ValueRange = ranges.obstacles.times or whole_run
        self._fault_times: ValueRange = ranges.faults.times or whole_run
        self._lasting: ValueRange | None = ranges.faults.lasting
        lasting = self._lasting or ValueRange(STEP_S, LONGEST_S)

        def allowed(periods: Sequence[float]) -> list[float]:
            """Return the periods that the ranges allow."""
            return [
                period for period in periods if self._lasting is None or _is_in(lasting, period)
            ]

        choice = Drawable(
            (),
            given.leaves,
            given.actions or ACTIONS,
            _steps(self._fault_times),
            _steps(ValueRange(max(STEP_S, lasting.low), lasting.high)),
            topics=given.topics,
            services=given.services,
            fields=given.fields,
            events=given.events if ranges.faults.times is None else (),
            limits=allowed(given.limits),
            trusted={topic: allowed(periods) for topic, periods in given.trusted.items()},
        )
        kinds = faults_of(ranges.faults.kinds or _default_kinds(given))
        names = [kind for kind in kinds if can_be_drawn(kind, choice) and kind not in given.lacking]
        if "simulator" in base.data:  # of others: it refuses what acts on bodies
            names = [kind for kind in names if kind not in ON_BODIES]
            self._most_obstacles = 0
        self._choice = replace(choice, names=names)
        self._appearing = replace(
            choice,
            times=_steps(ranges.obstacles.times or usual),
            events=given.events if ranges.obstacles.times is None else (),
        )
        self._most_faults = ranges.faults.most if names else 0

    def draw(self, parts: PartDraws) -> Candidate:
        """Draw a candidate; equal draws give equal candidates."""
        values: dict[str, Any] = {
            parameter.name: parameter.at(parts(parameter.name).whole(0, FINE) / (FINE + 1))
            for parameter in self._parameters
        }
        seed = self._seeds[parts("seed").whole(0, len(self._seeds) - 1)]
        if self._start is not None:
            values |= self._drawn_start(parts("start"), self._start, values.get("world"))
        faults: list[PlannedFault] = []
        for slot in range(self._most_faults):
            draws = parts(f"fault {slot}")
            faults += drawn_fault(draws, self._choice) if draws.whole(0, 1) else ()
        for slot in range(self._most_obstacles):
            draws = parts(f"obstacle {slot}")
            faults += self._drawn_obstacle(draws, slot + 1) if draws.whole(0, 1) else []
        return Candidate(seed, values, tuple(faults), self._limit)

    def allows(self, candidate: Candidate) -> bool:
        """Return whether a candidate is within the ranges."""
        for parameter in self._parameters:
            value = candidate.values.get(parameter.name)
            if not isinstance(parameter, Interval) or value is None:
                continue
            if not parameter.low <= value <= parameter.high:
                return False
        return all(self._allows_fault(fault) for fault in candidate.faults)

    def _allows_fault(self, fault: PlannedFault) -> bool:
        time = getattr(fault.begins, "time_s", 0.0)
        ranges = self._obstacles
        given = fault.arguments
        if fault.name == "move_box":
            return _is_in(self._obstacle_times, time) and _is_in(
                ranges.speed, given.get("speed", ranges.speed.low)
            )
        if fault.name not in OBSTACLES:
            lasting = self._lasting
            is_long = fault.lasting is None or lasting is None or _is_in(lasting, fault.lasting)
            return is_long and _is_in(self._fault_times, time)
        within = [(time, self._obstacle_times), (given.get("ahead", 0.0), ranges.ahead)]
        within.append((given.get("left", 0.0), ranges.left))
        size = given.get("size")
        if isinstance(size, tuple):
            within.append((size[0], ranges.size))
        return all(_is_in(span, value) for value, span in within)

    def _drawn_start(
        self, draws: Draws, ranges: StartRanges, world: str | None
    ) -> dict[str, float]:
        floor = self._free.floor(world)
        x = _within(draws, ranges.x or floor[0], PLACE_STEP)
        y = _within(draws, ranges.y or floor[1], PLACE_STEP)
        x, y = self._free.nearest(world, x, y)
        return {"start.x": x, "start.y": y, "start.yaw": _within(draws, ranges.yaw, YAW_STEP)}

    def _drawn_obstacle(self, draws: Draws, slot: int) -> list[PlannedFault]:
        """Draw an obstacle that appears, and perhaps its way."""
        ranges = self._obstacles
        begins = drawn_beginning(draws, self._appearing)
        ahead = _within(draws, ranges.ahead, PLACE_STEP)
        left = _within(draws, ranges.left, PLACE_STEP)
        name = f"drawn {slot}"
        options: dict[str, Any] = {"name": name, "nearest_free": True}
        size = _within(draws, ranges.size, PLACE_STEP)
        if ranges.lasting is not None:
            options["lasting"] = max(STEP_S, _within(draws, ranges.lasting, STEP_S))
        if one_of(draws, OBSTACLES) == "spawn_box":
            options["size"] = (size, size, 0.3)
            faults = [planned_fault(begins, "spawn_box", ahead, left, **options)]
        else:
            options["radius"] = round(size / 2, 6)
            faults = [planned_fault(begins, "spawn_cylinder", ahead, left, **options)]
        if ranges.speed.high > 0 and maybe(draws, 3):
            to = _within(draws, TO_AHEAD, PLACE_STEP), _within(draws, TO_LEFT, PLACE_STEP)
            speed = max(SLOWEST, _within(draws, ranges.speed, PLACE_STEP))
            moves = {"speed": speed, "nearest_free": True}
            faults.append(planned_fault(begins, "move_box", name, *to, **moves))
        return faults


def _default_kinds(given: Material) -> list[str]:
    kinds = list(DEFAULT_KINDS)
    kinds += ["camera"] if given.uses_camera else []
    return [*kinds, "battery"] if given.uses_battery else kinds


def _obstacles_in(base: BaseScenario) -> int:
    """Count the obstacles that the base has already."""
    spawned = sum("spawn_" in str(text) for text in base.data.get("faults", ()))
    return min(MOST_OBSTACLES, len(base.data.get("obstacles", ())) + spawned)


def _is_in(span: ValueRange, value: Any) -> bool:
    return bool(span.low <= value <= span.high)


def _within(draws: Draws, given: ValueRange | Parameter, step: float) -> Any:
    if isinstance(given, ValueChoice):
        return one_of(draws, given.values)
    return number(draws, given.low, given.high, step)


def _steps(span: ValueRange) -> ValueRange:
    """Return a span of times whose ends are steps."""
    low = round(span.low / STEP_S) * STEP_S
    return ValueRange(low, max(low, round(span.high / STEP_S) * STEP_S))
