"""From a mission file to frozen nodes, or every fault in it at once. No ROS is needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic, InputError, in_order
from bt_mission.core.yaml.composer import Place
from bt_mission.core.yaml.document import Document
from bt_mission.core.yaml.document import read_text as read_yaml
from bt_mission.language.checks.mission import scope_faults, warnings
from bt_mission.language.checks.requirements import requirement_faults
from bt_mission.language.expressions.places import Pose
from bt_mission.language.expressions.values import Plain
from bt_mission.language.file import MissionFile
from bt_mission.language.goal_limits import GoalLimitsTable, server_faults
from bt_mission.language.inputs import overridden
from bt_mission.language.mission import Mission, node_factories
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.places import places_of
from bt_mission.language.requirements.written import requirements_of
from bt_mission.language.trees import TreeLibrary, all_steps, read_trees, size_faults

OTHER_KINDS = {
    "scenario": "'bt-mission run', 'bt-mission check' and run_scenario() take scenarios",
    "fleet": "'bt-mission run' and 'bt-mission check' take fleets",
}
"""Keys of files that are no missions, with who takes them."""


@dataclass(frozen=True)
class Draft:
    """What could be read of a mission, and everything that is wrong with it."""

    document: Document
    mission: Mission | None
    faults: tuple[Diagnostic, ...]


def load_text(
    text: str,
    file: str = "<text>",
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - as in load
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
) -> Mission:
    """Return the mission in a text. Raises InputError with all its faults."""
    return finished(draft(read_yaml(text, file), set, seed, world, robot))


def draft(
    document: Document,
    set: Mapping[str, Plain] | None = None,  # noqa: A002 - as in load
    seed: int | None = None,
    world: str | None = None,
    robot: str | None = None,
    permissions: Permissions = ANYTHING,
    texts: Mapping[str, str] | None = None,
    zones: Mapping[str, Pose] | None = None,
) -> Draft:
    """Return what can be read of a mission, with its faults instead of an exception.

    `texts` are those of the files that it includes, by name; None reads them from the disk.
    `zones` are those of the world that it runs in, where that is not its own.
    """
    for kind, hint in OTHER_KINDS.items():
        if isinstance(document.data, dict) and kind in document.data:
            message = f"expected a mission, got a {kind}"
            return Draft(document, None, (document.fault((kind,), message, hint, key=True),))
    reader = NodeReader(document)
    written = reader.written(MissionFile, (), document.data)
    if written is None and isinstance(document.data, dict):
        # Without a name or a tree the rest can still be looked at.
        written = _stand_in(document.data)
    shelf = TreeLibrary(permissions, texts)
    if written is not None:
        shelf.gather(document, written)
        reader.limits = GoalLimitsTable.written(written)
        reader.places = places_of(
            written.places, world or written.world, document.file, zones, permissions
        )
    tree = None
    if isinstance(document.data, dict) and "tree" in document.data:
        reader.signatures = shelf.signatures
        tree = reader.node(document.data["tree"], ("tree",))
    follow = reader.follows((), () if written is None else written.inputs)
    trees, faults = read_trees(shelf, reader.limits, reader.places)
    faults = [*reader.faults, *shelf.faults, *faults]
    if written is None or tree is None:
        return Draft(document, None, in_order(faults))
    inputs, wrong = overridden(written.inputs, set or {})
    mission = Mission(
        name=written.mission,
        description=written.description,
        world=world or written.world or None,
        robot=robot or written.robot,
        seed=written.seed if seed is None else seed,
        map=written.map,
        observe=written.observe,
        nodes=node_factories(document, written.nodes),
        nature=written.nature,
        inputs=inputs,
        places=dict(written.places),
        trees=trees,
        follow=follow,
        requirements=requirements_of(written.requirements),
        tree=tree,
        lost=frozenset(reader.lost),
        file=document.file,
        document=document,
        included=tuple(shelf.included),
    )
    faults += [*wrong, *size_faults(document, mission)]
    goals = (step.ros_name for step in all_steps(mission) if isinstance(step, GoalNode))
    faults += server_faults(document, written.servers, goals)
    faults += islice(scope_faults(mission), MOST_FAULTS)
    faults += requirement_faults(mission, reader.lost_nodes)
    return Draft(document, mission, in_order(faults))


def _stand_in(data: Mapping[str, Any]) -> MissionFile | None:
    named = {"inputs": data.get("inputs", {}), "mission": "?", "tree": data.get("tree")}
    reader = NodeReader(Document("", named, Place(1, 1), ()))
    return reader.written(MissionFile, (), named)


def finished(found: Draft) -> Mission:
    """Return the mission of a draft, with its warnings. Raises InputError with all its faults."""
    if found.faults or found.mission is None:
        raise InputError(found.faults)
    noted = tuple(warnings(found.mission))
    return replace(found.mission, warnings=noted)
