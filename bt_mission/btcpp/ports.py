"""The ports of named trees: declared under `TreeNodesModel`, given where a tree is used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.btcpp import parts
from bt_mission.btcpp.attributes import FaultReport, number, read_list, read_reference
from bt_mission.btcpp.elements import Attribute, Element
from bt_mission.btcpp.leaf_reading import refuse_attribute, variable
from bt_mission.btcpp.parts import At, Entry, LocatedValue
from bt_mission.btcpp.yaml_text import flow
from bt_mission.core.diagnostics import did_you_mean, listed, quoted

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


@dataclass(frozen=True)
class Port:
    """One port: where it is declared, its type in our words, and its default, if it has one."""

    at: At
    type: str
    default: LocatedValue | None = None


@dataclass
class TreePorts:
    """What is declared of a tree; `metadata` are the attributes of its `Metadata` elements."""

    inputs: dict[str, Port] = field(default_factory=dict)
    outputs: dict[str, Port] = field(default_factory=dict)
    metadata: dict[str, Attribute] = field(default_factory=dict)


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
    at = (element.line, element.column)
    if element.tag == "MetadataFields":
        for child in element.children:
            ports.metadata |= child.attributes
        return
    if element.tag not in _PORTS:
        message = f"expected {listed(_PORTS)} or MetadataFields, got <{element.tag}>"
        report(at, message, "a variable is either given to a tree or taken from it")
        return
    for attribute in element.attributes.values():
        if attribute.name not in _AT_PORTS:
            refuse_attribute(attribute, element.tag, _AT_PORTS, report)
    name, label = element.attributes.get("name"), element.attributes.get("type")
    if name is None:
        report(at, "the attribute 'name' is missing")
        return
    word = None if label is None else _word(label.value)
    if word is None:
        shown = "nothing" if label is None else quoted(label.value)
        message = f"expected a type ({listed(LABELS.values())}) of the port {quoted(name.value)}"
        report(at, f"{message}, got {shown}")
        word = "list"
    default = element.attributes.get("default")
    is_input = element.tag == "input_port"
    if default is not None and not is_input:
        report((default.line, default.column), "an output has no default")
    value = None if default is None else port_value(default, word, report)
    kept = ports.inputs if is_input else ports.outputs
    if name.value in ports.inputs or name.value in ports.outputs:
        report(at, f"the port {quoted(name.value)} is declared twice")
    kept[name.value] = Port((name.value_line, name.value_column), word, value)


def _word(label: str) -> str | None:
    if label.startswith("std::vector<"):
        return "list"
    return _TYPES.get(label)


def port_value(attribute: Attribute, word: str, report: FaultReport) -> LocatedValue:
    """Return the constant that an attribute gives for a port of a type, in our words."""
    at, text = (attribute.value_line, attribute.value_column), attribute.value
    found: Any = None
    match word:
        case "text":
            return parts.text(text, attribute)
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
        report(at, f"expected a value of the type {LABELS[word]}, got {quoted(text)}")
        found = 0
    return parts.scalar(found, at)


def written_port_value(value: Any, word: str) -> str | None:
    """Return the value of an attribute that `port_value` takes for this constant, or None."""
    if word == "text":
        return value if isinstance(value, str) else None
    if isinstance(value, str) or (word == "list") != isinstance(value, list):
        return None
    if word == "number":
        return repr(float(value)) if float(value) == value else None
    return flow(value)


def text_constant(text: str) -> str | None:
    """Return the expression for a text, or None where none can be written."""
    return next((f"{mark}{text}{mark}" for mark in "'\"" if mark not in text), None)


def read_use(element: Element, trees: Mapping[str, TreePorts], report: FaultReport) -> LocatedValue:
    """Return a SubTree as the use of a named tree."""
    at = (element.line, element.column)
    for child in element.children:
        report((child.line, child.column), "a SubTree has nothing in it; ID names a tree")
    attributes = dict(element.attributes)
    name = attributes.pop("ID", None)
    if name is None:
        report(at, "the attribute 'ID' is missing")
        return parts.mapping(at, ())
    ports = trees.get(name.value)
    if ports is None:
        message = f"no tree is called {quoted(name.value)} (trees: {listed(trees)})"
        where = (name.value_line, name.value_column)
        report(where, message, did_you_mean(name.value, trees))
        return parts.mapping(at, ())
    use = _Use()
    for attribute in attributes.values():
        use.take(attribute, name.value, ports, report)
    tree = parts.text(name.value, name)
    if use.inputs:
        settings: list[Entry] = [("name", (name.line, name.column), tree)]
        inputs = parts.mapping(at, use.inputs)
        tree = parts.mapping(at, [*settings, ("inputs", use.inputs[0][1], inputs)])
    entries: list[Entry] = [("tree", at, tree), *use.names]
    if use.outputs:
        entries.append(("outputs", use.outputs[0][1], parts.mapping(at, use.outputs)))
    return parts.mapping(at, entries)


@dataclass
class _Use:
    """What the attributes of a SubTree say."""

    names: list[Entry] = field(default_factory=list)
    inputs: list[Entry] = field(default_factory=list)
    outputs: list[Entry] = field(default_factory=list)

    def take(self, attribute: Attribute, tree: str, ports: TreePorts, report: FaultReport) -> None:
        """Take one attribute."""
        name, where = attribute.name, (attribute.line, attribute.column)
        if name == "name":
            self.names.append((name, where, parts.text(attribute.value, attribute)))
        elif name in ports.inputs:
            given = _given(attribute, ports.inputs[name].type, report)
            self.inputs.append((name, where, given))
        elif name in ports.outputs:
            self.outputs.append((name, where, variable(attribute, report)))
        elif name.startswith("_"):
            refuse_attribute(attribute, "SubTree", (), report)
        else:
            known = [*ports.inputs, *ports.outputs]
            message = f"no port {quoted(name)} of {tree} (ports: {listed(known)})"
            hint = did_you_mean(name, known)
            report(where, message, hint or "declare it under TreeNodesModel, with its type")


def _given(attribute: Attribute, word: str, report: FaultReport) -> LocatedValue:
    """Return what a tree is given for an input: a variable, or a constant."""
    reference = read_reference(attribute)
    if reference is not None:
        return reference
    if word != "text":
        return port_value(attribute, word, report)
    at = (attribute.value_line, attribute.value_column)
    constant = text_constant(attribute.value)
    if constant is None:
        report(at, "a text with both kinds of quotes cannot be given to a tree")
    return parts.scalar(constant or "''", at)
