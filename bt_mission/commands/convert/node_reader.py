"""From the elements of a tree to nodes: the columns of a row are filled from an element."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.text import counted
from bt_mission.base.yaml.composer import At
from bt_mission.commands.convert import table
from bt_mission.commands.convert.attributes import (
    HARMLESS,
    LABELS,
    Codec,
    Entry,
    LocatedValue,
    Reporter,
    constant,
    located,
    mapping,
    number,
    plain_text,
)
from bt_mission.commands.convert.elements import Attribute, Element
from bt_mission.commands.convert.scripts import CONDITION
from bt_mission.language.nodes.fields import VARIABLE

_SKIP = "_skipIf"
STAND_IN = (
    "replace your own node by an <action> leaf if it has an action server, or by a <python> leaf "
    "(bt-mission docs groot)"
)


_TYPES = {
    **{label: word for word, label in LABELS.items()},
    "float": "number",
    "unsigned": "integer",
    "string": "text",
}


@dataclass
class TreePorts:
    """What is declared of a tree under `TreeNodesModel`.

    Attributes:
        inputs: The types of its inputs, in our words.
        sections: The types of inputs without a default, the defaults, and the types of outputs.
        metadata: The attributes of its `Metadata` elements, but those with a requirement.
        requirements: The elements with those.
    """

    inputs: dict[str, str] = field(default_factory=dict)
    sections: dict[str, dict[str, Entry]] = field(
        default_factory=lambda: {"needs": {}, "inputs": {}, "outputs": {}}
    )
    metadata: dict[str, Attribute] = field(default_factory=dict)
    requirements: list[Element] = field(default_factory=list)

    @property
    def outputs(self) -> Mapping[str, Entry]:
        """The outputs of the tree."""
        return self.sections["outputs"]

    def tree_name(self, tree_id: Attribute) -> Attribute:
        """Return the name of the tree with an ID: that, unless it could not be the ID."""
        return self.metadata.get(table.TREE_NAME, tree_id)

    def located_name(self, tree_id: Attribute) -> LocatedValue:
        """Return the name of the tree, at the place of an ID."""
        return LocatedValue(self.tree_name(tree_id).value, plain_text(tree_id).place)

    def declare(self, element: Element, reporter: Reporter) -> None:
        """Take in an element of the model of the tree."""
        attributes, report = element.attributes, reporter.report
        if element.tag == "MetadataFields":
            for child in element.children:
                if table.REQUIREMENT in child.attributes:
                    self.requirements.append(child)
                else:
                    self.metadata |= child.attributes
        elif element.tag in ("input_port", "output_port"):
            reporter.refuse(attributes.values(), element.tag, ("name", "type", "default"))
            name = reporter.take(dict(attributes), "name", element.at)
            if name is not None:
                self._declare_port(element, name, reporter)
        else:
            message = f"expected input_port, output_port or MetadataFields, got <{element.tag}>"
            hint = "a port of a tree is either an input or an output"
            if element.tag == "inout_port" and "name" in attributes:
                name = attributes["name"]
                hint = f"write <input_port> if the tree only reads {quoted(name.value)}, "
                hint += "<output_port> if it writes it; a tree that does both needs two ports"
                at = name.value_at
                self.inputs[name.value] = "list"  # so that its uses are not refused as well
                self.sections["needs"][name.value] = (name.value, at, located("list", at))
            report("BT-1202", element.at, message, hint)

    def _declare_port(self, element: Element, name: Attribute, reporter: Reporter) -> None:
        attributes, report = element.attributes, reporter.report
        label = attributes["type"].value if "type" in attributes else LABELS["text"]
        word = "list" if label.startswith("std::vector<") else _TYPES.get(label)
        if word is None:
            expected = f"expected a type ({listed(LABELS.values())}) of the port"
            report("BT-1203", element.at, f"{expected} {quoted(name.value)}, got {quoted(label)}")
            word = "list"
        value, section = located(word, name.value_at), "needs"
        if default := attributes.get("default"):
            value, section = reporter.value(default, constant(word)), "inputs"
        if element.tag == "output_port":
            section = "outputs"
            if default:
                report("BT-1210", default.at, "an output cannot have a default")
        else:
            self.inputs[name.value] = word
        if any(name.value in section for section in self.sections.values()):
            report("BT-1210", element.at, f"the port {quoted(name.value)} is declared twice")
        self.sections[section][name.value] = (name.value, name.value_at, value)


@dataclass
class XmlNodeReader(Reporter):
    """Reads elements as nodes.

    Attributes:
        trees: Those that may be used, by their IDs.
        remapped: The attributes that share all variables of a tree, with the ID of the tree.
        main: The ID of the main tree.
    """

    trees: Mapping[str, TreePorts] = field(default_factory=dict)
    remapped: list[tuple[Attribute, str]] = field(default_factory=list)
    main: str = ""

    def node(self, element: Element) -> LocatedValue:
        """Return an element and all below it as a node."""
        if element.text:
            self.report(
                "BT-1209",
                element.text_at,
                f"text in <{element.tag}>: {quoted(element.text)}",
            )
        if element.tag in ("Action", "Condition", "Control", "Decorator"):
            rest = dict(element.attributes)
            name = rest.pop("ID", None)
            if name is None:
                message = f"<{element.tag}>: the attribute 'ID' is missing"
                self.report("BT-1207", element.at, message)
                return located({}, element.at)
            element = replace(element, tag=name.value, at=name.value_at, attributes=rest)
        element = replace(element, attributes=_meant(element.attributes))
        if element.tag == table.SUBTREE:
            return self._use(element)
        if rows := table.rows_of(element.tag):
            return _Filling(element, self).node(rows)
        others = table.OTHERS_WITHOUT_COUNTERPART
        hint = table.WITHOUT_COUNTERPART.get(element.tag) or others.get(element.tag)
        if hint is None:
            near = did_you_mean(element.tag, [*table.ELEMENTS, table.SUBTREE, *table.leaf_kinds()])
            hint = f"{near} {STAND_IN}" if near else STAND_IN
        self.report(
            "BT-1204", element.at, f"the node {quoted(element.tag)} has no counterpart", hint
        )
        for child in element.children:
            self.node(child)
        return located({}, element.at)

    def _use(self, element: Element) -> LocatedValue:
        """Return the use of a named tree."""
        at = element.at
        for child in element.children:
            self.report("BT-1208", child.at, "a SubTree has no children; its ID names a tree")
        attributes = dict(element.attributes)
        tree_id = attributes.get("ID")
        if tree_id is None:
            self.report("BT-1207", at, "the attribute 'ID' is missing")
            return located({}, at)
        ports = self.trees.get(tree_id.value)
        if tree_id.value == self.main:
            message = f"a tree cannot use the main tree {quoted(self.main)}"
            hint = "recursion is not supported; write a Repeat around the body of the tree"
            self.report("BT-211", tree_id.value_at, message, hint)
            return located({}, at)
        if ports is None:
            message = f"unknown tree {quoted(tree_id.value)} (trees: {listed(self.trees)})"
            self.report(
                "BT-210", tree_id.value_at, message, did_you_mean(tree_id.value, self.trees)
            )
            return located({}, at)
        known = [*ports.inputs, *ports.outputs]
        for key in [key for key in attributes if key not in (*known, "ID", "name")]:
            if not key.startswith("_"):
                message = f"no port {quoted(key)} of {tree_id.value} (ports: {listed(known)})"
                hint = did_you_mean(key, known) or "declare it under TreeNodesModel, with its type"
                self.report("BT-212", attributes.pop(key).at, message, hint)
        remapping = attributes.pop("_autoremap", None)
        if remapping is not None and self._is_remapped(remapping):
            self.remapped.append((remapping, tree_id.value))
            given = {key: Attribute(key, f"{{{key}}}", at, at) for key in known}
            attributes = {
                **attributes,
                **{key: given[key] for key in known if key not in attributes},
            }
        row = table.tree_row(Codec(ports.located_name, str), ports.inputs, ports.outputs)
        use = replace(element, attributes=attributes, children=[])
        node = _Filling(use, self).node((row,))
        tree = node.data["tree"]
        if "inputs" not in tree:
            assert isinstance(node.place.parts, dict)
            node.data["tree"], node.place.parts["tree"] = tree["name"], plain_text(tree_id).place
        return node

    def _is_remapped(self, attribute: Attribute) -> bool:
        """Return whether ports that are not given have the variables of their names."""
        if attribute.value.lower() in ("false", "0"):
            return False
        if attribute.value.lower() not in ("true", "1"):
            got = quoted(attribute.value)
            self.report("BT-1203", attribute.value_at, f"expected true or false, got {got}")
        return True


class _Filling:
    """The columns of a row, filled from one element."""

    def __init__(self, element: Element, reader: XmlNodeReader) -> None:
        self._element = element
        self._at = element.at
        self._reader = reader
        self._attributes = dict(element.attributes)
        """Those that are still to be read."""
        self._order = {name: index for index, name in enumerate(element.attributes)}

    def node(self, rows: tuple[table.Row, ...]) -> LocatedValue:
        """Return the node of the row that the element fits."""
        tag, children = self._element.tag, self._element.children
        fixed = {name: self._chosen(name, rows) for name in rows[0].fixed}
        fitting = [row for row in rows if row.fixed == fixed] or rows
        row = next((fit for fit in fitting if fit.children == len(children)), fitting[0])
        node = self._mapping({**row.node, "name": table.NAME}, row.kind)
        if row.is_leaf:
            for child in children:
                self._reader.report("BT-1208", child.at, f"<{tag}> is a leaf and has no children")
        elif row.children is not None and len(children) != row.children:
            nodes = counted(row.children, "node")
            self._reader.report(
                "BT-1208", self._at, f"expected {nodes} in <{tag}>, got {len(children)}"
            )
        self._reader.refuse(self._attributes.values(), tag, row.takes)
        return node

    def _chosen(self, name: str, rows: tuple[table.Row, ...]) -> str:
        """Return the value of an attribute that rows have fixed values of."""
        choice = table.CHOICES[name]
        attribute = self._attributes.pop(name, None)
        if attribute is None:
            return choice.default
        value, count = attribute.value, number(attribute.value)
        if count == len(self._element.children) > 1:
            value = "-1"
        elif count in (1, -1):
            value = str(int(count))
        elif value.lower() in ("false", "0"):
            value = "false"
        if not any(row.fixed[name] == value for row in rows):
            message = choice.message.format(quoted(attribute.value))
            self._reader.report("BT-1204", attribute.value_at, message, choice.hint)
        return value

    def _mapping(self, template: Mapping[str, Any], kind: str | None = None) -> LocatedValue:
        """Return a mapping: the kind first, then attributes in their order, then all else."""
        order: list[tuple[int, Entry]] = []
        for key, part in template.items():
            attributes = self._taken(part)
            value = self._filled(part, attributes)
            if key == kind:
                order.append((-1, (key, self._at, value or mapping(self._at, ()))))
            elif value is not None:
                at = attributes[0].at if attributes else self._at
                is_port = attributes and isinstance(part, table.Port)
                rank = self._order[attributes[0].name] if is_port else len(self._order)
                order.append((rank, (key, at, value)))
        return mapping(
            self._at, (entry for _, entry in sorted(order, key=lambda ranked: ranked[0]))
        )

    def _taken(self, part: Any) -> list[Attribute]:
        """Take the attributes of a column."""
        names: list[str] = []
        if isinstance(part, table.Port):
            names = [part.name] if part.name in self._attributes else []
        elif isinstance(part, table.Ports):
            names = [name for name in self._attributes if part.path(name)]
        return [self._attributes.pop(name) for name in names]

    def _filled(self, part: Any, attributes: list[Attribute]) -> LocatedValue | None:
        """Return a part of the node; None where there is nothing for it."""
        match part:
            case table.Port():
                return self._port(part, attributes)
            case table.Ports():
                return self._entries(part, attributes) if attributes else None
            case table.Blackboard():
                return self._variable(part)
            case table.Never():
                return None
            case dict():
                inner = self._mapping(part)
                return inner if inner.data else None
            case list():
                return located([self._filled(inner, []) for inner in part], self._at)
        return self._below(part) if isinstance(part, table.Below) else located(part, self._at)

    def _below(self, column: table.Below) -> LocatedValue | None:
        match column:
            case table.Question():
                return self._condition(column)
            case table.Children():
                return self._children(column)
            case table.AllButLast():
                return self._all_but_last()
        child = self._child(column.index)
        is_absent = replace(child, at=self._at) == Element(column.absent or "", self._at)
        return None if is_absent else self._reader.node(child)

    def _port(self, port: table.Port, attributes: list[Attribute]) -> LocatedValue | None:
        if attributes:
            return self._reader.value(attributes[0], port.codec)
        if not port.is_needed:
            return None
        self._reader.report("BT-1207", self._at, f"the attribute '{port.name}' is missing")
        return located("", self._at)

    def _entries(self, ports: table.Ports, attributes: list[Attribute]) -> LocatedValue:
        """Return a mapping whose entries are attributes, nested as their names say."""
        entries = [
            (ports.path(item.name) or (), item.at, self._reader.value(item, ports.codec))
            for item in attributes
        ]
        whole: set[table.Names] = set()
        above: set[table.Names] = set()
        for path, at, _ in entries:
            around = {path[:count] for count in range(1, len(path))}
            if path in whole or path in above or not whole.isdisjoint(around):
                self._reader.report(
                    "BT-1210", at, f"the field {quoted('.'.join(path))} is set twice"
                )
            whole.add(path)
            above |= around
        return _nested(entries, self._at)

    def _child(self, index: int) -> Element:
        """Return an element below; a missing one is made up."""
        try:
            return self._element.children[index]
        except IndexError:
            return Element("AlwaysSuccess", self._at)

    def _condition(self, question: table.Question) -> LocatedValue:
        element = self._child(question.index)
        node = self._reader.node(element)
        if list(node.data) != ["check"]:
            message = "expected a ScriptCondition without a name"
            hint = "only a condition on variables can select a node"
            self._reader.report("BT-1204", element.at, message, hint)
            return located(True, self._at)
        assert isinstance(node.place.parts, dict)
        data = node.data["check"]
        return LocatedValue(
            _negated(data) if question.is_negated else data, node.place.parts["check"]
        )

    def _children(self, column: table.Children) -> LocatedValue:
        children = self._element.children
        if not children:
            self._reader.report("BT-1208", self._at, f"<{self._element.tag}> has no children")
        # Where all children are skipped, so is their parent, which has no counterpart.
        skips = column.skips and any(_SKIP not in child.attributes for child in children)
        nodes = [
            self._unless_skipped(child, column.skips)
            if skips and _SKIP in child.attributes
            else self._reader.node(child)
            for child in children
        ]
        return located(nodes, self._at)

    def _unless_skipped(self, child: Element, kind: str | None) -> LocatedValue:
        """Return a child that is left out where the condition of its `_skipIf` holds."""
        rest = dict(child.attributes)
        code = self._reader.value(rest.pop(_SKIP), CONDITION)
        asked = LocatedValue(_negated(code.data), code.place)
        inner = self._reader.node(replace(child, attributes=rest))
        at = child.at
        if kind == "sequence":
            return mapping(at, [("when", at, asked), ("do", at, inner)])
        steps = located([mapping(at, [("check", at, asked)]), inner], at)
        return mapping(at, [("sequence", at, steps)])

    def _all_but_last(self) -> LocatedValue:
        children = self._element.children
        if len(children) < 2:
            message = f"expected 2 nodes or more in <{self._element.tag}>, got {len(children)}"
            self._reader.report("BT-1208", self._at, message)
        nodes = [self._reader.node(child) for child in children[:-1]]
        if len(nodes) == 1:
            return nodes[0]
        return mapping(self._at, [("sequence", self._at, located(nodes, self._at))])

    def _variable(self, column: table.Blackboard) -> LocatedValue:
        """Return a mapping with one variable; a text is a constant."""
        key = self._reader.take(self._attributes, column.key.name, self._at)
        values = self._taken(column.value)
        value = self._port(column.value, values) or located(0, self._at)
        if key is None:
            return located({}, self._at)
        if VARIABLE.fullmatch(key.value) is None:
            message = f"expected the name of a variable, got {quoted(key.value)}"
            self._reader.report("BT-1203", key.value_at, message)
        if isinstance(value.data, str) and not value.data.startswith("$"):
            value = located(repr(value.data), (value.place.line, value.place.column))
        return mapping(key.value_at, [(key.value, key.value_at, value)])


def _meant(attributes: Mapping[str, Attribute]) -> dict[str, Attribute]:
    """Return the attributes of a node that mean something; `{=}` is the variable of its port."""
    return {
        name: replace(attribute, value=f"{{{name}}}") if attribute.value == "{=}" else attribute
        for name, attribute in attributes.items()
        if name not in HARMLESS and (name != "name" or attribute.value)
    }


def _nested(entries: list[tuple[table.Names, At, LocatedValue]], at: At) -> LocatedValue:
    """Return a mapping of values, each with its path and its place."""
    below: dict[str, list[tuple[table.Names, At, LocatedValue]]] = {}
    for path, place, value in entries:
        below.setdefault(path[0], []).append((path[1:], place, value))
    return mapping(
        at,
        (
            (name, group[0][1], _nested(group, group[0][1]) if group[0][0] else group[0][2])
            for name, group in below.items()
        ),
    )


def _negated(condition: Any) -> bool | str:
    """Return the opposite of a condition."""
    return not condition if isinstance(condition, bool) else f"not ({condition})"
