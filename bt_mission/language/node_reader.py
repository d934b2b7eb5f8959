"""From the nodes of a mission file to models, one by one, so that no mistake hides another.

A node with mistakes is kept without its wrong parts where that leaves a node, so that the nodes
below and behind it are checked, too; such a draft is never run.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import pydantic

from bt_mission.base.diagnostics import (
    MOST_DIAGNOSTICS,
    Diagnostic,
    describe,
    listed,
    quoted,
)
from bt_mission.base.yaml.document import Document
from bt_mission.base.yaml.models import model_diagnostics
from bt_mission.language.action_names import BROKEN, plugged
from bt_mission.language.expressions.values import Type
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.follow import Follow, FollowSettings
from bt_mission.language.nodes import remedies
from bt_mission.language.nodes.base import (
    CompositeNode,
    Key,
    NodeModel,
    NodePlace,
    Reading,
    Written,
)
from bt_mission.language.nodes.composites import SequenceNode
from bt_mission.language.nodes.registry import GENERAL, KINDS

NODE = "a node such as 'wait: 2.0'"
TIMEOUT = "timeout"

WrittenModel = TypeVar("WrittenModel", bound=Written)


@dataclass(frozen=True)
class Signature:
    """A named tree, as far as those who use it have to know it; `types` are those of its inputs."""

    name: str
    definition: TreeDefinition
    types: Mapping[str, Type | None]
    document: Document
    path: tuple[Key, ...]


@dataclass
class NodeReader(Reading):
    """Reads nodes and collects all diagnostics.

    `lost` are the outputs of nodes with mistakes: they have a writer, though none that is kept.
    `lost_nodes` are the names of those nodes, and of the nodes in them.
    """

    lost: set[str] = field(default_factory=set)
    lost_nodes: set[str] = field(default_factory=set)

    def written(
        self, model: type[WrittenModel], path: tuple[Key, ...], data: Any
    ) -> WrittenModel | None:
        """Return a mapping as a model; its wrong parts are noted and left out."""
        try:
            return model.model_validate(data)
        except pydantic.ValidationError as error:
            diagnostics = model_diagnostics(self.document, error, model, path)
            self.diagnostics += [_remedied(diagnostic, model) for diagnostic in diagnostics]
            if error.error_count() > MOST_DIAGNOSTICS:
                return None
            for detail in error.errors(include_url=False):
                data = _without(data, detail["loc"])
        try:
            return model.model_validate(data)
        except pydantic.ValidationError:
            return None

    def follows(self, path: tuple[Key, ...], inputs: Collection[str]) -> tuple[Follow, ...]:
        """Return the variables that follow topics, of a mission or a named tree.

        Args:
            path: Where that is in the document.
            inputs: The names of its inputs.
        """
        followed: dict[str, Follow] = {}
        for place, entry in self._written_follows((*path, "follow")):
            if self.is_full:
                break
            if not isinstance(entry, dict):
                example = "'topic', 'type', 'field' and 'as', or a list of such mappings"
                self.report(
                    "BT-301", place, f"expected a mapping with {example}, got {describe(entry)}"
                )
                continue
            settings = self.written(FollowSettings, place, entry)
            name = entry.get("as")
            if settings is None:
                if isinstance(name, str):
                    self.lost.add(name)  # who reads it is not to blame
                continue
            name = settings.variable
            if name in inputs:
                message = f"'{name}' is an input, and inputs never change; choose another name"
                self.report("BT-408", (*place, "as"), message)
            elif name in followed:
                message = f"'{name}' already follows a topic, in line {followed[name].line}"
                self.report("BT-408", (*place, "as"), message)
            else:
                position = NodePlace(*self.document.position(place), place)
                followed[name] = Follow(settings, self.document.file, position)
        return tuple(followed.values())

    def _written_follows(self, path: tuple[Key, ...]) -> Iterator[tuple[tuple[Key, ...], Any]]:
        """Yield what stands under `follow`, one mapping or a list of them, each with its place."""
        data = self.document.data
        for key in path:
            if not isinstance(data, dict) or key not in data:
                return
            data = data[key]
        if isinstance(data, list):
            yield from (((*path, index), entry) for index, entry in enumerate(data))
        else:
            yield path, data

    def node(self, data: Any, path: tuple[Key, ...]) -> NodeModel | None:
        """Return a node with all below it, or None where nothing of it can be kept."""
        if self.is_full:
            return None
        before = len(self.diagnostics)
        kind = self.kind(data, path)
        node = self.rest(data, path) if kind is None else self.node_of(kind, data, path)
        if len(self.diagnostics) > before and isinstance(data, dict):
            outputs, values = data.get("outputs"), data.get("set")
            lost = [*outputs.values()] if isinstance(outputs, dict) else []
            lost += values if isinstance(values, dict) else ()
            self.lost.update(name for name in lost if isinstance(name, str))
            # Those of nodes in it were noted with them, or were never read.
            self.lost_nodes.update(_names_in(data if kind is None else {"name": data.get("name")}))
        return node

    def node_of(self, kind: str, data: dict[str, Any], path: tuple[Key, ...]) -> NodeModel | None:
        """Return a node of a known kind."""
        model = KINDS[kind]
        known = model.keys
        modifiers = [name for name in known if name != kind]
        for key in data:
            if key not in known and not self.is_full:
                message = f"no modifier {quoted(key)} for {kind} (it takes: {listed(modifiers)})"
                hint = remedies.unknown_modifier(key, modifiers)
                self.report("BT-204", (*path, key), message, hint, key=True)
        fields = {key: data[key] for key in data if key in known}
        fields["@place"] = NodePlace(*self.document.position(path), path)
        if self.is_misshapen(kind, data[kind], path):
            self.lost_nodes.update(_names_in(data))
            return self.rest(data, path)
        children = {
            place: self.node(part, (*path, *place)) for place, part in model.written_children(data)
        }
        below = [node for node in children.values() if node is not None]
        if len(below) == len(children):
            for (name, *index), child in children.items():
                fields[str(name)] = below if index else child
        written = self.written(model, path, fields)
        if written is not None and len(below) == len(children):
            node = written.completed(self)
            # Which keys were written nobody asks, and sets of them take a fifth of the memory.
            object.__setattr__(node, "__pydantic_fields_set__", _NO_KEYS)
            return node
        return _draft(written, below, fields["@place"]) if below else None

    def rest(self, data: Any, path: tuple[Key, ...]) -> NodeModel | None:
        """Return the nodes in a part that is not a node, so that their mistakes are seen, too."""
        below = [self.node(part, (*path, *place)) for place, part in _nodes_in(data)]
        kept = [node for node in below if node is not None]
        if isinstance(data, dict):
            loops = [part for key in _strange(data) if isinstance(part := data[key], dict)]
            self.lost.update(
                name for loop in loops for name, part in loop.items() if isinstance(part, list)
            )
        return _draft(None, kept, NodePlace(*self.document.position(path), path)) if kept else None

    def is_misshapen(self, kind: str, value: Any, path: tuple[Key, ...]) -> bool:
        """Note where a type of node has one value instead of fields, or nodes without dashes."""
        wrong = remedies.lone_value(kind, value)
        if issubclass(KINDS[kind], CompositeNode) and isinstance(value, dict) and value:
            wrong = f"expected a list, got {describe(value)}", remedies.NO_DASHES
        if wrong is not None:
            self.report("BT-207", (*path, kind), *wrong)
        return wrong is not None

    def kind(self, data: Any, path: tuple[Key, ...]) -> str | None:
        """Return the one kind that a node has; note what is wrong where it has not one."""
        if not isinstance(data, dict):
            is_kind = isinstance(data, str) and data in KINDS
            hint = f"write '{data}: ...'" if is_kind else None
            if isinstance(data, list) and data:
                hint = remedies.LIST_OF_NODES
            self.report("BT-206", path, f"expected {NODE}, got {describe(data)}", hint)
            return None
        kinds: list[str] = [key for key in data if key in KINDS]
        if len(kinds) > 1 and TIMEOUT in kinds:
            kinds.remove(TIMEOUT)  # beside another kind it is that kind's modifier
        if kinds == [TIMEOUT] and "do" not in data and data.keys() - _MODIFIERS - {TIMEOUT}:
            kinds = []  # a modifier of a kind that is misspelt
        if len(kinds) == 1:
            return kinds[0]
        if kinds:
            message = f"two kinds in one node: {quoted(kinds[0])} and {quoted(kinds[1])}"
            around = [kind for kind in kinds[:2] if "do" in KINDS[kind].child_keys]
            hint = remedies.two_kinds(kinds[0], kinds[1], around)
            self.report("BT-205", (*path, kinds[1]), message, hint, key=True)
        elif not data:
            self.report("BT-206", path, f"expected {NODE}, got an empty mapping")
        else:
            key = next(_strange(data), next(iter(data)))
            message, hint = remedies.unknown_kind(data, key, KINDS, _MODIFIERS)
            plugged()
            if key in BROKEN:
                message, hint = f"the plug-in {quoted(key)} cannot be used: {BROKEN[key]}", None
            code = "BT-215" if key in BROKEN else "BT-203"
            self.report(code, (*path, key), message, hint, key=True)
        return None


def _remedied(diagnostic: Diagnostic, model: type[Written]) -> Diagnostic:
    """Return a diagnostic with a remedy where a modifier of a node stands among its settings.

    Also where a topic to be followed has no type.
    """
    if model is FollowSettings and diagnostic.message == "'type' is missing":
        return replace(diagnostic, hint=remedies.TYPE_OF_TOPIC)
    match = _UNKNOWN_KEY.match(diagnostic.message)
    if match is None:
        return diagnostic
    if issubclass(model, NodeModel) and match[1] in model.keys:
        return replace(diagnostic, hint=remedies.beside(match[1], model.kind))
    owner = model.kind if issubclass(model, NodeModel) else _OWNERS.get(model, "")
    hint = remedies.unknown_key(owner, match[1], KINDS) or diagnostic.hint
    return replace(diagnostic, hint=hint)


def _strange(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of a node that are no modifiers."""
    return (key for key in data if key not in _MODIFIERS and key != TIMEOUT)


