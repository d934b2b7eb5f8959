"""From a mission to an XML file that Groot 2 shows: a node becomes the first row that it fits."""

from __future__ import annotations

import itertools
import operator
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field
from functools import reduce
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import MOST_DIAGNOSTICS, Diagnostic, InputError, in_order, quoted
from bt_mission.base.yaml.document import Document
from bt_mission.commands.convert import table
from bt_mission.commands.convert.attributes import (
    LABELS,
    VALUE,
    Codec,
    constant,
    is_illegal,
    plain_text,
)
from bt_mission.commands.convert.document import HEAD
from bt_mission.commands.convert.elements import Tag, xml_text
from bt_mission.commands.convert.palette import (
    leaf_models,
    palette_xml,
    types_read,
    used_attributes,
)
from bt_mission.commands.convert.scripts import CONDITION
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.checks.live_values import live_values
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.goal_limits import DEFAULTS, GoalLimitsTable
from bt_mission.language.loader import required
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Tree
from bt_mission.language.node_reader import NodeReader, Signature
from bt_mission.language.nodes import base
from bt_mission.language.nodes.fields import input_value
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.mission_file import read_mission

_RESERVED = table.REGISTERED | {"Root", "root", "Action", "Condition", "Control", "Decorator"}
"""Names that BehaviorTree.CPP refuses as the IDs of trees, besides those of the leaves."""

_ID = re.compile(r"[^\W\d][\w-]*")
_ABSENT = object()
_ONLY_YAML = "write its nodes one by one, or keep the mission in YAML"
_NAMED_CHILDREN = (
    "'parallel' with names of children",
    "write 'all' or 'any', or move these children into a separate parallel",
)
_POLICY = "use 'rest: halt', or with 'rest: finish' write all and any, or any and impossible"


def mission_xml(document: Document, shapes: FindShapes | None = None) -> str:
    """Return a mission file as XML. Raises InputError with everything that XML cannot express.

    `shapes` has the fields of ROS types, so that the ports of every leaf are listed.
    """
    return _MissionWriter(document, shapes).text()


def mission_palette(document: Document, shapes: FindShapes | None = None) -> str:
    """Return the palette with every attribute in it that a mission uses.

    Raises:
        InputError: With all errors of the mission, and all parts that XML cannot express.
    """
    return palette_xml(shapes, _MissionWriter(document, shapes).used)


# ---- nodes -----------------------------------------------------------------------------------


@dataclass
class _Match:
    """How a node fits a row.

    Attributes:
        attributes: Those of the element.
        below: What stands below it: the column, the part of the node, and the path to it.
        refused: What has no counterpart: where, whether that is a key, and why.
    """

    attributes: dict[str, str] = field(default_factory=dict)
    below: list[tuple[table.Child | table.Children | table.Question, Any, base.Path]] = field(
        default_factory=list
    )
    refused: list[tuple[base.Path, bool, table.Refusal]] = field(default_factory=list)

    def fits(self, part: Any, value: Any, path: base.Path) -> bool:
        """Take a part of a node in; return whether it is what the row has there."""
        match part:
            case table.Port():
                return value is _ABSENT or self._port(part, value, path)
            case table.Ports():
                self._entries(part, {} if value is _ABSENT else value, path, ())
            case table.Never():
                if value is not _ABSENT and value != part.unless:
                    self.refused.append((path, True, part.refusal))
            case table.Child() | table.Children() | table.Question():
                if value is not _ABSENT:
                    self.below.append((part, value, path))
                elif isinstance(part, table.Child) and part.absent:
                    self.below.append((part, None, path))
            case dict():
                inner = {} if value is _ABSENT else value
                return isinstance(inner, dict) and self.fits_node(part, inner, path)
            case _:
                return bool(value == part)
        return True

    def fits_node(self, node: Mapping[str, Any], data: Mapping[str, Any], path: base.Path) -> bool:
        """Take a mapping in; return whether each of its keys is what the row has there."""
        return all(
            self.fits(part, data.get(key, _ABSENT), (*path, key)) for key, part in node.items()
        )

    def _port(self, port: table.Port, value: Any, path: base.Path) -> bool:
        written = port.codec.write(value)
        if written is None and port.refusal is not None:
            self.refused.append((path, False, port.refusal))
        self.attributes[port.name] = written or ""
        return written is not None or port.refusal is not None

    def _entries(
        self, ports: table.Ports, values: Mapping[str, Any], path: base.Path, names: table.Names
    ) -> None:
        for key, value in values.items():
            inner, place = (*names, key), (*path, key)
            attribute = ports.attribute(inner)
            if ports.holds == "nested" and isinstance(value, dict) and value:
                self._entries(ports, value, place, inner)
            elif isinstance(value, dict):
                refusal = "an empty message", "leave it out; the meaning is the same"
                self.refused.append((place, False, refusal))
            elif attribute is None:
                what = f"the field {quoted('.'.join(inner))}, whose name is invalid in ROS,"
                self.refused.append((place, False, (what, "see 'bt-mission check'")))
            else:
                self.attributes[attribute] = ports.codec.write(value) or ""


