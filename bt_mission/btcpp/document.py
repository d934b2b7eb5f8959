"""A whole XML file as the document that a YAML file would be, with its places."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from bt_mission.btcpp.attributes import (
    Entry,
    LocatedValue,
    entry,
    located,
    mapping,
    number,
    plain_text,
    refuse_attribute,
)
from bt_mission.btcpp.elements import Attribute, Element, XmlSource, parse
from bt_mission.btcpp.nodes import XmlNodeReader
from bt_mission.btcpp.ports import REQUIREMENT, SUBTREE, TreePorts, read_models
from bt_mission.btcpp.tree_ids import TREE_NAME
from bt_mission.btcpp.yaml_text import yaml_text
from bt_mission.core.diagnostics import InputError, did_you_mean, in_order, listed, quoted
from bt_mission.core.yaml.composer import MAX_DEPTH, MAX_VALUES, Place
from bt_mission.core.yaml.document import Document, read_source, read_text
from bt_mission.language.loader import draft

FORMAT = "4"
AT_REQUIREMENT = (REQUIREMENT, "formula", "on_violation")
METADATA = ("mission", "world", "robot", "seed", "map", "observe", "nodes", "places")
"""What the head of a mission says in `Metadata` of its tree."""

_AT_ROOT = ("BTCPP_format", "main_tree_to_execute")
_INCLUDES = frozenset(("include", "import"))


def read_xml(path: str | Path) -> Document:
    """Read an XML file. Raises InputError with everything that has no counterpart."""
    return document_of(read_source(path), str(path))


def document_of(text: str, file: str = "<text>") -> Document:
    """Read XML from a text. Raises InputError with everything that has no counterpart."""
    source = parse(text, file)
    reader = _FileReader(source)
    part = reader.mission()
    if not reader.nodes.faults and part is not None:
        reader.refuse_size(part.place)
    if reader.nodes.faults or part is None:
        raise InputError(in_order(reader.nodes.faults))
    return Document(file, part.data, part.place, source.lines)


def mission_yaml(path: str | Path) -> str:
    """Return an XML file as a YAML file. Raises InputError with everything that is wrong with it.

    What is read is a mission without faults; whether its goals fit the types of ROS is for `check`.
    """
    document = read_xml(path)
    found = draft(document)
    if found.faults:
        raise InputError(found.faults)
    return yaml_text(document.data)


class _FileReader:
    def __init__(self, source: XmlSource) -> None:
        self._source = source
        self._trees: dict[str, Element] = {}
        self._ports: dict[str, TreePorts] = {}
        self._names: set[str] = set()
        self.nodes = XmlNodeReader(source)
        self.report = self.nodes.report

    def mission(self) -> LocatedValue | None:
        """Return the whole mission."""
        root = self._source.root
        if root.tag != "root":
            self.report(root.at, f'expected <root BTCPP_format="4">, got <{root.tag}>')
            return None
        self._look_at(root)
        for child in root.children:
            self._take(child)
        for name in self._trees:
            self._ports.setdefault(name, TreePorts())
        self.nodes.trees = {name: self._ports[name] for name in self._trees}
        main = self._main(root)
        if main is None:
            return None
        head = self._head(main, self._ports[main])
        trees = [
            (self._tree_name(element), element.at, self._definition(element, self._ports[name]))
            for name, element in self._trees.items()
            if name != main
        ]
        if trees:
            head.append(("trees", root.at, mapping(root.at, trees)))
        element = self._trees[main]
        head.append(("tree", element.at, self._body(element)))
        return mapping(root.at, head)

    def _look_at(self, root: Element) -> None:
        for attribute in root.attributes.values():
            if attribute.name not in _AT_ROOT:
                refuse_attribute(attribute, "root", _AT_ROOT, self.report)
        found = root.attributes.get("BTCPP_format")
        if found is None:
            message = f"the attribute 'BTCPP_format' is missing; format {FORMAT} is read"
            self.report(root.at, message, f'write <root BTCPP_format="{FORMAT}">')
        elif found.value != FORMAT:
            message = f"expected format {FORMAT}, got {quoted(found.value)}"
            self.report(found.value_at, message)
        if root.text:
            self.report(root.text_at, f"a loose text: {quoted(root.text)}")

    def _take(self, child: Element) -> None:
        if child.tag == "TreeNodesModel":
            self._ports |= read_models(child, self.report)
        elif child.tag.lower() in _INCLUDES:
            message = "other files are not taken in"
            self.report(child.at, message, "put their <BehaviorTree> elements into this file")
        elif child.tag != "BehaviorTree":
            self.report(child.at, f"expected BehaviorTree or TreeNodesModel, got <{child.tag}>")
        else:
            name = self._identified(child)
            if name.value in self._trees:
                message = f"there is a tree {quoted(name.value)} already"
                self.report(name.value_at, message)
            self._trees[name.value] = child

    def _identified(self, tree: Element) -> Attribute:
        """Return the ID of a tree; the only one needs none, and is called as the file is."""
        if "ID" not in tree.attributes:
            if sum(child.tag == tree.tag for child in self._source.root.children) > 1:
                self.report(tree.at, "the attribute 'ID' is missing")
            name = Path(self._source.file).stem
            tree.attributes["ID"] = Attribute("ID", name, tree.at, tree.at)
        return tree.attributes["ID"]

    def _main(self, root: Element) -> str | None:
        """Return the ID of the main tree."""
        named = root.attributes.get("main_tree_to_execute")
        if not self._trees:
            self.report(root.at, "no <BehaviorTree> is in this file")
            return None
        if named is None:
            used = {
                one.attributes["ID"].value for one in self._uses(root) if "ID" in one.attributes
            }
            alone = [name for name in self._trees if name not in used]
            if len(alone) == 1:
                return alone[0]
            if len(self._trees) > 1:
                message = f"which of the trees is the mission? ({listed(self._trees)})"
                self.report(root.at, message, "write 'main_tree_to_execute' in <root>")
                return None
            return next(iter(self._trees))
        if named.value not in self._trees:
            message = f"no tree is called {quoted(named.value)} (trees: {listed(self._trees)})"
            self.report(named.value_at, message, did_you_mean(named.value, self._trees))
            return None
        return named.value

    def _uses(self, element: Element) -> Iterator[Element]:
        """Yield the uses of trees within the trees."""
        for child in element.children:
            if child.tag == SUBTREE:
                yield child
            elif child.tag != "TreeNodesModel":
                yield from self._uses(child)

    def _head(self, main: str, ports: TreePorts) -> list[Entry]:
        """Return the head of the mission."""
        element = self._trees[main]
        name = ports.metadata.get("mission", element.attributes["ID"])
        head: list[Entry] = [("mission", name.at, plain_text(name)), *self._description(element)]
        for attribute in ports.metadata.values():
            if attribute.name not in METADATA:
                refuse_attribute(attribute, "Metadata", METADATA, self.report)
            elif attribute.name in ("seed", "observe"):
                value = number(attribute.value)
                shown = located(attribute.value if value is None else value, attribute.value_at)
                head.append((attribute.name, attribute.at, shown))
            elif attribute.name == "nodes":
                targets = [one.strip() for one in attribute.value.split(",")]
                head.append(("nodes", attribute.at, located(targets, attribute.value_at)))
            elif attribute.name == "places":
                head.append(("places", attribute.at, self._places(attribute)))
            elif attribute.name != "mission":
                head.append(entry(attribute))
        needs, inputs, outputs = ports.entries()
        for key, at, _ in needs:
            self.report(at, f"the input {quoted(key)} of the mission needs a default")
        for key, at, _ in outputs:
            self.report(at, f"a mission gives no outputs, such as {quoted(key)}")
        requirements = [self._requirement(one) for one in ports.requirements]
        return [*head, *_section("inputs", inputs), *_section("requirements", requirements)]

    def _places(self, attribute: Attribute) -> LocatedValue:
        """Return the named places of the mission, which are written as in YAML."""
        try:
            return located(read_text(attribute.value).data, attribute.value_at)
        except InputError as error:
            self.report(attribute.value_at, error.faults[0].message)
            return located({}, attribute.value_at)

    def _requirement(self, element: Element) -> Entry:
        """Return the entry of a requirement of the mission."""
        attributes = element.attributes
        for attribute in attributes.values():
            if attribute.name not in AT_REQUIREMENT:
                refuse_attribute(attribute, "Metadata", AT_REQUIREMENT, self.report)
        name, formula = attributes[REQUIREMENT], attributes.get("formula")
        if formula is None:
            self.report(element.at, "the attribute 'formula' is missing")
            return name.value, name.at, located("", element.at)
        action = attributes.get("on_violation")
        if action is None:
            return name.value, name.value_at, plain_text(formula)
        return name.value, name.value_at, mapping(element.at, [entry(formula), entry(action)])

    def _tree_name(self, element: Element) -> str:
        """Return the name of a tree; report it where another tree has it, too."""
        given = element.attributes["ID"]
        named = self._ports[given.value].tree_name(given)
        if named.value in self._names:
            self.report(named.value_at, f"there is a tree {quoted(named.value)} already")
        self._names.add(named.value)
        return named.value

    def _definition(self, element: Element, ports: TreePorts) -> LocatedValue:
        """Return a tree with a name."""
        entries = self._description(element)
        for attribute in ports.metadata.values():
            if attribute.name != TREE_NAME:
                self.report(attribute.at, "only the main tree has metadata that counts")
        for one in ports.requirements:
            self.report(one.at, "only the main tree has requirements")
        for key, found in zip(("needs", "inputs", "outputs"), ports.entries(), strict=True):
            entries += _section(key, found)
        return mapping(element.at, [*entries, ("do", element.at, self._body(element))])

    def _description(self, element: Element) -> list[Entry]:
        for attribute in element.attributes.values():
            if attribute.name not in ("ID", "_description", "_fullpath"):
                refuse_attribute(attribute, "BehaviorTree", ("ID", "_description"), self.report)
        found = element.attributes.get("_description")
        return [] if found is None else [("description", found.at, plain_text(found))]

    def _body(self, element: Element) -> LocatedValue:
        if element.text:
            self.report(element.text_at, f"a loose text: {quoted(element.text)}")
        if len(element.children) != 1:
            message = f"expected 1 node in <BehaviorTree>, got {len(element.children)}"
            self.report(element.at, message)
        nodes = [self.nodes.node(child) for child in element.children]
        return nodes[0] if nodes else located({}, element.at)

    def refuse_size(self, place: Place) -> None:
        """Refuse what no YAML file could hold."""
        waiting = [(place, 1)]
        count = 0
        while waiting:
            part, depth = waiting.pop()
            count += 1
            if depth > MAX_DEPTH:
                message = f"nested too deeply; at most {MAX_DEPTH} levels of YAML are read"
                self.report((part.line, part.column), message)
                return
            inner = part.parts.values() if isinstance(part.parts, dict) else part.parts or ()
            waiting += [(one, depth + 1) for one in inner]
        if count > MAX_VALUES:
            self.report((1, 1), f"more than {MAX_VALUES:,} values; a file holds at most so many")


def _section(key: str, entries: list[Entry]) -> list[Entry]:
    """Return entries as a mapping under a key, where there are any."""
    return [(key, entries[0][1], mapping(entries[0][1], entries))] if entries else []