def _nodes_in(data: Any) -> Iterator[tuple[tuple[Key, ...], Any]]:
    """Yield what may be nodes in a part that is no node itself, each with its path."""
    if isinstance(data, list):
        yield from (((index,), item) for index, item in enumerate(data) if isinstance(item, dict))
    elif isinstance(data, dict):
        for key, part in data.items():
            if isinstance(part, dict) and key in _BELOW:
                yield (key,), part
            elif key not in _MODIFIERS or key in _BELOW:
                lists = part if isinstance(part, dict) else {None: part}
                for name, items in lists.items():
                    if isinstance(items, list) and any(_is_like_node(item) for item in items):
                        place = (key,) if name is None else (key, name)
                        yield from (((*place, *index), item) for index, item in _nodes_in(items))


def _is_like_node(data: Any) -> bool:
    return isinstance(data, dict) and any(key in KINDS or key in _BELOW for key in data)


def _draft(written: NodeModel | None, below: list[NodeModel], place: NodePlace) -> SequenceNode:
    """Return what can be kept of a node with mistakes: the nodes below it."""
    name = "" if written is None else written.name
    return SequenceNode.model_construct(children=tuple(below), name=name, place=place)


def _names_in(data: Any) -> Iterator[str]:
    """Yield what is written as the name of a node, or of anything else, in a part of a file."""
    if isinstance(data, dict) and isinstance(data.get("name"), str):
        yield data["name"]
    for part in data.values() if isinstance(data, dict) else data if isinstance(data, list) else ():
        yield from _names_in(part)


def _without(data: Any, loc: tuple[Key, ...]) -> Any:
    """Return data without the part at a location, the rest shared."""
    if not loc or not isinstance(data, dict) or loc[0] not in data:
        return data
    key = str(loc[0])
    inner = data[key]
    deeper = len(loc) > 1 and isinstance(inner, dict) and loc[1] in inner
    rest = {name: part for name, part in data.items() if name != key}
    return {**rest, key: _without(inner, loc[1:])} if deeper else rest


_OWNERS = {MissionFile: "mission", TreeDefinition: "tree"}
_UNKNOWN_KEY = re.compile(r"unknown key '([^']*)'")
_NO_KEYS: set[str] = set()
_BELOW = frozenset(("do", "then", "else", "body", "child", "children", "steps"))
"""Keys with nodes below one, here and elsewhere."""
_MODIFIERS = frozenset(name for model in GENERAL.values() for name in model.keys) - {*GENERAL}
"""Also of nodes with a short name: they take those of `action`."""
