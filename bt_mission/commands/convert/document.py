"""A whole XML file, and those that it includes, as the document that a YAML file would be."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from bt_mission.base.diagnostics import InputError, did_you_mean, in_order, listed, quoted
from bt_mission.base.errors import HintedError
from bt_mission.base.yaml.composer import MAX_VALUES, At, Place
from bt_mission.base.yaml.document import Document, read_source
from bt_mission.base.yaml.parser_messages import MAX_DEPTH
from bt_mission.commands.convert.attributes import (
    AS_IT_IS,
    FLOW,
    NAMES,
    NUMBER,
    Entry,
    LocatedValue,
    located,
    mapping,
    plain_text,
)
from bt_mission.commands.convert.autoremap import RemappedTree, declaration, shared_names
from bt_mission.commands.convert.elements import Attribute, Element, XmlSource, parse
from bt_mission.commands.convert.node_reader import TreePorts, XmlNodeReader
from bt_mission.commands.convert.table import FORMAT, REGISTERED, REQUIREMENT, SUBTREE, TREE_NAME
from bt_mission.commands.convert.yaml_text import yaml_text
from bt_mission.language.loader import required
from bt_mission.language.trees import MOST_FILES
from bt_mission.requirements.mission_file import read_mission

HEAD = {
    "mission": AS_IT_IS,
    "world": AS_IT_IS,
    "robot": AS_IT_IS,
    "seed": NUMBER,
    "map": AS_IT_IS,
    "observe": NUMBER,
    "nodes": NAMES,
    "places": FLOW,
}
"""What the head of a mission says in `Metadata` of its tree."""

_AT_REQUIREMENT = (REQUIREMENT, "formula", "on_violation")


class _IncludeError(HintedError):
    """A file that cannot be included."""


def read_xml(path: str | Path) -> Document:
    """Read an XML file. Raises InputError with all parts without a counterpart."""
    return document_of(read_source(path), str(path))


def document_of(
    text: str, file: str = "<text>", texts: Mapping[str, str] | None = None
) -> Document:
    """Read XML from a text. Raises InputError with all parts without a counterpart.

    Args:
        text: What the file holds.
        file: Its name; it includes files that lie beside it.
        texts: Those of the files that it may include, by name; None is the disk.
    """
    reader = _FileReader(parse(text, file), known=_Known(texts))
    reader.scan()
    # Without a file that cannot be included, everything that uses its trees would be an error.
    part = reader.mission() if reader.known.has_all_files else None
    files = list(reader.files())
    if part is not None and not any(source.diagnostics for source in files):
        reader.refuse_size(part.place)
        for source in files:
            source.refuse_shared()
    diagnostics = [diagnostic for source in files for diagnostic in source.diagnostics]
    if diagnostics or part is None:
        raise InputError(in_order(diagnostics))
    return reader.document(part)


def mission_yaml(path: str | Path) -> str:
    """Return an XML file as a YAML file. Raises InputError with all its errors.

    The mission has no errors; `check` compares its goals with the types of ROS.
    The trees of files that it includes are written into it.
    """
    document = read_xml(path)
    mission = required(read_mission(document))
    data = {key: value for key, value in document.data.items() if key != "include"}
    more = [included.data.get("trees", {}) for included in mission.included]
    if trees := {name: tree for part in more for name, tree in part.items()}:
        own = {**data.pop("trees", {}), **trees}
        data = {**data, "trees": own, "tree": data.pop("tree")}
    return yaml_text(data)


@dataclass
class _Known:
    """What is known of all files of a mission: each uses the trees of the others.

    Attributes:
        texts: The files that may be included, by name; None is the disk.
        included: Those that were read, each once.
        owners: The readers of the files that trees stand in, by the IDs of the trees.
        ports: What is declared of trees, by their IDs.
        names: The names of trees in the mission.
        trees: The trees that were read, by their IDs.
        has_all_files: Whether every file could be included.
    """

    texts: Mapping[str, str] | None
    included: set[str] = field(default_factory=set)
    owners: dict[str, _FileReader] = field(default_factory=dict)
    ports: dict[str, TreePorts] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    trees: dict[str, RemappedTree] = field(default_factory=dict)
    has_all_files: bool = True


@dataclass(kw_only=True)
class _FileReader(XmlNodeReader):
    """Reads one file, and those that it includes; `within` are the files around this one."""

    source: XmlSource = field(kw_only=False)
    known: _Known
    within: tuple[str, ...] = ()
    library: LocatedValue | None = None
    """The content of an included file."""

    def __post_init__(self) -> None:
        self.within = (self.source.file, *self.within)
        self.elements: dict[str, Element] = {}
        self._included: list[tuple[str, At, _FileReader]] = []

    def files(self) -> Iterator[_FileReader]:
        """Yield this reader, and those of the files that it includes, directly or not."""
        yield self
        for _, _, inner in self._included:
            yield from inner.files()

    def scan(self) -> None:
        """Find the trees and ports of the file, and of those that it includes."""
        root = self.source.root
        if root.tag != "root":
            self.report("BT-1202", root.at, f'expected <root BTCPP_format="4">, got <{root.tag}>')
            return
        known = ("BTCPP_format", "main_tree_to_execute")
        self.refuse(root.attributes.values(), "root", known, "project_name")
        version = root.attributes.get("BTCPP_format")
        if version is None:
            message = f"the attribute 'BTCPP_format' is missing; format {FORMAT} is read"
            self.report("BT-1207", root.at, message, f'write <root BTCPP_format="{FORMAT}">')
        elif version.value != FORMAT:
            message = f"expected format {FORMAT}, got {quoted(version.value)}"
            self.report("BT-1203", version.value_at, message)
        if root.text:
            self.report(
                "BT-1209", root.text_at, f"text outside of any element: {quoted(root.text)}"
            )
        for child in root.children:
            if child.tag == "TreeNodesModel":
                self._take_models(child)
            elif child.tag == "include":
                self._include(child)
            elif child.tag == "BehaviorTree":
                self._take_tree(child, self._identified(child))
            else:
                self.report(
                    "BT-1202",
                    child.at,
                    f"expected BehaviorTree or TreeNodesModel, got <{child.tag}>",
                )

    def mission(self) -> LocatedValue | None:
        """Return the whole mission."""
        root = self.source.root
        if root.tag != "root":
            return None
        for part in self.files():
            part.trees = {name: self.known.ports[name] for name in self.known.owners}
        main = self._main(root)
        if main is None:
            return None
        if self._uses_itself(main):
            for part in self.files():
                part.main = main
        element = self.elements[main]
        head = [*self._head(main, self.known.ports[main]), *self.parts(main)]
        head.append(("tree", element.at, self._body(element)))
        for part in [*self.files()][1:]:
            part.library = mapping(part.source.root.at, part.parts())
        return mapping(root.at, head)

    def _uses_itself(self, main: str) -> bool:
        """Return whether the main tree uses itself, directly or through others."""
        trees = {key: reader.elements[key] for key, reader in self.known.owners.items()}
        waiting, reached = [main], set[str]()
        while waiting:
            for use in _uses(trees[waiting.pop()]):
                tree_id = use.attributes.get("ID")
                if tree_id is not None and tree_id.value in trees.keys() - reached:
                    reached.add(tree_id.value)
                    waiting.append(tree_id.value)
        return main in reached

    def document(self, part: LocatedValue) -> Document:
        """Return the file as a document, with those that it includes."""
        included = {
            entry: inner.document(inner.library)
            for entry, _, inner in self._included
            if inner.library
        }
        source = self.source
        return Document(source.file, part.data, part.place, source.lines, included)

    def parts(self, main: str | None = None) -> Iterator[Entry]:
        """Yield the files that it includes, and its trees but the main one."""
        at = self.source.root.at
        if self._included:
            entries = [located(entry, entry_at) for entry, entry_at, _ in self._included]
            yield "include", at, located(entries, at)
        trees = [
            (self._tree_name(element), element.at, self._definition(element, self.trees[tree_id]))
            for tree_id, element in self.elements.items()
            if tree_id != main
        ]
        if trees:
            yield "trees", at, mapping(at, trees)

    # ---- the parts of a file -----------------------------------------------------------------

    def _take_models(self, models: Element) -> None:
        """Take in what is declared of trees; models of other nodes say nothing new."""
        new_ports: dict[str, TreePorts] = {}
        for element in models.children:
            if element.tag == SUBTREE and "ID" in element.attributes:
                ports = new_ports.setdefault(element.attributes["ID"].value, TreePorts())
                for child in element.children:
                    ports.declare(child, self)
        self.known.ports |= new_ports

    def _take_tree(self, tree: Element, name: Attribute) -> None:
        owner = self.known.owners.setdefault(name.value, self)
        if name.value in self.elements or owner is not self:
            where = "" if owner is self else f", in {owner.source.file}"
            self.report(
                "BT-208", name.value_at, f"the tree {quoted(name.value)} already exists{where}"
            )
        elif name.value in REGISTERED or name.value in ("Root", "root"):
            message = f"BehaviorTree.CPP has a node {quoted(name.value)}, so no tree has that ID"
            self.report("BT-208", name.value_at, message, "give the tree another ID")
        self.known.ports.setdefault(name.value, TreePorts())
        self.elements[name.value] = tree
        names: dict[str, Attribute] = {}
        for use in _uses(tree):
            given = use.attributes.get("name")
            if given is not None and names.setdefault(given.value, given) is not given:
                message = f"two SubTrees of this tree have the name {quoted(given.value)}, which "
                self.report("BT-208", given.value_at, f"{message}BehaviorTree.CPP refuses")

    def _identified(self, tree: Element) -> Attribute:
        """Return the ID of a tree; the only one needs none, and is called as the file is."""
        if "ID" not in tree.attributes:
            if sum(child.tag == tree.tag for child in self.source.root.children) > 1:
                self.report("BT-1207", tree.at, "the attribute 'ID' is missing")
            name = Path(self.source.file).stem
            tree.attributes["ID"] = Attribute("ID", name, tree.at, tree.at)
        return tree.attributes["ID"]

    def _main(self, root: Element) -> str | None:
        """Return the ID of the main tree."""
        named = root.attributes.get("main_tree_to_execute")
        if not self.elements:
            self.report("BT-1211", root.at, "this file has no <BehaviorTree>")
            return None
        if named is None:
            used = {use.attributes["ID"].value for use in _uses(root) if "ID" in use.attributes}
            alone = [name for name in self.elements if name not in used]
            if len(alone) == 1 or len(self.elements) == 1:
                return (*alone, *self.elements)[0]
            message = f"which of the trees is the mission? ({listed(self.elements)})"
            self.report("BT-1211", root.at, message, "write 'main_tree_to_execute' in <root>")
            return None
        if named.value in self.elements:
            return named.value
        if (other := self.known.owners.get(named.value)) is not None:
            message = f"the main tree is in the included file {other.source.file}"
            self.report(
                "BT-210", named.value_at, message, "run that file, or name a tree of this one"
            )
            return None
        message = f"unknown tree {quoted(named.value)} (trees: {listed(self.elements)})"
        self.report("BT-210", named.value_at, message, did_you_mean(named.value, self.elements))
        return None

    def _head(self, main: str, ports: TreePorts) -> Iterator[Entry]:
        """Yield the head of the mission."""
        element = self.elements[main]
        name = ports.metadata.get("mission", element.attributes["ID"])
        yield "mission", name.at, plain_text(name)
        yield from self._description(element)
        self.refuse(ports.metadata.values(), "Metadata", tuple(HEAD))
        for key, attribute in ports.metadata.items():
            if key in HEAD and key != "mission":
                yield key, attribute.at, self.value(attribute, HEAD[key])
        for key, at, _ in ports.sections["needs"].values():
            self.report("BT-1210", at, f"the input {quoted(key)} of the mission needs a default")
        for key, at, _ in ports.outputs.values():
            self.report("BT-1210", at, f"a mission has no outputs, such as {quoted(key)}")
        yield from _section("inputs", [*ports.sections["inputs"].values()])
        yield from _section(
            "requirements", [self._requirement(requirement) for requirement in ports.requirements]
        )

    def _requirement(self, element: Element) -> Entry:
        """Return the entry of a requirement of the mission."""
        attributes = element.attributes
        self.refuse(attributes.values(), "Metadata", _AT_REQUIREMENT)
        name, formula = attributes[REQUIREMENT], attributes.get("formula")
        if formula is None:
            self.report("BT-1207", element.at, "the attribute 'formula' is missing")
            return name.value, name.at, located("", element.at)
        action = attributes.get("on_violation")
        if action is None:
            return name.value, name.value_at, plain_text(formula)
        entries = [
            (attribute.name, attribute.at, plain_text(attribute)) for attribute in (formula, action)
        ]
        return name.value, name.value_at, mapping(element.at, entries)

    def _tree_name(self, element: Element) -> str:
        """Return the name of a tree; report it where another tree has it, too."""
        tree_id = element.attributes["ID"]
        named = self.trees[tree_id.value].tree_name(tree_id)
        if named.value in self.known.names:
            self.report("BT-208", named.value_at, f"the tree {quoted(named.value)} already exists")
        self.known.names.add(named.value)
        return named.value

    def _definition(self, element: Element, ports: TreePorts) -> LocatedValue:
        """Return a tree with a name."""
        entries = [*self._description(element)]
        for attribute in ports.metadata.values():
            if attribute.name != TREE_NAME:
                self.report("BT-1210", attribute.at, "metadata is read only from the main tree")
        for requirement in ports.requirements:
            self.report("BT-1210", requirement.at, "requirements belong to the main tree")
        for key, declared in ports.sections.items():
            entries += _section(key, [*declared.values()])
        return mapping(element.at, [*entries, ("do", element.at, self._body(element))])

    def _description(self, element: Element) -> Iterator[Entry]:
        attributes = element.attributes
        known = ("ID", "_description")
        self.refuse(attributes.values(), "BehaviorTree", known)
        if description := attributes.get("_description"):
            yield "description", description.at, plain_text(description)

    def _body(self, element: Element) -> LocatedValue:
        if element.text:
            self.report(
                "BT-1209", element.text_at, f"text outside of any element: {quoted(element.text)}"
            )
        if len(element.children) != 1:
            message = f"expected 1 node in <BehaviorTree>, got {len(element.children)}"
            self.report("BT-1208", element.at, message)
        nodes = [self.node(child) for child in element.children]
        body = nodes[0] if nodes else located({}, element.at)
        tree_id = element.attributes["ID"].value
        ports = self.known.ports[tree_id]
        self.known.trees[tree_id] = RemappedTree(
            element,
            Document(self.source.file, body.data, body.place, self.source.lines),
            (*ports.inputs, *ports.outputs),
        )
        return body

    def refuse_size(self, place: Place) -> None:
        """Refuse what no YAML file could hold."""
        waiting = [(place, 1)]
        count = 0
        while waiting:
            part, depth = waiting.pop()
            count += 1
            if depth > MAX_DEPTH:
                message = f"nested too deeply; the limit is {MAX_DEPTH} levels of YAML"
                self.report("BT-103", (part.line, part.column), message)
                return
            inner = part.parts.values() if isinstance(part.parts, dict) else part.parts or ()
            waiting += [(nested, depth + 1) for nested in inner]
        if count > MAX_VALUES:
            self.report("BT-103", (1, 1), f"the file exceeds the limit of {MAX_VALUES:,} values")

    def refuse_shared(self) -> None:
        """Refuse variables without a port that `_autoremap` shares."""
        for attribute, tree_id in self.remapped:
            trees = self.known.trees
            if shared := shared_names(tree_id, trees):
                message = (
                    f"'{attribute.name}' shares {listed(map(quoted, shared))} with the caller, "
                    f"but the tree {quoted(tree_id)} has no such port"
                )
                hint = declaration(tree_id, trees[tree_id], shared)
                self.report("BT-212", attribute.at, message, hint)

    # ---- included files ----------------------------------------------------------------------

    def _include(self, element: Element) -> None:
        """Take in another file."""
        self.refuse(element.attributes.values(), "include", ("path", "ros_pkg"))
        path, package = element.attributes.get("path"), element.attributes.get("ros_pkg")
        if path is None:
            self.report("BT-1207", element.at, "the attribute 'path' is missing")
            return
        try:
            source = self._included_source(path.value, package.value if package else None)
        except _IncludeError as error:
            self.known.has_all_files = False
            self.report(error.code, path.value_at, error.message, error.hint)
        except InputError as error:  # of the other file
            self.known.has_all_files = False
            self.diagnostics[:0] = error.diagnostics
        else:
            if source is not None:
                reader = _FileReader(source, known=self.known, within=self.within)
                reader.scan()
                self._included.append((path.value, path.value_at, reader))

    def _included_source(self, path: str, package: str | None) -> XmlSource | None:
        """Return a file that this one includes; None if it was included before.

        Raises:
            _IncludeError: For a file that is not there, or may not be included.
            InputError: For a file that is no XML.
        """
        known = self.known
        if known.texts is None:
            name = _located_file(path, package, self.within[0])
        else:
            name = _file_among(known.texts, path, self.within[0])
        if name in self.within:
            ring = " -> ".join(
                PurePath(file_name).name for file_name in (*reversed(self.within), name)
            )
            raise _IncludeError("BT-112", f"the files include each other: {ring}")
        if name in known.included:
            return None
        known.included.add(name)
        if len(known.included) > MOST_FILES:
            raise _IncludeError(
                "BT-112", f"more than {MOST_FILES} included files, which is the limit"
            )
        return parse(read_source(name) if known.texts is None else known.texts[name], name)


def _uses(element: Element) -> Iterator[Element]:
    """Yield the uses of trees within the trees."""
    for child in element.children:
        if child.tag == SUBTREE:
            yield child
        elif child.tag != "TreeNodesModel":
            yield from _uses(child)


def _section(key: str, entries: list[Entry]) -> Iterator[Entry]:
    """Yield entries as a mapping under a key, where there are any."""
    if entries:
        yield key, entries[0][1], mapping(entries[0][1], entries)


def _file_among(texts: Mapping[str, str], path: str, file: str) -> str:
    """Return the name of a file that another one includes, among those that may be."""
    beside = os.path.normpath(Path(file).parent / path)
    like = [name for name in texts if PurePath(name).match(path)]
    tree_id = next((name for name in (beside, *like) if name in texts), None)
    if tree_id is None:
        raise _IncludeError("BT-112", f"no such file {quoted(path)}")
    return tree_id


def _located_file(path: str, package: str | None, file: str) -> str:
    """Return a file beside another one, or in the share folder of a ROS package."""
    where = "the folder of the file that includes it" if package is None else "the package"
    folder = Path(file).parent if package is None else _share_folder(package)
    try:
        if package is None and not Path(file).is_file():
            raise _IncludeError("BT-112", "a mission that is not a file cannot include files")
        real = (folder / path).resolve(strict=True)
        is_inside = real.is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # a ring of links, a name that is too long
        raise _IncludeError("BT-112", f"no such file {quoted(path)} in {where}") from None
    if not is_inside:
        raise _IncludeError("BT-112", f"{quoted(path)} is outside {where}")
    if not real.is_file():
        raise _IncludeError("BT-112", f"{quoted(path)} is not a file")
    return str(folder / path)


def _share_folder(package: str) -> Path:
    """Return the share folder of a ROS package. Raises _IncludeError where it is not installed."""
    try:
        from ament_index_python.packages import (
            get_package_share_directory,
        )

        return Path(get_package_share_directory(package))
    except ImportError:
        raise _IncludeError(
            "BT-112", "ROS 2 is not available, so its packages are unknown"
        ) from None
    except (LookupError, ValueError, OSError):
        hint = "source the workspace of the package, or copy the file next to this one"
        raise _IncludeError(
            "BT-112", f"the ROS package {quoted(package)} is not installed", hint
        ) from None
