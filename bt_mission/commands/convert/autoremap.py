"""The variables that `_autoremap` shares between trees without a port that says so.

In BehaviorTree.CPP such a tree shares every variable with its caller, private ones (`_x`) left out.
Here it shares its ports. A variable that is not a port may stay in the tree where nothing else
can read it: no other tree has the name, and no two uses of the tree run at the same time.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from typing_extensions import override

from bt_mission.base.yaml.document import Document
from bt_mission.commands.convert.elements import Element
from bt_mission.commands.convert.table import SUBTREE
from bt_mission.language.checks.scope import names_read, written_by
from bt_mission.language.expressions.expression import names_in
from bt_mission.language.node_reader import NodeReader
from bt_mission.language.nodes.base import NodeModel

_AT_ONCE = frozenset(("Parallel", "ParallelAll", "ReactiveSequence", "ReactiveFallback"))


class _Nodes(NodeReader):
    """Reads nodes for their names; the loader reports what is wrong with them."""

    @override
    def report(self, *_: object, **__: object) -> None:
        pass


@dataclass(frozen=True)
class RemappedTree:
    """A tree as an element and as a node, with the names of its ports."""

    element: Element
    body: Document
    ports: Collection[str]

    @cached_property
    def nodes(self) -> tuple[NodeModel, ...]:
        """Its nodes; none where they cannot be read."""
        body = _Nodes(self.body).node(self.body.data, ())
        return () if body is None else tuple(body.walk())

    @cached_property
    def written(self) -> frozenset[str]:
        """The variables that it writes."""
        return frozenset(name for node in self.nodes for name in written_by(node))

    @property
    def variables(self) -> frozenset[str]:
        """The variables that it writes or reads."""
        read = (names_in(value.value) for node in self.nodes for value in node.reads())
        return self.written.union(*read)

    @cached_property
    def names(self) -> frozenset[str]:
        """All names in it, some of which may be fields of messages, or words."""
        return self.written.union(*map(names_read, self.nodes))

    def elements(self) -> Iterator[Element]:
        """Yield its elements."""
        waiting = [self.element]
        while waiting:
            yield (element := waiting.pop())
            waiting += element.children


def shared_names(tree_id: str, trees: Mapping[str, RemappedTree]) -> list[str]:
    """Return the variables that a tree with `_autoremap` shares though they are no ports.

    Args:
        tree_id: The tree.
        trees: All trees of a mission, by their IDs.
    """
    tree = trees[tree_id]
    elsewhere = frozenset[str]().union(*(trees[key].names for key in trees if key != tree_id))
    elements = [element for each in trees.values() for element in each.elements()]
    uses = [element for element in elements if element.tag == SUBTREE]
    count = sum(use.attributes["ID"].value == tree_id for use in uses if "ID" in use.attributes)
    is_at_once = count > 1 and any(element.tag in _AT_ONCE for element in elements)
    return [
        name
        for name in sorted(tree.variables)
        if name not in tree.ports and not name.startswith("_")
        if is_at_once or name not in tree.written or name in elsewhere
    ]


def declaration(tree_id: str, tree: RemappedTree, shared: Collection[str]) -> str:
    """Return what to write under `TreeNodesModel`, so that these names are ports."""
    ports = "".join(
        f'<{"output" if name in tree.written else "input"}_port name="{name}" type="..."/>'
        for name in shared
    )
    return f'write under TreeNodesModel: <SubTree ID="{tree_id}">{ports}</SubTree>'
