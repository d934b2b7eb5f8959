"""The nodes of a tree, numbered depth first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from py_trees.behaviour import Behaviour

from bt_mission.executive.behaviours.python_leaf import PythonLeaf
from bt_mission.executive.events.events import NodeInfo
from bt_mission.executive.status import node_paths


@dataclass(frozen=True)
class NumberedTree:
    """A tree with the index, the place and the description of each of its nodes."""

    root: Behaviour
    paths: Mapping[Behaviour, str]
    """The place of each node, such as ``0.1.0``, depth first."""
    nodes: tuple[Behaviour, ...]
    indices: Mapping[Behaviour, int]
    """The index of each node, depth first."""
    infos: tuple[NodeInfo, ...]

    @classmethod
    def of(
        cls,
        root: Behaviour,
        details: Mapping[str, tuple[str, ...]],
        names: Mapping[str, str] | None = None,
    ) -> Self:
        """Number the nodes of a tree.

        Args:
            root: The root of the tree.
            details: The details of each node by its path.
            names: The names of nodes that get another one, by their paths.
        """
        paths, names = node_paths(root), names or {}
        numbers = {path: index for index, path in enumerate(paths.values())}
        infos = tuple(
            NodeInfo(
                names.get(path, node.name),
                type(node.behaviour if isinstance(node, PythonLeaf) else node).__name__,
                path,
                numbers.get(path.rpartition(".")[0], 0),
                details.get(path, ()),
            )
            for node, path in paths.items()
        )
        indices = {node: index for index, node in enumerate(paths)}
        return cls(root, paths, tuple(paths), indices, infos)
