"""The scenarios of a sweep: every combination of values, or a number of draws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.commands.sweep.store import SweepAbout
from bt_mission.language.expressions.values import Plain
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.ranges import Interval, Parameter, ValueChoice

NO_PLAN = ""


@dataclass(frozen=True)
class SweepPlan:
    """All scenarios of a sweep, made one by one.

    Every point of the space runs with every seed and every plan of faults. Seeds change last, so
    that a part of the sweep covers all points.

    Attributes:
        base: The scenario that is varied.
        parameters: The parameters of the variation.
        seeds: Of the runs; None is that of the mission, and of a sample the number of each draw.
        sample: The number of draws of the space, instead of every combination. They are those of a
            Latin hypercube: each parameter's values are evenly spread. (M. D. McKay, R. J. Beckman,
            W. J. Conover: "A Comparison of Three Methods for Selecting Values of Input Variables",
            Technometrics 21 (1979), 239-245; drawn by `scipy.stats.qmc`.)
        sample_seed: The seed of the draws.
        plans: Faults by the names of the plans.
    """

    base: BaseScenario
    parameters: tuple[Parameter, ...] = ()
    seeds: Sequence[int] | None = None
    sample: int | None = None
    sample_seed: int = 0
    plans: Mapping[str, Sequence[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.sample is None:
            for parameter in self.parameters:
                if isinstance(parameter, Interval):
                    message = "an interval has infinitely many values: draw some with --sample N"
                    hint = f"or list values: {parameter.name}={parameter.low:g},{parameter.high:g}"
                    raise InputError([replace(parameter.place, message=message, hint=hint)])

    @property
    def points(self) -> int:
        """The number of points of the space."""
        if self.sample is not None:
            return self.sample
        return prod(
            len(parameter.values)
            for parameter in self.parameters
            if isinstance(parameter, ValueChoice)
        )

    @property
    def count(self) -> int:
        """The number of scenarios; repeated draws count."""
        return self.points * len(self._plan_names) * len(self._seeds)

    def scenario(self, number: int) -> ConcreteScenario:
        """The scenario of a number from 0 to below `count`."""
        of_seed, rest = divmod(number, self.points * len(self._plan_names))
        point, of_plan = divmod(rest, len(self._plan_names))
        plan = self._plan_names[of_plan]
        return self.base.concrete(
            self.values(point),
            number=number,
            seed=point if self._has_own_seeds else self._seeds[of_seed],
            faults=self.plans.get(plan, ()),
            plan=plan,
        )

    def values(self, point: int) -> dict[str, Plain]:
        """The values of the parameters at a point of the space."""
        if self.sample is not None:
            shares = self._draws[point] if self.parameters else ()
            return {
                parameter.name: parameter.at(float(share))
                for parameter, share in zip(self.parameters, shares, strict=True)
            }
        chosen: dict[str, Plain] = {}
        for parameter in reversed(self.parameters):
            assert isinstance(parameter, ValueChoice), "intervals are drawn"
            point, index = divmod(point, len(parameter.values))
            chosen[parameter.name] = parameter.values[index]
        return {parameter.name: chosen[parameter.name] for parameter in self.parameters}

    def scenarios(self) -> Iterator[ConcreteScenario]:
        """Yield all of them; draws that repeat an earlier one are skipped."""
        seen: set[str] = set()
        for number in range(self.count):
            made = self.scenario(number)
            if self.sample is None:
                yield made
            elif made.id not in seen:
                seen.add(made.id)
                yield made

    @property
    def about(self) -> SweepAbout:
        """The identity of the sweep; equal only for the same sweep."""
        return SweepAbout(
            mission=self.base.mission.name,
            file=self.base.path.name,
            mission_hash=self.base.bundle.digest,
            scenario=dict(self.base.data),
            vary=[str(parameter) for parameter in self.parameters],
            sample=self.sample,
            sample_seed=self.sample_seed,
            seeds=_seeds_as_text(self.seeds),
            plans={name: list(faults) for name, faults in self.plans.items()},
            scenarios=self.count,
        )

    @property
    def _plan_names(self) -> tuple[str, ...]:
        return tuple(self.plans) or (NO_PLAN,)

    @property
    def _seeds(self) -> Sequence[int]:
        return (self.base.mission.seed,) if self.seeds is None else self.seeds

    @property
    def _has_own_seeds(self) -> bool:
        return self.sample is not None and self.seeds is None

    @cached_property
    def _draws(self) -> Any:
        # Takes a second to import, and only samples need it.
        from scipy.stats import qmc

        sampler = qmc.LatinHypercube(d=len(self.parameters), rng=self.sample_seed)
        return sampler.random(self.sample or 0)


def _seeds_as_text(seeds: Sequence[int] | None) -> str | None:
    if seeds is None:
        return None
    if isinstance(seeds, range):
        return f"{seeds[0]}..{seeds[-1]}"
    return ",".join(map(str, seeds))
