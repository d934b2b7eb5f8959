"""From a mission to an XML file that Groot 2 shows."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from functools import reduce
from pathlib import Path
from typing import Any

from bt_mission.btcpp.attributes import LABELS, constant, is_illegal
from bt_mission.btcpp.document import HEAD
from bt_mission.btcpp.elements import Tag, xml_text
from bt_mission.btcpp.node_writer import NodeWriter, main_id, tree_id
from bt_mission.btcpp.palette import leaf_models, palette_xml, types_read, used_attributes
from bt_mission.btcpp.table import FORMAT, REQUIREMENT, SUBTREE, TREE_NAME
from bt_mission.core.diagnostics import Diagnostic, InputError, in_order
from bt_mission.core.yaml.document import Document
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.goal_limits import GoalLimitsTable
from bt_mission.language.loader import read_mission, required
from bt_mission.language.message_types import FindShapes
from bt_mission.language.mission import Tree
from bt_mission.language.node_reader import Signature
from bt_mission.language.nodes import base
from bt_mission.language.nodes.fields import input_value
from bt_mission.language.nodes.leaves import PythonNode


def mission_xml(document: Document, shapes: FindShapes | None = None) -> str:
    """Return a mission file as XML. Raises InputError with everything that XML cannot express.

    `shapes` tells what ROS types hold, so that the ports of every leaf are listed.
    """
    return _MissionWriter(document, shapes).text()


def mission_palette(document: Document, shapes: FindShapes | None = None) -> str:
    """Return the palette with every attribute in it that a mission uses.

    Raises:
        InputError: With everything that is wrong with the mission, or that XML cannot express.
    """
    return palette_xml(shapes, _MissionWriter(document, shapes).used)


class _MissionWriter:
    """The trees and models of a mission; raises InputError where it has no counterpart in XML."""

    def __init__(self, document: Document, shapes: FindShapes | None) -> None:
        mission = required(read_mission(document))
        self._document = document
        self._mission = mission
        self._shapes = shapes
        self._limits = GoalLimitsTable.written(MissionFile.model_validate(document.data))
        self._faults: list[Diagnostic] = []
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
        self.used = used_attributes(self._bodies.values())
        if self._faults:
            raise InputError(in_order(self._faults))

    def text(self) -> str:
        """Return the file."""
        models = (*self._models, *leaf_models(self.used, self._shapes))
        palette = [Tag("TreeNodesModel", {}, models)] if models else []
        root = {"BTCPP_format": FORMAT, "main_tree_to_execute": self._main}
        return xml_text(Tag("root", root, (*self._bodies.values(), *palette)))

    def _refuse(self, document: Document, path: base.Path, what: str, hint: str) -> None:
        message = f"{what}: XML has no counterpart"
        self._faults.append(document.fault(path, message, hint, key=True))

    def _tree(self, tree: Tree, name: str) -> Tag:
        document, data = tree.document, _data(tree)
        path, key = ((), "tree") if tree.is_main else (tree.path, "do")
        writer = NodeWriter(document, self._signatures, self._limits)
        body = writer.node(data[key], (*path, key))
        self._faults += writer.faults
        for one in tree.follow:
            what = f"the variable '{one.variable}', which follows a topic"
            hint = "read the topic with 'wait_for' and its 'outputs', or keep the mission in YAML"
            message = f"{what}: XML has no counterpart"
            self._faults.append(document.fault(one.place.path, message, hint))
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
        return Tag(SUBTREE, {"ID": self._main}, (*ports, *_metadata(*metadata)))

    def _requirements(self) -> Iterator[dict[str, str]]:
        for one in self._mission.requirements:
            if is_illegal(one.name):
                path = ("requirements", one.name)
                self._refuse(self._document, path, "a control character", "leave it out")
            action = {} if one.on_violation == "report" else {"on_violation": one.on_violation}
            yield {REQUIREMENT: one.name, "formula": one.text, **action}

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
                self._refuse(document, path, f"'{key}' as an input and an output", hint)
        tree_id = self._ids[tree.name]
        metadata = () if tree_id == tree.name else _metadata({TREE_NAME: tree.name})
        return Tag(SUBTREE, {"ID": tree_id}, (*ports, *metadata))

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
    tags = tuple(Tag("Metadata", one) for one in fields)
    return [Tag("MetadataFields", {}, tags)] if tags else []


def _data(tree: Tree) -> Any:
    """Return what the file says of a tree."""
    return reduce(operator.getitem, () if tree.is_main else tree.path, tree.document.data)
