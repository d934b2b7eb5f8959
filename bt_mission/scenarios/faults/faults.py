"""The table of faults, and the methods of the fixture ``stage`` that are made of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from bt_mission.scenarios.faults import clock, messages, robot, servers, world
from bt_mission.scenarios.faults.fault import Fault, FaultTarget
from bt_mission.scenarios.faults.kind import FaultKind

FAULTS: Mapping[str, FaultKind] = MappingProxyType(
    {
        row.name: row
        for rows in (messages.ROWS, servers.ROWS, robot.ROWS, world.ROWS, clock.ROWS)
        for row in rows
    }
)
"""Every fault, by its name."""


class Faults:
    """Makes faults: in tests actions for ``run.do``, ``run.at`` and ``run.when``.

        blind = stage.faults.drop("scan")
        run.at(5.0, blind)
        run.at(8.0, blind.end)

    Each fault of the table is a method of its name. Each leaves events in the run's trace, draws
    what is random from the mission's seed, and repeats bit for bit.

    Attributes:
        made: Every fault that was made, in order.
    """

    def __init__(self) -> None:
        self.made: list[Fault] = []

    def __getattr__(self, name: str) -> Callable[..., Fault]:
        """Return what makes the faults of a name. Raises AttributeError for an unknown one."""
        if name not in FAULTS:
            raise AttributeError(f"unknown fault '{name}'", name=name, obj=self)
        kind = FAULTS[name]
        make = partial(self._make, kind)
        make.__doc__ = kind.text
        make.__signature__ = kind.signature  # type: ignore[attr-defined]
        return make

    def _make(self, kind: FaultKind, *arguments: Any, **options: Any) -> Fault:
        fault = kind.make(*arguments, **options)
        self.made.append(fault)
        return fault

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *FAULTS]

    def clear(self, run: FaultTarget) -> None:
        """End every fault that has not ended; an action, too."""
        for fault in run.faults:
            fault.end_from_outside()
