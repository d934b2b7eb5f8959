"""From a mission file to frozen nodes, or every diagnostic in it at once. No ROS is needed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from bt_mission.base.diagnostics import Diagnostic, InputError, describe, in_order
from bt_mission.base.yaml.composer import Place
from bt_mission.base.yaml.document import Document
from bt_mission.language.checks.live_values import live_values
from bt_mission.language.checks.mission import tree_diagnostics
from bt_mission.language.checks.warnings import warnings
from bt_mission.language.expressions.places import Pose
from bt_mission.language.expressions.values import Plain
from bt_mission.language.file import MissionFile
from bt_mission.language.goal_limits import GoalLimitsTable, server_diagnostics
from bt_mission.language.inputs import overridden
from bt_mission.language.mission import Mission, Requirement, node_factories
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.places import places_of
from bt_mission.language.trees import TreeLibrary, all_steps, read_trees, size_diagnostics

OTHER_KINDS = {
    "scenario": "'bt-mission run', 'bt-mission check' and run_scenario() take scenarios",
    "fleet": "'bt-mission run' and 'bt-mission check' take fleets",
}
"""Keys of files that are not missions, with the commands that accept them."""


Examined: TypeAlias = tuple[Mission | None, tuple[Diagnostic, ...]]
"""A mission with every warning; or None, with every error and warning."""


@dataclass(frozen=True)
class MissionLoader:
    """Reads missions. Packages above this one read parts of them.

    Attributes:
        read_requirements: Returns what the file has under ``requirements``; the reader notes what
            is wrong in it.
        check_requirements: Returns what does not fit the mission. The names are those of nodes
            that could not be read.
    """

    read_requirements: Callable[[NodeReader], tuple[Requirement, ...]]
    check_requirements: Callable[[Mission, Collection[str]], Iterable[Diagnostic]]

    def read(
        self,
        document: Document,
        set: Mapping[str, Plain] | None = None,  # noqa: A002 - the option is called --set
        seed: int | None = None,
        world: str | None = None,
        robot: str | None = None,
        permissions: Permissions = ANYTHING,
        zones: Mapping[str, Pose] | None = None,
        check: Callable[[Mission], Iterable[Diagnostic]] = tree_diagnostics,
    ) -> Examined:
        """Return the mission in a document, checked; what is wrong with it instead of an exception.

        `set` gives inputs other values; `seed`, `world` and `robot` replace what the file says.
        `zones` are those of the world that it runs in, where that is not its own. `check` looks at
        the trees of what could be read, also where there are errors: no error hides another one.
        """
        for kind, hint in OTHER_KINDS.items():
            if isinstance(document.data, dict) and kind in document.data:
                message = f"expected a mission, got a {kind}"
                return None, (document.diagnostic("BT-111", (kind,), message, hint, key=True),)
        if isinstance(document.data, dict) and isinstance(document.data.get("mission"), dict):
            return None, tuple(_nested(document))
        reader = NodeReader(document)
        written = reader.written(MissionFile, (), document.data)
        requirements = self.read_requirements(reader)
        if written is None and isinstance(document.data, dict):
            # Without a name or a tree the rest can still be looked at.
            written = _stand_in(document.data)
        shelf = TreeLibrary(permissions)
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
        trees, diagnostics = read_trees(shelf, reader.limits, reader.places)
        diagnostics = [*reader.diagnostics, *shelf.diagnostics, *diagnostics]
        if written is None or tree is None:
            return None, in_order(diagnostics)
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
            requirements=requirements,
            tree=tree,
            lost=frozenset(reader.lost),
            file=document.file,
            document=document,
            included=tuple(shelf.included),
        )
        diagnostics += [*wrong, *size_diagnostics(document, mission)]
        goals = (step.ros_name for step in all_steps(mission) if isinstance(step, GoalNode))
        diagnostics += server_diagnostics(document, written.servers, goals)
        diagnostics += check(mission)
        diagnostics += self.check_requirements(mission, reader.lost_nodes)
        if not _is_refused(diagnostics) and document.is_xml:
            diagnostics += [value.diagnostic("BT-1204") for value in live_values(mission)]
        if _is_refused(diagnostics):
            return None, in_order(diagnostics)
        noted = tuple(warnings(mission))
        return replace(mission, warnings=noted), in_order([*noted, *diagnostics])


def _is_refused(diagnostics: Iterable[Diagnostic]) -> bool:
    return any(diagnostic.severity == "error" for diagnostic in diagnostics)


def _nested(document: Document) -> list[Diagnostic]:
    """Return what is wrong in a file whose whole mission stands under `mission`."""
    inner = document.data["mission"]
    message = f"expected the name of the mission, got {describe(inner)}"
    hint = "write 'mission: NAME', and its keys at the head of the file, beside it"
    reader = NodeReader(document)
    reader.report("BT-301", ("mission",), message, hint)
    if "tree" in inner:
        reader.node(inner["tree"], ("mission", "tree"))
    return reader.diagnostics


def _stand_in(data: Mapping[str, Any]) -> MissionFile | None:
    named = {**data, "mission": "?", "tree": data.get("tree")}
    reader = NodeReader(Document("", named, Place(1, 1), ()))
    return reader.written(MissionFile, (), named)


def required(examined: Examined) -> Mission:
    """Return the mission that was read. Raises InputError with everything wrong with it."""
    mission, diagnostics = examined
    if mission is None:
        raise InputError(diagnostics)
    return mission
