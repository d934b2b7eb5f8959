"""What of a mission's material is there in its runs: topics, actions, services, and sensors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from bt_mission.search.material import Material
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.runner import ScenarioRunner
from bt_mission.testing.generators.kinds import GROUPS

PROBE_S = 0.05
"""A probe ends after the first control step, s."""

NEVER = "when time > 1000000"
"""When the faults of a probe begin: names are looked for before the run."""

SENSORS = ("lidar", "odometry", "imu", "joints", "camera")


async def present_in(material: Material, base: BaseScenario, runner: ScenarioRunner) -> Material:
    """Return what is there of a material, as short runs tell.

    All is tried in one run; each by itself only where that cannot run.
    """
    probes = {
        **{("topic", one): f"{NEVER}: drop {one}" for one in material.topics},
        **{("action", one): f"{NEVER}: reject_goals {one}" for one in material.actions},
        **{("service", one): f"{NEVER}: ignore_service {one}" for one in material.services},
        **{("sensor", one): f"{NEVER}: {one}_dead" for one in SENSORS},
    }
    if not await _missing(base, runner, [list(probes.values())]):
        return material
    wrong = await _missing(base, runner, [[one] for one in probes.values()])
    lost = {key for number, key in enumerate(probes) if number in wrong}
    faults = (one for group in ("hardware", "camera") for one in GROUPS[group])
    lacking = (one for one in faults if ("sensor", one.partition("_")[0]) in lost)
    topics = {one: kind for one, kind in material.topics.items() if ("topic", one) not in lost}
    actions = tuple(one for one in material.actions if ("action", one) not in lost)
    known = {*topics, *(one.strip("/") for one in actions)}
    return replace(
        material,
        topics=topics,
        actions=actions,
        services=tuple(one for one in material.services if ("service", one) not in lost),
        fields=tuple(one for one in material.fields if one.target.strip("/") in known),
        lacking=frozenset(lacking),
    )


async def _missing(
    base: BaseScenario, runner: ScenarioRunner, probes: Iterable[list[str]]
) -> set[int]:
    """Return the numbers of the probes that cannot run."""
    made = []
    for number, faults in enumerate(probes):
        probe = base.concrete({}, number=number, faults=faults)
        data = {**probe.data, "limit": PROBE_S, "faults": faults, "expect": {"outcome": "any"}}
        made.append(ConcreteScenario(number, data, {}, "", probe.bundle_digest))
    return {row.number async for row in runner.rows(made) if row.is_error}
