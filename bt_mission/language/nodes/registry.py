"""Every kind of node of the mission language."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from typing_extensions import override

from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes import action, composites, decorators, interfaces, leaves, subtree
from bt_mission.language.nodes.base import NodeModel

_MODULES = (composites, decorators, leaves, interfaces, action, subtree)

GENERAL: dict[str, type[NodeModel]] = {
    node.kind: node
    for module in _MODULES
    for node in vars(module).values()
    if isinstance(node, type) and issubclass(node, NodeModel) and node.is_kind()
}
"""The kinds besides the short names of actions: the classes of the modules, in their order."""


class Kinds(Mapping[str, type[NodeModel]]):
    """All of them. The class of an action's short name is made when it is asked for."""

    @override
    def __getitem__(self, key: str) -> type[NodeModel]:
        return GENERAL.get(key) or action.short_node(key)

    @override
    def __contains__(self, key: object) -> bool:
        return key in GENERAL or key in ACTION_NAMES

    @override
    def __iter__(self) -> Iterator[str]:
        yield from GENERAL
        yield from (name for name in ACTION_NAMES if name not in GENERAL)

    @override
    def __len__(self) -> int:
        return sum(1 for _ in self)


KINDS = Kinds()
"""Every kind of node by the key that names it."""
