"""Every kind of node of the mission language."""

from __future__ import annotations

from bt_mission.language.nodes import action, composites, decorators, interfaces, leaves, subtree
from bt_mission.language.nodes.base import NodeModel

_MODULES = (composites, decorators, leaves, interfaces, action, subtree)

KINDS: dict[str, type[NodeModel]] = {
    node.kind: node
    for module in _MODULES
    for node in vars(module).values()
    if isinstance(node, type) and issubclass(node, NodeModel) and node.is_kind()
}
KINDS |= {name: node for name, node in action.SHORT_NODES.items() if name not in KINDS}
"""Every kind of node by the key that names it: the classes of the modules, in their order."""
