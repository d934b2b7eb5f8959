"""A mission file, loaded: its head, its own tree, and the trees that have names."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

from bt_mission.base.diagnostics import Diagnostic
from bt_mission.base.nature import Nature
from bt_mission.base.verdicts import OnViolation
from bt_mission.base.yaml.document import Document
from bt_mission.language.expressions.places import Pose
from bt_mission.language.expressions.values import Plain, Type, type_of
from bt_mission.language.follow import Follow
from bt_mission.language.nodes.base import Key, NodeModel
from bt_mission.language.nodes.fields import ProgramEntry
from bt_mission.language.nodes.subtree import TreeNode


@dataclass(frozen=True, kw_only=True)
class Tree:
    """A tree with a name, as its file has it: a named one, or the mission's own.

    `inputs` are the defaults of those that have one, `types` the types of all, `outputs` those of
    the variables that a caller may take. `follow` are variables that follow topics, `lost` are
    variables whose writer could not be read.
    """

    name: str
    body: NodeModel
    document: Document = field(repr=False, compare=False)
    path: tuple[Key, ...] = ()
    inputs: Mapping[str, Plain] = field(default_factory=dict)
    types: Mapping[str, Type | None] = field(default_factory=dict)
    outputs: Mapping[str, Type] = field(default_factory=dict)
    follow: tuple[Follow, ...] = ()
    lost: frozenset[str] = frozenset()
    is_main: bool = False

    @property
    def constants(self) -> Mapping[str, Plain]:
        """The inputs that have this value in every run: only those of the mission itself."""
        return self.inputs if self.is_main else {}


@dataclass(frozen=True)
class NodeFactory:
    """The factory of a user's node in a simulation, and its place in a file.

    Attributes:
        target: ``module:name``, or ``file.py:name`` for a file beside the document or below it.
        document: The file that names it.
        path: Where in the document.
        name: Of a program, for people; empty is that of its file.
    """

    target: str
    document: Document = field(repr=False, compare=False)
    path: tuple[Key, ...] = field(repr=False, compare=False)
    name: str = field(default="", compare=False)

    @property
    def file(self) -> str:
        """The file that names it."""
        return self.document.file

    def diagnostic(self, code: str, message: str, hint: str | None = None) -> Diagnostic:
        """Return an error at its place."""
        return self.document.diagnostic(code, self.path, message, hint)


def node_factories(
    document: Document, entries: Sequence[str | ProgramEntry]
) -> tuple[NodeFactory, ...]:
    """Return what stands under ``nodes`` at the head of a file."""
    written = [
        entry if isinstance(entry, ProgramEntry) else ProgramEntry(entry, "") for entry in entries
    ]
    return tuple(
        NodeFactory(entry.target, document, ("nodes", n), entry.name)
        for n, entry in enumerate(written)
    )


@dataclass(frozen=True)
class Requirement:
    """A requirement as it is written; ``bt_mission.requirements`` parses and evaluates it.

    Attributes:
        name: In its file.
        text: The formula that must hold of a run.
        on_violation: What is done when it does not hold.
    """

    name: str
    text: str
    on_violation: OnViolation = "report"


@dataclass(frozen=True, kw_only=True)
class Mission:
    """A mission file, loaded. `trees` are those with names, in the file and in what it includes.

    `inputs` holds the values after `--set`, `places` its own named places, `follow` the variables
    that follow topics, `nodes` what makes the nodes of the user that join a simulation.

    `observe` is how long time continues after the end, s. `map` says whether the robot has the map
    of its world or makes one, `nature` what differs from run to run in a simulation; None is what
    the world says.
    """

    name: str
    tree: NodeModel
    description: str = ""
    world: str | None = None
    robot: str = "waffle"
    seed: int = 0
    map: Literal["known", "unknown"] = "known"
    observe: float = 0.0
    nature: Nature | None = None
    inputs: Mapping[str, Plain] = field(default_factory=dict)
    places: Mapping[str, Pose] = field(default_factory=dict)
    trees: Mapping[str, Tree] = field(default_factory=dict)
    nodes: tuple[NodeFactory, ...] = ()
    follow: tuple[Follow, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    lost: frozenset[str] = field(default=frozenset(), repr=False)
    file: str = "<text>"
    warnings: tuple[Diagnostic, ...] = ()
    document: Document = field(repr=False, compare=False)
    included: tuple[Document, ...] = field(default=(), repr=False, compare=False)

    @property
    def documents(self) -> tuple[Document, ...]:
        """Its file, and those that it includes, directly or not."""
        return (self.document, *self.included)

    def portable_name(self, file: str) -> str:
        """Name one of its files without the folders of this machine: from the mission's folder."""
        if not Path(file).is_absolute():
            return file
        return os.path.relpath(file, Path(self.file).parent)

    @cached_property
    def root(self) -> NodeModel:
        """Its tree as it is built: a root with children has the mission's name if it has no own."""
        tree = self.tree
        is_named = tree.name or not tree.below
        return tree if is_named else tree.model_copy(update={"name": self.name})

    def below(self, node: NodeModel) -> Sequence[NodeModel]:
        """Return the nodes below one in the tree as it is built: a used tree is below its use."""
        if not self.trees or not isinstance(node, TreeNode):
            return node.below
        tree = self.trees.get(node.tree)
        return node.below if tree is None else (tree.body,)

    def node_at(self, place: str) -> NodeModel | None:
        """Return the node at a place such as ``0.1``, in used trees, too; None without one."""
        first, *rest = place.split(".")
        node = self.root if first == "0" else None
        for part in rest:
            if node is None:
                return None
            below = self.below(node)
            node = below[int(part)] if int(part) < len(below) else None
        return node

    @property
    def main(self) -> Tree:
        """The mission's own tree."""
        return Tree(
            name=self.name,
            body=self.root,
            document=self.document,
            path=("tree",),
            inputs=self.inputs,
            types={name: type_of(value) for name, value in self.inputs.items()},
            follow=self.follow,
            lost=self.lost,
            is_main=True,
        )

    @property
    def all_trees(self) -> tuple[Tree, ...]:
        """The mission's own tree, and all that have names."""
        return (self.main, *self.trees.values())
