"""The standard interfaces of simulators (`simulation_interfaces`) on the node of a simulation."""

from __future__ import annotations

from typing import Any

from bt_mission.base.commands import page
from bt_mission.base.stamps import set_ns
from sim.entities import Entities
from sim.ros.entity_services import EntityServices
from sim.ros.node import SimNode
from sim.ros.run_control import RunControl
from sim.ros.run_services import RunServices
from sim.ros.world_services import WorldServices

ABOUT = f"bt-mission sim; {page('simulator')} says what each service does"


def offer_standard_services(node: SimNode, control: RunControl, source: str) -> None:
    """Offer the standard's services and actions that a simulation supports.

    `source` is the name or path of its world.
    """

    def fill_now(stamp: Any) -> Any:
        return set_ns(stamp, node.clock_ns)

    entities = Entities(node.physics, node.robots)
    run = RunServices(node, control)
    about = EntityServices(node, control, entities, fill_now).features
    about += WorldServices(node, control, node.physics.world, source).features
    run.offer_always([*run.features, *about], ABOUT)
