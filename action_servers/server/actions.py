"""The actions of this package, from their declarations.

The module of a declaration is imported when its action is needed: the libraries for images and maps
take longer to import than everything else.
"""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

from action_servers.core.action import Action, ServerContext
from action_servers.core.maneuver import ServedAction
from bt_mission.base.actions import declared


def action(name: str) -> Action:
    """Return one of the actions of `declared`."""
    place = declared()[name]
    declaration: Action = getattr(import_module(place.module), place.attribute)
    return declaration


def generated_type(name: str) -> Any:
    """Return the class of an action's type, such as "nav2_msgs/action/Spin"."""
    package, folder, type_name = name.split("/")
    return getattr(import_module(f"{package}.{folder}"), type_name)


def served(declared_action: Action, context: ServerContext) -> ServedAction:
    """Return an action as the servers of one robot offer it."""
    return ServedAction(
        name=declared_action.name,
        type=generated_type(declared_action.type),
        plan=partial(declared_action.planned, context=context),
        needs_map="map" in declared_action.needs,
        part=declared_action.part,
        during=declared_action.during,
    )