@dataclass
class _NodeWriter:
    """Writes nodes of one document as elements, and collects what XML has no counterpart for.

    `signatures` are the named trees that may be used, `limits` are those of the mission.
    """

    document: Document
    signatures: Mapping[str, Signature]
    limits: GoalLimitsTable
    diagnostics: list[Diagnostic] = field(default_factory=list)
    _names: set[str] = field(default_factory=set)
    """Of the uses of trees so far."""

    def refuse(self, path: base.Path, what: str, instead: str, *, key: bool = False) -> None:
        """Note what XML has no counterpart for."""
        if len(self.diagnostics) < MOST_DIAGNOSTICS:
            message = f"{what} has no counterpart in XML"
            self.diagnostics.append(
                self.document.diagnostic("BT-1205", path, message, instead, key=key)
            )

    def node(self, data: dict[str, Any], path: base.Path) -> Tag:
        """Return a node and all below it as an element."""
        kind = NodeReader(self.document).kind(data, path)
        assert kind is not None, "the mission was read before"
        if kind in ACTION_NAMES or kind == "action":
            action = data["action"]["name"] if kind == "action" else ACTION_NAMES[kind].name
            limits = self.limits.of(action).items()
            given = {name: limit for name, limit in limits if limit != DEFAULTS.get(name)}
            data = {**given, **data}
        named = {"name": data["name"]} if data.get("name") else {}
        rows = table.rows_for(kind)
        if kind == "tree":
            use = data["tree"] if isinstance(data["tree"], dict) else {"name": data["tree"]}
            data = {**data, "tree": use}
            rows = (self._tree_row(use, data.get("outputs", {})),)
            self._refuse_name(data.get("name"), path)
        for row in rows:
            if (match := self._matched(row, data, path)) is not None:
                for place, key, refusal in match.refused:
                    self.refuse(place, *refusal, key=key)
                attributes = {**named, **match.attributes, **row.fixed}
                return Tag(row.tag, attributes, tuple(self._below(match)))
        self._refuse_node(kind, data, path)
        for place, inner in KINDS[kind].written_children(data):
            self.node(inner, (*path, *place))
        return Tag("AlwaysSuccess")

    def _matched(self, row: table.Row, data: Mapping[str, Any], path: base.Path) -> _Match | None:
        """Return how a node fits a row; None if it does not."""
        kind, match = row.kind, _Match()
        others = [key for key in data if key not in row.node and key != "name"]
        is_usual = all(data[key] == table.default_of(kind, key) for key in others)
        return match if is_usual and match.fits_node(row.node, data, path) else None

    def _below(self, match: _Match) -> Iterator[Tag]:
        """Yield the elements below the one of a row."""
        order = sorted(match.below, key=lambda below: getattr(below[0], "index", 0))
        for column, part, path in order:
            match column:
                case table.Children():
                    yield from (self.node(node, (*path, index)) for index, node in enumerate(part))
                case table.Question():
                    yield _question(part)
                case table.Child():
                    absent = Tag(column.absent or "")
                    child = absent if part is None else self.node(part, path)
                    is_other = part is not None and child == absent
                    yield Tag("ScriptCondition", {"code": "true"}) if is_other else child

    def _tree_row(self, use: Mapping[str, Any], outputs: Mapping[str, str]) -> table.Row:
        """Return the row of the use of a named tree."""
        types = self.signatures[use["name"]].types
        inputs = {key: types[key] or "list" for key in use.get("inputs", {})}
        ids = Codec(plain_text, lambda name: tree_id(name, self.signatures))
        return table.tree_row(ids, inputs, outputs)

    def _refuse_name(self, name: str | None, path: base.Path) -> None:
        """Refuse two uses of trees with one name."""
        if name and name in self._names:
            hint = "rename one of them; BehaviorTree.CPP requires unique names"
            what = f"the name {quoted(name)} is used for two subtrees"
            self.refuse((*path, "name"), what, hint)
        self._names.add(name or "")

    def _refuse_node(self, kind: str, data: Mapping[str, Any], path: base.Path) -> None:
        """Refuse a node that fits no row."""
        if kind != "parallel":
            self.refuse((*path, kind), f"'{kind}'", _ONLY_YAML, key=True)
        elif isinstance(data.get("succeed_when"), list):
            self.refuse((*path, "succeed_when"), *_NAMED_CHILDREN)
        else:
            keys = ("succeed_when", "fail_when", "rest")
            settings = [f"'{key}: {data.get(key, table.default_of(kind, key))}'" for key in keys]
            what = f"the combination of {', '.join(settings[:-1])} and {settings[-1]}"
            self.refuse((*path, "rest"), what, _POLICY, key=True)


