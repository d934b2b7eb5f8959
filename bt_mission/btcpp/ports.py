"""The ports of named trees: declared under `TreeNodesModel`, given where a tree is used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.btcpp.attributes import (
    VARIABLE,
    VARIABLE_NAME,
    Entry,
    FaultReport,
    LocatedValue,
    located,
    mapping,
    number,
    plain_text,
    read_list,
    read_reference,
    refuse_attribute,
)
from bt_mission.btcpp.elements import Attribute, Element, Tag
from bt_mission.btcpp.leaves import Path, Refuse
from bt_mission.btcpp.tree_ids import TREE_NAME, tree_id
from bt_mission.btcpp.yaml_text import flow
from bt_mission.core.diagnostics import did_you_mean, listed, quoted
from bt_mission.core.yaml.composer import At
from bt_mission.language.node_reader import Signature

SUBTREE = "SubTree"

LABELS = {
    "number": "double",
    "integer": "int",
    "bool": "bool",
    "text": "std::string",
    "list": "list",
}
"""Our types, and what Groot 2 shows as theirs."""

_TYPES = {
    **{label: word for word, label in LABELS.items()},
    "float": "number",
    "unsigned": "integer",
    "string": "text",
}
_PORTS = ("input_port", "output_port")
_AT_PORTS = ("name", "type", "default")


REQUIREMENT = "requirement"
"""Of a `Metadata` element: the name of a requirement of the mission."""


@dataclass(frozen=True)
class Port:
    """One port: where it is declared, its type in our words, and its default, if it has one."""

    at: At
    type: str
    default: LocatedValue | None = None


@dataclass
class TreePorts:
    """What is declared of a tree; `metadata` are the attributes of its `Metadata` elements.

    Those with a requirement are kept apart, since each has the same attributes.
    """

    inputs: dict[str, Port] = field(default_factory=dict)
    outputs: dict[str, Port] = field(default_factory=dict)
    metadata: dict[str, Attribute] = field(default_factory=dict)
    requirements: list[Element] = field(default_factory=list)

    def take_metadata(self, fields: Element) -> None:
        """Take in the attributes of `Metadata` elements."""
        for child in fields.children:
            if REQUIREMENT in child.attributes:
                self.requirements.append(child)
            else:
                self.metadata |= child.attributes

    def tree_name(self, tree_id: Attribute) -> Attribute:
        """Return the name of the tree with an ID: that, unless it could not be the ID."""
        return self.metadata.get(TREE_NAME, tree_id)

    def entries(self) -> tuple[list[Entry], list[Entry], list[Entry]]:
        """Return the types of what has to be given, the defaults, and the types of outputs."""
        needs: list[Entry] = []
        inputs: list[Entry] = []
        for name, port in self.inputs.items():
            if port.default is None:
                needs.append((name, port.at, located(port.type, port.at)))
            else:
                inputs.append((name, port.at, port.default))
        outputs = [
            (name, port.at, located(port.type, port.at)) for name, port in self.outputs.items()
        ]
        return needs, inputs, outputs


def read_models(models: Element, report: FaultReport) -> dict[str, TreePorts]:
    """Return what is declared of trees, by their ID; models of other nodes say nothing new."""
    found: dict[str, TreePorts] = {}
    for element in models.children:
        name = element.attributes.get("ID")
        if element.tag != "SubTree" or name is None:
            continue
        ports = found.setdefault(name.value, TreePorts())
        for child in element.children:
            _declare(ports, child, report)
    return found


def _declare(ports: TreePorts, element: Element, report: FaultReport) -> None:
    if element.tag == "MetadataFields":
        ports.take_metadata(element)
        return
    if element.tag not in _PORTS:
        message = f"expected {listed(_PORTS)} or MetadataFields, got <{element.tag}>"
        report(element.at, message, "a variable is either given to a tree or taken from it")
        return
    for attribute in element.attributes.values():
        if attribute.name not in _AT_PORTS:
            refuse_attribute(attribute, element.tag, _AT_PORTS, report)
    name, label = element.attributes.get("name"), element.attributes.get("type")
    if name is None:
        report(element.at, "the attribute 'name' is missing")
        return
    word = "text" if label is None else _word(label.value)
    if word is None:
        assert label is not None, "a port without a type is a string"
        message = f"expected a type ({listed(LABELS.values())}) of the port {quoted(name.value)}"
        report(element.at, f"{message}, got {quoted(label.value)}")
        word = "list"
    default = element.attributes.get("default")
    is_input = element.tag == "input_port"
    if default is not None and not is_input:
        report(default.at, "an output has no default")
    value = None if default is None else port_value(default, word, report)
    kept = ports.inputs if is_input else ports.outputs
    if name.value in ports.inputs or name.value in ports.outputs:
        report(element.at, f"the port {quoted(name.value)} is declared twice")
    kept[name.value] = Port(name.value_at, word, value)


def _word(label: str) -> str | None:
    if label.startswith("std::vector<"):
        return "list"
    return _TYPES.get(label)


def port_value(attribute: Attribute, word: str, report: FaultReport) -> LocatedValue:
    """Return the constant that an attribute gives for a port of a type, in our words."""
    text = attribute.value
    found: Any = None
    match word:
        case "text":
            return plain_text(attribute)
        case "list" if text.startswith("["):
            return read_list(attribute, report)
        case "bool":
            found = {"true": True, "false": False}.get(text)
        case "number" | "integer":
            found = number(text)
            if word == "integer" and isinstance(found, float):
                found = None
            elif word == "number" and found is not None:
                found = float(found)
    if found is None:
        message = f"expected a value of the type {LABELS[word]}, got {quoted(text)}"
        report(attribute.value_at, message)
        found = 0
    return located(found, attribute.value_at)


def written_port_value(value: Any, word: str) -> str | None:
    """Return the value of an attribute that `port_value` takes for this constant, or None."""
    if word == "text":
        return value if isinstance(value, str) else None
    if isinstance(value, str) or (word == "list") != isinstance(value, list):
        return None
    if word == "number":
        return repr(float(value)) if float(value) == value else None
    return flow(value)


def _text_constant(text: str) -> str | None:
    """Return the expression for a text, or None where none can be written."""
    return next((f"{mark}{text}{mark}" for mark in "'\"" if mark not in text), None)


def read_use(element: Element, trees: Mapping[str, TreePorts], report: FaultReport) -> LocatedValue:
    """Return a SubTree as the use of a named tree."""
    at = element.at
    for child in element.children:
        report(child.at, "a SubTree has nothing in it; ID names a tree")
    attributes = dict(element.attributes)
    name = attributes.pop("ID", None)
    if name is None:
        report(at, "the attribute 'ID' is missing")
        return located({}, at)
    ports = trees.get(name.value)
    if ports is None:
        message = f"no tree is called {quoted(name.value)} (trees: {listed(trees)})"
        report(name.value_at, message, did_you_mean(name.value, trees))
        return located({}, at)
    remaps = _is_remapped(attributes.pop("_autoremap", None), report)
    use: dict[str, list[Entry]] = {"name": [], "inputs": [], "outputs": []}
    for attribute in attributes.values():
        found = _port_use(attribute, name.value, ports, report)
        if found is not None:
            use[found[0]].append((attribute.name, attribute.at, found[1]))
    if remaps:
        given = {key for entries in use.values() for key, _, _ in entries}
        taken = (one for one in ports.inputs if one not in given)
        use["inputs"] += [(one, at, located(f"${one}", at)) for one in taken]
        use["outputs"] += [(one, at, located(one, at)) for one in ports.outputs if one not in given]
    tree = LocatedValue(ports.tree_name(name).value, plain_text(name).place)
    inputs, outputs = use["inputs"], use["outputs"]
    if inputs:
        inner = ("inputs", inputs[0][1], mapping(at, inputs))
        tree = mapping(at, [("name", name.at, tree), inner])
    entries = [("tree", at, tree), *use["name"]]
    if outputs:
        entries.append(("outputs", outputs[0][1], mapping(at, outputs)))
    return mapping(at, entries)


def _is_remapped(attribute: Attribute | None, report: FaultReport) -> bool:
    """Return whether the ports of a SubTree that are not given have the variable of their name."""
    if attribute is None or attribute.value.lower() in ("false", "0"):
        return False
    if attribute.value.lower() not in ("true", "1"):
        report(attribute.value_at, f"expected true or false, got {quoted(attribute.value)}")
    return True


def _port_use(
    attribute: Attribute, tree: str, ports: TreePorts, report: FaultReport
) -> tuple[str, LocatedValue] | None:
    """Return what an attribute of a SubTree gives, and the key under which that stands."""
    name = attribute.name
    if name == "name":
        return "name", plain_text(attribute)
    if name in ports.inputs:
        return "inputs", _given(attribute, ports.inputs[name].type, report)
    if name in ports.outputs:
        return "outputs", VARIABLE.read(attribute, report)
    if name.startswith("_"):
        refuse_attribute(attribute, SUBTREE, (), report)
        return None
    known = [*ports.inputs, *ports.outputs]
    message = f"no port {quoted(name)} of {tree} (ports: {listed(known)})"
    hint = did_you_mean(name, known)
    report(attribute.at, message, hint or "declare it under TreeNodesModel, with its type")
    return None


def write_use(
    data: dict[str, Any], path: Path, trees: Mapping[str, Signature], refuse: Refuse
) -> Tag:
    """Return the use of a named tree as a SubTree."""
    use = data["tree"] if isinstance(data["tree"], dict) else {"name": data["tree"]}
    attributes = {"ID": tree_id(use["name"], trees)}
    types = trees[use["name"]].types
    for name, value in use.get("inputs", {}).items():
        said = _written_given(value, types[name] or "list")
        if said is None:
            hint = "'set' a variable to it first, and give that"
            refuse((*path, "tree", "inputs", name), f"what '{name}' is given", hint)
        attributes[name] = said or ""
    for name, variable in data.get("outputs", {}).items():
        attributes[name] = VARIABLE.write(variable)
    return Tag(SUBTREE, attributes)


def _given(attribute: Attribute, word: str, report: FaultReport) -> LocatedValue:
    """Return what a tree is given for an input: a variable, or a constant."""
    reference = read_reference(attribute)
    if reference is not None:
        return reference
    if word != "text":
        return port_value(attribute, word, report)
    constant = _text_constant(attribute.value)
    if constant is None:
        report(attribute.value_at, "a text with both kinds of quotes cannot be given to a tree")
    return located(constant or "''", attribute.value_at)


def _written_given(value: Any, word: str) -> str | None:
    """Return the value of an attribute that `_given` takes for this, or None."""
    if not isinstance(value, str):
        return written_port_value(value, word)
    variable = VARIABLE_NAME.fullmatch(value)
    if variable and value not in ("true", "false", "pi"):
        return VARIABLE.write(variable[1])
    inner = value[1:-1]
    is_plain = inner and not (inner[0] == "{" and inner[-1] == "}")
    return inner if word == "text" and is_plain and _text_constant(inner) == value else None
