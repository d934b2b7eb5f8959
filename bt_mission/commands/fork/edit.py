"""Another version of a recorded mission, as the change of a fork."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.commands.fork.change import ForkChange
from bt_mission.commands.fork.source import ForkSource
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.permissions import Permissions
from bt_mission.language.trees import used
from bt_mission.sessions.check import examine

FIXED = ("world", "robot", "seed", "map", "nodes")
"""The settings of a mission that cannot change after a run has begun."""


def edited(source: ForkSource, path: Path, permissions: Permissions, step_ns: int) -> ForkChange:
    """Return the change to another version of the mission at a control step.

    An input with another value in the file takes that value at the fork; the others keep the values
    of the recorded run.

    Raises:
        InputError: The mission is invalid, or has another world, robot or seed.
    """
    new = required(examine(path, permissions=permissions))
    if others := list(_other_heads(source.written, new)):
        raise InputError(others)
    recorded, written = source.mission_at(step_ns), source.written.inputs
    kept = {name: value for name, value in recorded.inputs.items() if name in new.inputs}
    values = {
        name: value for name, value in new.inputs.items() if value != written.get(name, value)
    }
    names = {requirement.name for requirement in (*new.requirements, *source.written.requirements)}
    added = tuple(
        requirement for requirement in recorded.requirements if requirement.name not in names
    )
    edit = replace(
        new,
        world=recorded.world,
        robot=recorded.robot,
        seed=recorded.seed,
        observe=new.observe or recorded.observe,
        nodes=recorded.nodes,
        inputs={**new.inputs, **kept},
        requirements=(*new.requirements, *added),
    )
    new_tree = frame_change(recorded, new)
    if new_tree is None:
        values |= {name: new.inputs[name] for name in new.inputs.keys() - written.keys()}
    if new_tree is not None and recorded is not source.mission:
        return ForkChange(values, edit, is_revision=True)
    return ForkChange(values, edit, new_tree)


def _other_heads(before: Mission, after: Mission) -> Iterator[Diagnostic]:
    for name in FIXED:
        old, other = _head(before, name), _head(after, name)
        if old != other:
            message = f"'{name}' is fixed at the start of a run: recorded {old}, here {other}"
            yield after.document.diagnostic("BT-1004", (name,), message)


def _head(mission: Mission, name: str) -> str:
    if name == "nodes":
        return ", ".join(node.target for node in mission.nodes) or "none"
    return str(getattr(mission, name))


# ---- nodes ---------------------------------------------------------------------------------


def frame_change(before: Mission, after: Mission) -> Diagnostic | None:
    """Return the first place at which another version of a mission needs another tree, if any.

    Without one, the nodes of the first tree can use the second version.
    """
    return next(_frame_changes(before, after), None)


def _frame_changes(before: Mission, after: Mission) -> Iterator[Diagnostic]:
    if _followed(before) != _followed(after):
        yield after.main.document.diagnostic(
            "BT-1004", ("follow",), "other variables follow topics"
        )
    yield from _node_changes(before.tree, after.tree, after.main)
    for name in used(before):
        old, other = before.trees[name], after.trees.get(name)
        if other is None:
            yield after.main.document.diagnostic(
                "BT-1004", ("trees",), f"there is no tree '{name}'"
            )
            continue
        if _signature(old) != _signature(other):
            message = f"the tree '{name}' has other inputs, outputs or variables"
            yield other.document.diagnostic("BT-1004", other.path, message, key=True)
        yield from _node_changes(old.body, other.body, other)


def _node_changes(before: NodeModel, after: NodeModel, tree: Tree) -> Iterator[Diagnostic]:
    waiting: list[tuple[NodeModel | None, NodeModel | None, NodeModel]] = [(before, after, after)]
    while waiting:
        old, other, parent = waiting.pop()
        if old is None or other is None or old.frame != other.frame:
            yield tree.document.diagnostic(
                "BT-1004", (other or parent).path, _difference(old, other)
            )
            return
        below = zip_longest(old.below, other.below)
        waiting += reversed([(*pair, other) for pair in below])


def _difference(before: NodeModel | None, after: NodeModel | None) -> str:
    if before is None:
        return "an additional node"
    if after is None:
        return f"the node '{before.label}' is missing"
    return f"a node other than '{before.label}', or one with another structure"


def _signature(tree: Tree) -> tuple[object, ...]:
    return (tree.inputs, tree.types, tree.outputs, _followed(tree))


def _followed(part: Mission | Tree) -> list[object]:
    return [followed.settings for followed in part.follow]
