"""From a mission to an XML file that Groot 2 shows."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from pathlib import Path
from typing import Any

from bt_mission.btcpp.attributes import is_illegal
from bt_mission.btcpp.document import FORMAT, METADATA
from bt_mission.btcpp.elements import Tag, xml_text
from bt_mission.btcpp.leaves import Path as At
from bt_mission.btcpp.nodes import NodeWriter
from bt_mission.btcpp.palette import leaf_models, palette_xml, types_read
from bt_mission.btcpp.ports import LABELS, REQUIREMENT, written_port_value
from bt_mission.btcpp.tree_ids import TREE_NAME, main_id, tree_id
from bt_mission.btcpp.yaml_text import flow
from bt_mission.core.diagnostics import Diagnostic, InputError, in_order
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.types import FindShapes
from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.follow import Follow
from bt_mission.language.goal_limits import GoalLimitsTable
from bt_mission.language.loader import read_mission, required
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.node_reader import Signature
from bt_mission.language.nodes.fields import input_value
from bt_mission.language.nodes.leaves import PythonNode

_RESERVED = ("name", "ID")


def mission_xml(document: Document, shapes: FindShapes | None = None) -> str:
    """Return a mission file as XML. Raises InputError with everything that XML cannot say.

    `shapes` tells what ROS types hold, so that the ports of every leaf are listed.
    """
    return _written(document, shapes).text()


def mission_palette(document: Document, shapes: FindShapes | None = None) -> str:
    """Return the palette with every attribute in it that a mission uses.

    Raises:
        InputError: With everything that is wrong with the mission, or that XML cannot say.
    """
    writer = _written(document, shapes)
    writer.text()
    return palette_xml(shapes, writer.used)


def _written(document: Document, shapes: FindShapes | None) -> _Writer:
    return _Writer(document, required(read_mission(document)), shapes)


class _Writer:
    def __init__(self, document: Document, mission: Mission, shapes: FindShapes | None) -> None:
        self._document = document
        self._mission = mission
        self._shapes = shapes
        self._limits = GoalLimitsTable.written(MissionFile.model_validate(document.data))
        self.used: dict[str, dict[str, bool]] = {}
        self._faults: list[Diagnostic] = []
        self._signatures = {
            name: Signature(name, _definition(tree), tree.types, tree.document, tree.path)
            for name, tree in mission.trees.items()
        }
        self._ids = {name: tree_id(name, mission.trees) for name in mission.trees}

    def text(self) -> str:
        data = self._document.data
        self._refuse_follow(self._mission.follow, self._document)
        main = main_id(self._mission.name, {*self._mission.trees, *self._ids.values()})
        bodies = [self._tree(self._document, ("tree",), data["tree"], main, data)]
        models = []
        for name, tree in self._mission.trees.items():
            written = _data(tree)
            path = (*tree.path, "do")
            bodies.append(self._tree(tree.document, path, written["do"], self._ids[name], written))
            models.append(self._model(name, tree, self._signatures[name].definition))
            self._refuse_files(tree)
            self._refuse_follow(tree.follow, tree.document)
        by_id = {one.attributes["ID"]: one for one in bodies}
        models.insert(0, self._main_model(main, by_id))
        if self._faults:
            raise InputError(in_order(self._faults))
        models = [model for model in models if model.children]
        models += leaf_models(self.used, self._shapes)
        palette = [Tag("TreeNodesModel", {}, tuple(models))] if models else []
        root = {"BTCPP_format": FORMAT, "main_tree_to_execute": main}
        return xml_text(Tag("root", root, (*bodies, *palette)))

    def _refuse(self, document: Document, path: At, what: str, hint: str) -> None:
        message = f"{what}: XML has no counterpart"
        self._faults.append(document.fault(path, message, hint, key=True))

    def _tree(
        self, document: Document, path: At, node: Any, name: str, written: Mapping[str, Any]
    ) -> Tag:
        writer = NodeWriter(document, self._signatures, self._limits, self.used)
        body = writer.node(node, path)
        self._faults += writer.faults
        attributes = {"ID": name}
        if written.get("description"):
            attributes["_description"] = written["description"]
            if is_illegal(written["description"]):
                what = "a control character"
                self._refuse(document, (*path[:-1], "description"), what, "leave it out")
        return Tag("BehaviorTree", attributes, (body,))

    def _main_model(self, main: str, bodies: Mapping[str, Tag]) -> Tag:
        data = self._document.data
        said = {key: str(data[key]) for key in METADATA if data.get(key) not in (None, "", [])}
        if "nodes" in said:
            said["nodes"] = ", ".join(data["nodes"])
        if "places" in said:
            said["places"] = flow(data["places"])
        if main == data["mission"]:
            del said["mission"]
        types = {**self._mission.main.types}
        read: dict[str, set[str]] = {}
        for name, label in types_read(bodies[main], bodies, self._shapes):
            read.setdefault(name, set()).add(label)
        # A program sets the inputs of the main tree, with a type that the ports have to have, too.
        for name, word in types.items():
            if word == "integer" and read.get(name) == {LABELS["number"]}:
                types[name] = "number"
        ports = self._inputs(self._document, ("inputs",), data.get("inputs", {}), types)
        fields = [*([said] if said else []), *self._requirements()]
        return Tag("SubTree", {"ID": main}, (*ports, *_metadata(*fields)))

    def _requirements(self) -> Iterator[dict[str, str]]:
        for one in self._mission.requirements:
            if is_illegal(one.name):
                path = ("requirements", one.name)
                self._refuse(self._document, path, "a control character", "leave it out")
            said = {REQUIREMENT: one.name, "formula": one.text}
            yield (
                said if one.on_violation == "report" else {**said, "on_violation": one.on_violation}
            )

    def _model(self, name: str, tree: Tree, definition: TreeDefinition) -> Tag:
        document, needs, outputs = tree.document, (*tree.path, "needs"), (*tree.path, "outputs")
        ports = [
            self._port("input_port", document, (*needs, key), {"type": LABELS[word]})
            for key, word in definition.needs.items()
        ]
        ports += self._inputs(document, (*tree.path, "inputs"), definition.inputs, tree.types)
        for key, word in definition.outputs.items():
            path = (*outputs, key)
            ports.append(self._port("output_port", document, path, {"type": LABELS[word]}))
            if key in tree.types:
                hint = "give the output another name, and 'set' it"
                self._refuse(document, path, f"'{key}' as an input and an output", hint)
        said = {} if self._ids[name] == name else {TREE_NAME: name}
        return Tag("SubTree", {"ID": self._ids[name]}, (*ports, *(_metadata(said) if said else ())))

    def _inputs(
        self, document: Document, path: At, values: Mapping[str, Any], types: Mapping[str, Any]
    ) -> list[Tag]:
        ports = []
        for name, value in values.items():
            said = written_port_value(input_value(value), types[name])
            label = {"type": LABELS[types[name]], "default": said or ""}
            ports.append(self._port("input_port", document, (*path, name), label))
            if said is None or is_illegal(said):
                self._refuse(document, (*path, name), "a control character", "leave it out")
        return ports

    def _port(self, tag: str, document: Document, path: At, label: Mapping[str, str]) -> Tag:
        """Return the port with the name that ends a path."""
        name = str(path[-1])
        if name in _RESERVED or name.startswith("_"):
            what = f"a port with the name '{name}'"
            self._refuse(document, path, what, "give the variable another name")
        return Tag(tag, {"name": name, **label})

    def _refuse_follow(self, follow: Iterable[Follow], document: Document) -> None:
        """Refuse variables that follow topics: nothing in a tree of BehaviorTree.CPP does."""
        hint = "read the topic with 'wait_for' and its 'outputs', or keep the mission in YAML"
        for one in follow:
            what = f"the variable '{one.variable}', which follows a topic"
            message = f"{what}: XML has no counterpart"
            self._faults.append(document.fault(one.place.path, message, hint))

    def _refuse_files(self, tree: Tree) -> None:
        """Refuse files of Python that are looked for beside another file than the XML file."""
        here, there = (Path(one.file).parent for one in (self._document, tree.document))
        for step in tree.body.walk():
            if isinstance(step, PythonNode) and ".py:" in step.target and here != there:
                hint = "write 'module:Class', or include no file of another folder"
                path = (*step.path, "python")
                self._refuse(tree.document, path, "a file beside an included one", hint)


def _metadata(*fields: Mapping[str, str]) -> list[Tag]:
    tags = tuple(Tag("Metadata", said) for said in fields)
    return [Tag("MetadataFields", {}, tags)] if tags else []


def _data(tree: Tree) -> Any:
    """Return a tree as its file has it."""
    return reduce(operator.getitem, tree.path, tree.document.data)


def _definition(tree: Tree) -> TreeDefinition:
    return TreeDefinition.model_validate(_data(tree))
