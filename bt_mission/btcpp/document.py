"""A whole XML file as the document that a YAML file would be, with its places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
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
from bt_mission.btcpp.includes import IncludeError, Includes
from bt_mission.btcpp.nodes import XmlNodeReader
from bt_mission.btcpp.ports import REQUIREMENT, SUBTREE, TreePorts, read_models
from bt_mission.btcpp.tree_ids import REGISTERED, TREE_NAME
from bt_mission.btcpp.yaml_text import yaml_text
from bt_mission.core.diagnostics import (
    Diagnostic,
    InputError,
    did_you_mean,
    in_order,
    listed,
    quoted,
)
from bt_mission.core.yaml.composer import MAX_DEPTH, MAX_VALUES, At, Place
from bt_mission.core.yaml.document import Document, read_source, read_text
from bt_mission.language.loader import read_mission, required

FORMAT = "4"
AT_REQUIREMENT = (REQUIREMENT, "formula", "on_violation")
METADATA = ("mission", "world", "robot", "seed", "map", "observe", "nodes", "places")
"""What the head of a mission says in `Metadata` of its tree."""

_AT_ROOT = ("BTCPP_format", "main_tree_to_execute")
_AT_INCLUDE = ("path", "ros_pkg")


def read_xml(path: str | Path) -> Document:
    """Read an XML file. Raises InputError with everything that has no counterpart."""
    return document_of(read_source(path), str(path))


def document_of(
    text: str, file: str = "<text>", texts: Mapping[str, str] | None = None
) -> Document:
    """Read XML from a text. Raises InputError with everything that has no counterpart.

    Args:
        text: What the file holds.
        file: Its name; it includes files that lie beside it.
        texts: Those of the files that it may include, by name; None is the disk.
    """
    reader = _FileReader(parse(text, file), _Known(Includes(texts)))
    reader.scan()
    # Without a file that cannot be included, everything that uses its trees would be an error.
    part = reader.mission() if reader.has_all else None
    files = [*reader.files]
    if part is not None and not any(one.nodes.faults for one in files):
        reader.refuse_size(part.place)
    faults = [fault for one in files for fault in (*one.foreign, *one.nodes.faults)]
    if faults or part is None:
        raise InputError(in_order(faults))
    return reader.document(part)


def mission_yaml(path: str | Path) -> str:
    """Return an XML file as a YAML file. Raises InputError with everything that is wrong with it.

    What is read is a mission without faults; whether its goals fit the types of ROS is for `check`.
    The trees of files that it includes are written into it.
    """
    document = read_xml(path)
    mission = required(read_mission(document))
    data = {key: value for key, value in document.data.items() if key != "include"}
    more = [one.data.get("trees", {}) for one in mission.included]
    trees = {name: tree for part in more for name, tree in part.items()}
    if trees:
        own = {**data.pop("trees", {}), **trees}
        data = {**data, "trees": own, "tree": data.pop("tree")}
    return yaml_text(data)


@dataclass
class _Known:
    """What is known of all files of a mission: each uses the trees of the others.

    `owners` are the readers of the files that trees stand in, `names` those that trees have in a
    mission. Does it lack files, which could not be included?
    """

    includes: Includes
    owners: dict[str, _FileReader] = field(default_factory=dict)
    ports: dict[str, TreePorts] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    lacks_files: bool = False


class _FileReader:
    """Reads one file, and those that it includes.

    Args:
        source: The file.
        known: What is known of all files of the mission.
        within: The files that include each other down to this one.
    """

    def __init__(self, source: XmlSource, known: _Known, within: tuple[str, ...] = ()) -> None:
        self.source = source
        self._known = known
        self._within = (source.file, *within)
        self._trees: dict[str, Element] = {}
        """Those of this file."""
        self._included: list[tuple[str, At, _FileReader]] = []
        self.nodes = XmlNodeReader(source)
        self.report = self.nodes.report
        self.foreign: list[Diagnostic] = []
        """What is wrong with included files that cannot be read at all."""

    @property
    def files(self) -> Iterator[_FileReader]:
        """This file, and those that it includes, directly or not."""
        yield self
        for _, _, one in self._included:
            yield from one.files

    @property
    def has_all(self) -> bool:
        """Could every file be included?"""
        return not self._known.lacks_files

    def scan(self) -> None:
        """Find the trees and ports of the file, and of those that it includes."""
        root = self.source.root
        if root.tag != "root":
            self.report(root.at, f'expected <root BTCPP_format="4">, got <{root.tag}>')
            return
        self._look_at(root)
        for child in root.children:
            self._take(child)

    def mission(self) -> LocatedValue | None:
        """Return the whole mission."""
        root = self.source.root
        if root.tag != "root":
            return None
        for one in self.files:
            one.nodes.trees = {name: self._known.ports[name] for name in self._known.owners}
        main = self._main(root)
        if main is None:
            return None
        head = self._head(main, self._known.ports[main])
        head += self.entries(main)
        element = self._trees[main]
        head.append(("tree", element.at, self._body(element)))
        for one in [*self.files][1:]:
            one.library = mapping(one.source.root.at, one.entries(None))
        return mapping(root.at, head)

    library: LocatedValue
    """What an included file holds."""

    def document(self, part: LocatedValue) -> Document:
        """Return the file as a document, with those that it includes."""
        included = {entry: one.document(one.library) for entry, _, one in self._included}
        source = self.source
        return Document(source.file, part.data, part.place, source.lines, included)

    def entries(self, main: str | None) -> list[Entry]:
        """Return the files that it includes, and its trees but the main one."""
        at = self.source.root.at
        trees = [
            (
                self._tree_name(element),
                element.at,
                self._definition(element, self._known.ports[name]),
            )
            for name, element in self._trees.items()
            if name != main
        ]
        entries = [located(entry, entry_at) for entry, entry_at, _ in self._included]
        return [
            *([("include", at, located(entries, at))] if entries else []),
            *([("trees", at, mapping(at, trees))] if trees else []),
        ]

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
            for name, ports in read_models(child, self.report).items():
                self._known.ports[name] = ports
        elif child.tag == "include":
            self._include(child)
        elif child.tag != "BehaviorTree":
            self.report(child.at, f"expected BehaviorTree or TreeNodesModel, got <{child.tag}>")
        else:
            self._take_tree(child, self._identified(child))

    def _take_tree(self, tree: Element, name: Attribute) -> None:
        if name.value in self._known.owners:
            message = f"there is a tree {quoted(name.value)} already"
            other = self._known.owners[name.value]
            where = "" if other is self else f", in {other.source.file}"
            self.report(name.value_at, message + where)
        elif name.value in REGISTERED or name.value in ("Root", "root"):
            message = f"BehaviorTree.CPP has a node {quoted(name.value)}, so no tree has that ID"
            self.report(name.value_at, message, "give the tree another ID")
        self._known.owners.setdefault(name.value, self)
        self._known.ports.setdefault(name.value, TreePorts())
        self._trees[name.value] = tree
        names: dict[str, Attribute] = {}
        for use in self._uses(tree):
            given = use.attributes.get("name")
            if given is not None and names.setdefault(given.value, given) is not given:
                message = f"two SubTrees of this tree have the name {quoted(given.value)}, which "
                self.report(given.value_at, f"{message}BehaviorTree.CPP refuses")

    def _include(self, element: Element) -> None:
        """Take in another file."""
        for attribute in element.attributes.values():
            if attribute.name not in _AT_INCLUDE:
                refuse_attribute(attribute, "include", _AT_INCLUDE, self.report)
        path, package = element.attributes.get("path"), element.attributes.get("ros_pkg")
        if path is None:
            self.report(element.at, "the attribute 'path' is missing")
            return
        try:
            name = None if package is None else package.value
            source = self._known.includes.take(path.value, name, self._within)
        except IncludeError as error:
            self._known.lacks_files = True
            self.report(path.value_at, error.message, error.hint)
        except InputError as error:
            self._known.lacks_files = True
            self.foreign += error.faults
        else:
            if source is not None:
                reader = _FileReader(source, self._known, self._within)
                reader.scan()
                self._included.append((path.value, path.value_at, reader))

    def _identified(self, tree: Element) -> Attribute:
        """Return the ID of a tree; the only one needs none, and is called as the file is."""
        if "ID" not in tree.attributes:
            if sum(child.tag == tree.tag for child in self.source.root.children) > 1:
                self.report(tree.at, "the attribute 'ID' is missing")
            name = Path(self.source.file).stem
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
            if (other := self._known.owners.get(named.value)) is not None:
                message = f"the main tree lies in the included file {other.source.file}"
                self.report(named.value_at, message, "run that file, or name a tree of this one")
                return None
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
        named = self._known.ports[given.value].tree_name(given)
        if named.value in self._known.names:
            self.report(named.value_at, f"there is a tree {quoted(named.value)} already")
        self._known.names.add(named.value)
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
