"""Concrete scenarios: scenarios for a worker, with a value for each parameter."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from bt_mission.scenarios.concrete.bundle import Bundle

ID_DIGITS = 16


@dataclass(frozen=True)
class ConcreteScenario:
    """One scenario, as the mapping of a scenario file beside the mission of a bundle.

    The terms are those of ASAM OpenSCENARIO: a logical scenario has ranges of parameters, a
    concrete one has their values.

    Attributes:
        number: Its place in the sweep or search, from 0.
        data: The content of its file; files are named as in the bundle.
        parameters: The values of what is varied, by the names that the user has given.
        plan: The name of its plan of faults; empty without one.
        bundle_digest: Of the files that it is beside.
    """

    number: int
    data: Mapping[str, Any]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    plan: str = ""
    bundle_digest: str = ""

    @cached_property
    def id(self) -> str:
        """Follows from the files of the bundle and all that the scenario is, and from nothing else.

        It is the first 16 hexadecimal digits of a SHA-256.
        """
        content = json.dumps([self.bundle_digest, self.data], sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(content.encode()).hexdigest()[:ID_DIGITS]


def concrete(
    data: Mapping[str, Any],
    bundle: Bundle,
    values: Mapping[str, Any],
    *,
    number: int,
    seed: int,
    faults: Sequence[Any] = (),
    plan: str = "",
) -> ConcreteScenario:
    """Return a scenario with values of parameters in it.

    Args:
        data: Of the scenario that is varied, with the names of the bundle.
        values: By the parameters' names (`ranges`).
        number: Its place among others.
        faults: In addition, as a scenario file has them.
        plan: What these are called.

    Raises:
        KeyError: For a world or a robot that the bundle does not have.
    """
    made = {key: deepcopy(value) for key, value in data.items()}
    for name, value in values.items():
        match name.split("."):
            case ["world"]:
                made["world"] = bundle.worlds[str(value)]
            case ["robot"]:
                made["robot"] = bundle.robots[str(value)]
            case ["start", ("x" | "y" | "yaw") as axis]:
                made["start"] = {**made.get("start", {}), axis: value}
            case ["inputs", *rest] if rest:
                made["inputs"] = {**made.get("inputs", {}), ".".join(rest): value}
            case _:
                made["inputs"] = {**made.get("inputs", {}), name: value}
    made["seed"] = seed
    if faults:
        made["faults"] = [*made.get("faults", ()), *faults]
    return ConcreteScenario(number, made, dict(values), plan, bundle.digest)