def _question(condition: Any) -> Tag:
    """Return a condition as an element that asks it."""
    code = CONDITION.write(condition)
    if code is not None:
        return Tag("ScriptCondition", {"code": code})
    return Tag("check", {"condition": VALUE.write(condition) or ""})


def tree_id(name: str, names: Container[str]) -> str:
    """Return the ID of the tree with this name, one of `names`."""
    if _is_free(name):
        return name
    candidates = (f"{name}_tree{number or ''}" for number in itertools.count())
    return next(name for name in candidates if _is_free(name) and name not in names)


def main_id(mission: str, taken: Container[str]) -> str:
    """Return the ID of the main tree: the mission's name where it can be one."""
    own = [mission] if _ID.fullmatch(mission) and _is_free(mission) else []
    others = (f"MainTree{number}" for number in itertools.count(2))
    candidates = itertools.chain(own, ["MainTree"], others)
    return next(name for name in candidates if name not in taken and _is_free(name))


def _is_free(name: str) -> bool:
    return name not in _RESERVED and table.leaf_row(name) is None


# ---- trees -----------------------------------------------------------------------------------


class _MissionWriter:
    """The trees and models of a mission; raises InputError where it has no counterpart in XML."""

    def __init__(self, document: Document, shapes: FindShapes | None) -> None:
        mission = required(read_mission(document))
        self._document = document
        self._mission = mission
        self._shapes = shapes
        self._limits = GoalLimitsTable.written(MissionFile.model_validate(document.data))
        self._diagnostics: list[Diagnostic] = []
        self._signatures = {
            name: Signature(
                name,
                TreeDefinition.model_validate(_data(tree)),
                tree.types,
                tree.document,
                tree.path,
            )
            for name, tree in mission.trees.items()
        }
        self._ids = {name: tree_id(name, mission.trees) for name in mission.trees}
        self._main = main_id(mission.name, {*mission.trees, *self._ids.values()})
        ids = (self._main, *self._ids.values())
        trees = zip(mission.all_trees, ids, strict=True)
        self._bodies = {name: self._tree(tree, name) for tree, name in trees}
        models = [self._main_model(), *map(self._model, mission.trees.values())]
        self._models = tuple(model for model in models if model.children)
        self._refuse_files()
        self._diagnostics += [value.diagnostic("BT-1205") for value in live_values(mission)]
        self.used = used_attributes(self._bodies.values())
        if self._diagnostics:
            raise InputError(in_order(self._diagnostics))

    def text(self) -> str:
        """Return the file."""
        models = (*self._models, *leaf_models(self.used, self._shapes))
        palette = [Tag("TreeNodesModel", {}, models)] if models else []
        root = {"BTCPP_format": table.FORMAT, "main_tree_to_execute": self._main}
        return xml_text(Tag("root", root, (*self._bodies.values(), *palette)))

    def _refuse(self, document: Document, path: base.Path, what: str, hint: str) -> None:
        message = f"{what} has no counterpart in XML"
        self._diagnostics.append(document.diagnostic("BT-1205", path, message, hint, key=True))

    def _tree(self, tree: Tree, name: str) -> Tag:
        document, data = tree.document, _data(tree)
        path, key = ((), "tree") if tree.is_main else (tree.path, "do")
        writer = _NodeWriter(document, self._signatures, self._limits)
        body = writer.node(data[key], (*path, key))
        self._diagnostics += writer.diagnostics
        for follow in tree.follow:
            what = f"the variable '{follow.variable}', which follows a topic,"
            hint = "read the topic with 'wait_for' and its 'outputs', or keep the mission in YAML"
            message = f"{what} has no counterpart in XML"
            self._diagnostics.append(
                document.diagnostic("BT-1205", follow.place.path, message, hint)
            )
        attributes = {"ID": name}
        if text := data.get("description"):
            attributes["_description"] = text
            if is_illegal(text):
                what = "a control character"
                self._refuse(document, (*path, "description"), what, "leave it out")
        return Tag("BehaviorTree", attributes, (body,))

    def _main_model(self) -> Tag:
        data, types = self._document.data, {**self._mission.main.types}
        fields = {
            key: codec.write(data[key]) or ""
            for key, codec in HEAD.items()
            if data.get(key) not in (None, "", [])
        }
        if self._main == data["mission"]:
            del fields["mission"]
        read: dict[str, set[str]] = {}
        for name, label in types_read(self._bodies[self._main], self._bodies, self._shapes):
            read.setdefault(name, set()).add(label)
        # A program sets the inputs of the main tree, with a type that the ports have to have, too.
        for name, word in types.items():
            if word == "integer" and read.get(name) == {LABELS["number"]}:
                types[name] = "number"
        ports = self._inputs(self._document, ("inputs",), data.get("inputs", {}), types)
        metadata = [*([fields] if fields else []), *self._requirements()]
        return Tag(table.SUBTREE, {"ID": self._main}, (*ports, *_metadata(*metadata)))

    def _requirements(self) -> Iterator[dict[str, str]]:
        for requirement in self._mission.requirements:
            if is_illegal(requirement.name):
                path = ("requirements", requirement.name)
                self._refuse(self._document, path, "a control character", "leave it out")
            action = (
                {}
                if requirement.on_violation == "report"
                else {"on_violation": requirement.on_violation}
            )
            yield {table.REQUIREMENT: requirement.name, "formula": requirement.text, **action}

    def _model(self, tree: Tree) -> Tag:
        document, definition = tree.document, self._signatures[tree.name].definition
        ports = [
            self._port("input_port", document, (*tree.path, "needs", key), LABELS[word])
            for key, word in definition.needs.items()
        ]
        ports += self._inputs(document, (*tree.path, "inputs"), definition.inputs, tree.types)
        for key, word in definition.outputs.items():
            path = (*tree.path, "outputs", key)
            ports.append(self._port("output_port", document, path, LABELS[word]))
            if key in tree.types:
                hint = "give the output another name, and 'set' it"
                self._refuse(document, path, f"'{key}' as both input and output", hint)
        tree_id = self._ids[tree.name]
        metadata = () if tree_id == tree.name else _metadata({table.TREE_NAME: tree.name})
        return Tag(table.SUBTREE, {"ID": tree_id}, (*ports, *metadata))

    def _inputs(
        self,
        document: Document,
        path: base.Path,
        values: Mapping[str, Any],
        types: Mapping[str, Any],
    ) -> list[Tag]:
        ports = []
        for name, value in values.items():
            default = constant(types[name]).write(input_value(value))
            place = (*path, name)
            ports.append(
                self._port("input_port", document, place, LABELS[types[name]], default or "")
            )
            if default is None or is_illegal(default):
                self._refuse(document, place, "a control character", "leave it out")
        return ports

    def _port(
        self,
        tag: str,
        document: Document,
        path: base.Path,
        label: str,
        default: str | None = None,
    ) -> Tag:
        """Return the port with the name that ends a path."""
        name = str(path[-1])
        if name in ("name", "ID") or name.startswith("_"):
            what = f"a port with the name '{name}'"
            self._refuse(document, path, what, "give the variable another name")
        given = {} if default is None else {"default": default}
        return Tag(tag, {"name": name, "type": label, **given})

    def _refuse_files(self) -> None:
        """Refuse files of Python that are looked for beside another file than the XML file."""
        here = Path(self._document.file).parent
        for tree in self._mission.trees.values():
            for node in tree.body.walk() if Path(tree.document.file).parent != here else ():
                if isinstance(node, PythonNode) and ".py:" in node.target:
                    hint = "write 'module:Class', or include no file of another folder"
                    path = (*node.path, "python")
                    self._refuse(tree.document, path, "a file beside an included one", hint)


def _metadata(*fields: Mapping[str, str]) -> list[Tag]:
    tags = tuple(Tag("Metadata", attributes) for attributes in fields)
    return [Tag("MetadataFields", {}, tags)] if tags else []


def _data(tree: Tree) -> Any:
    """Return what the file says of a tree."""
    return reduce(operator.getitem, () if tree.is_main else tree.path, tree.document.data)
