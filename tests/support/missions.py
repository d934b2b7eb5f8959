"""Missions compared by what they mean, wherever they stand in their files."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bt_mission.language.mission import Mission
from bt_mission.language.nodes.steps import Composite, Decorator, Step


def bare(step: Step) -> Step:
    """A step and all below it, without places."""
    found = replace(step, line=0, column=0)
    if isinstance(found, Composite):
        return replace(found, children=tuple(bare(one) for one in found.children))
    return replace(found, child=bare(found.child)) if isinstance(found, Decorator) else found


def meaning(mission: Mission) -> Any:
    """Everything of a mission but where it stands, and what is a warning."""
    trees = {
        name: replace(tree, body=bare(tree.body), path=()) for name, tree in mission.trees.items()
    }
    return replace(
        mission, tree=bare(mission.tree), trees=trees, file="", warnings=(), document=None
    )
