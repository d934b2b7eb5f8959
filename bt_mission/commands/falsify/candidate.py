"""A scenario of a search, in parts that can be omitted, replaced or rounded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.faults.planned import PlannedFault


@dataclass(frozen=True)
class Candidate:
    """The parts of a scenario besides its base.

    Attributes:
        seed: None is the seed of the base.
        values: Of the world, the start and inputs, by the names of parameters of sweeps; what is
            not there is as in the base.
        faults: The faults, including obstacles that appear.
        limit: The run is interrupted at this time, s; None is the limit of the base.
    """

    seed: int | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    faults: tuple[PlannedFault, ...] = ()
    limit: float | None = None

    @property
    def size(self) -> tuple[int, int, int]:
        """Its size beyond the base: faults, other changes, and characters of faults."""
        changes = len(self.values) + (self.seed is not None)
        return len(self.faults), changes, sum(len(fault.text) for fault in self.faults)

    def concrete(self, base: BaseScenario, number: int) -> ConcreteScenario:
        """Return the scenario for a worker."""
        faults = [fault.text for fault in self.faults]
        made = base.concrete(self.values, number=number, seed=self.seed, faults=faults)
        if self.limit is None:
            return made
        data = {**made.data, "limit": self.limit}
        return ConcreteScenario(number, data, made.parameters, made.plan, made.bundle_digest)


def given_world(base: BaseScenario, name: str) -> str:
    """Return how the files of a base name a world of its bundle."""
    return next(given for given, packed in base.bundle.worlds.items() if packed == name)
