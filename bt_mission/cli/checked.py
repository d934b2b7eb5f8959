"""Missions, scenarios and fleets that options name: loaded and checked."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bt_mission.base.files import is_scenario
from bt_mission.cli.options import mission_file

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission
    from bt_mission.language.permissions import Permissions


def examined(options: argparse.Namespace) -> tuple[Any, tuple[Any, ...]]:
    """Load the mission that the options name and check it; gives it with all warnings.

    Raises:
        InputError: With every error and warning.
    """
    from bt_mission.base.diagnostics import InputError
    from bt_mission.requirements.checks import with_requirements
    from bt_mission.robots.model import load_robot
    from bt_mission.sessions.goal_checks import OUR_SERVERS
    from sim.world.loader import load_world

    mission, diagnostics = examine_options(
        options, None if goes_to_a_graph(options) else OUR_SERVERS
    )
    if mission is None:
        raise InputError(diagnostics)
    if mission.world:
        load_world(mission.world, near=mission.file)
    load_robot(mission.robot, near=mission.file)
    return observed(with_requirements(mission, options.require), options), diagnostics


def examine_options(options: argparse.Namespace, servers: Any) -> tuple[Any, tuple[Any, ...]]:
    """Load the mission that the options name; gives it, or None, with every diagnostic.

    Args:
        options: Those of the command.
        servers: Limits of the servers that its goals are for; None where they are not known.
    """
    from bt_mission.sessions.check import examine

    return examine(
        mission_file(options),
        set=dict(options.set),
        seed=options.seed,
        world=options.world,
        robot=options.robot,
        servers=servers,
        permissions=permissions_of(options),
    )


def observed(mission: Mission, options: argparse.Namespace) -> Mission:
    """Return a mission with the observation after its end that `run` is asked for."""
    seconds = getattr(options, "observe", None)
    return mission if seconds is None else replace(mission, observe=seconds)


def examined_file(options: argparse.Namespace) -> tuple[Any, tuple[Any, ...]]:
    """Load and check a mission or a scenario; gives it with all warnings.

    Raises:
        InputError: With every error and warning.
    """
    path = mission_file(options)
    if not is_scenario(path):
        return examined(options)
    from bt_mission.base.diagnostics import InputError
    from bt_mission.requirements.checks import with_requirements
    from bt_mission.scenarios.loader import ScenarioChanges, examine_scenario

    changes = ScenarioChanges(
        set=dict(options.set),
        seed=options.seed,
        world=options.world,
        robot=options.robot,
        permissions=permissions_of(options),
    )
    scenario, diagnostics = examine_scenario(path, changes)
    if scenario is None:
        raise InputError(diagnostics)
    mission = observed(with_requirements(scenario.mission, options.require), options)
    return replace(scenario, mission=mission), diagnostics


def examined_fleet(options: argparse.Namespace) -> tuple[Any, tuple[Any, ...]]:
    """Load and check a fleet; gives it with all warnings.

    Raises:
        InputError: With every error and warning.
        BtMissionError: For options that are about a mission alone.
    """
    from bt_mission.base.diagnostics import InputError
    from bt_mission.scenarios.fleets.loader import FleetChanges, examine_fleet

    changes = FleetChanges(
        set=dict(options.set),
        seed=options.seed,
        world=options.world,
        observe=getattr(options, "observe", None),
        require=options.require,
        permissions=permissions_of(options),
    )
    fleet, diagnostics = examine_fleet(mission_file(options), changes)
    if fleet is None:
        raise InputError(diagnostics)
    return fleet, diagnostics


def goes_to_a_graph(options: argparse.Namespace) -> bool:
    """Tell whether the mission's goals are for servers that run already."""
    given = vars(options)
    compared = given.get("against") or given.get("graph")
    return bool(given.get("attach") or (compared and not given["json"]))


def permissions_of(options: argparse.Namespace) -> Permissions:
    """Permissions of a mission; `check` imports Python leaves only with --import-python."""
    from bt_mission.language.permissions import Permissions

    if options.no_python:
        return Permissions(python="refuse", hint="--no-python was given")
    if getattr(options, "import_python", True):
        return Permissions(constructs="import_python" in options)
    hint = "--import-python imports it and checks its inputs, --no-python refuses it"
    return Permissions(python="name", hint=hint)
