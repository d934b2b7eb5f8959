"""Trees that have names: gathered from a mission file and the files it includes, and read.

An included file lies in the folder of the file that includes it, or below, or is a shipped
mission. Links are followed before that is judged.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from itertools import chain
from pathlib import Path, PurePath

from bt_mission.base import files
from bt_mission.base.diagnostics import Diagnostic, InputError, quoted
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.language.expressions.places import Places
from bt_mission.language.expressions.values import Type, type_of
from bt_mission.language.file import Library, MissionFile, TreeDefinition
from bt_mission.language.goal_limits import GoalLimitsTable
from bt_mission.language.mission import Mission, Tree
from bt_mission.language.node_reader import NodeReader, Signature
from bt_mission.language.nodes.base import Key, NodeModel
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.language.permissions import ANYTHING, Permissions

MOST_FILES = 100
"""The most files that a mission includes, directly or not."""

MOST_LEVELS = 200
"""The most levels of a mission's tree, those of the trees that it uses included. A tick goes down
a level in up to three calls, and Python has a thousand."""

MOST_NODES = 30_000
"""The most nodes of a mission, with all uses of trees; such a mission takes up to 170 MB."""

SHOWN_RING = 20
"""The most names of trees that use each other in an error."""


@dataclass
class TreeLibrary:
    """The named trees of a mission as they are gathered."""

    permissions: Permissions = ANYTHING
    included: list[Document] = field(default_factory=list)
    signatures: dict[str, Signature] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    _read: set[Path] = field(default_factory=set)

    def gather(self, document: Document, written: MissionFile | Library) -> None:
        """Take in the trees of a mission file, and of all that it includes."""
        path = Path(document.file)
        real = _real(path) if self.permissions.texts is None else path
        self._gather(document, written, () if real is None else (real,))

    def _gather(
        self, document: Document, written: MissionFile | Library, within: tuple[Path, ...]
    ) -> None:
        if written.include and not self.permissions.includes:
            message = "this mission may not include files"
            self.diagnostics.append(
                document.diagnostic("BT-112", ("include",), message, self.permissions.hint)
            )
            written = written.model_copy(update={"include": []})
        for index, entry in enumerate(written.include):
            if index == MOST_FILES:
                message = f"more than {MOST_FILES} included files, which is the limit"
                self.diagnostics.append(document.diagnostic("BT-112", ("include", index), message))
                break
            self._include(document, ("include", index), entry, within)
        for name, content in written.trees.items():
            path = ("trees", name)
            if name in self.signatures:
                other = self.signatures[name]
                line, _ = other.document.position(other.path, key=True)
                message = f"the tree '{name}' already exists, in {other.document.file}:{line}"
                self.diagnostics.append(document.diagnostic("BT-208", path, message, key=True))
                continue
            reader = NodeReader(document)
            definition = reader.written(TreeDefinition, path, content)
            self.diagnostics += reader.diagnostics
            if definition is not None:
                types: dict[str, Type | None] = dict(definition.needs)
                for given, value in definition.inputs.items():
                    if given in definition.needs:
                        place = (*path, "inputs", given)
                        message = f"'{given}' is a required input, so it cannot have a default"
                        self.diagnostics.append(
                            document.diagnostic("BT-212", place, message, key=True)
                        )
                    types[given] = type_of(value)
                self.signatures[name] = Signature(name, definition, types, document, path)

    def _include(
        self, document: Document, place: tuple[Key, ...], entry: str, within: tuple[Path, ...]
    ) -> None:
        attached = document.included.get(entry)
        try:
            shown, path = self._located(document, entry, attached)
        except InputError as error:
            self.diagnostics += [
                document.diagnostic(each.code, place, each.message, each.hint)
                for each in error.diagnostics
            ]
            return
        if path in within:
            ring = " -> ".join(ancestor.name for ancestor in (*within[within.index(path) :], path))
            self.diagnostics.append(
                document.diagnostic("BT-112", place, f"the files include each other: {ring}")
            )
        elif path not in self._read:
            self._read.add(path)
            if len(self._read) > MOST_FILES:
                message = f"more than {MOST_FILES} included files, which is the limit"
                self.diagnostics.append(document.diagnostic("BT-112", place, message))
                return
            try:
                included = attached or self._read_file(shown)
            except InputError as error:
                self.diagnostics += error.diagnostics
                return
            self.included.append(included)
            reader = NodeReader(included)
            library = reader.written(Library, (), included.data)
            self.diagnostics += reader.diagnostics
            if library is not None:
                self._gather(included, library, (*within, path))

    def _located(
        self, document: Document, entry: str, attached: Document | None
    ) -> tuple[Path, Path]:
        """Return an included file as it is shown, and what distinguishes it from others."""
        texts = self.permissions.texts
        if attached is not None:
            path = Path(attached.file)
            if texts is None and not self.permissions.allows(path, "missions"):
                raise InputError([Diagnostic("BT-112", f"no such file {quoted(entry)}", entry)])
            return path, _real(path) or path
        if texts is None:
            return _located(document, entry, self.permissions)
        beside = os.path.normpath(Path(document.file).parent / entry)
        for name in [beside, *(name for name in texts if PurePath(name).match(entry))]:
            if name in texts:
                return Path(name), Path(name)
        raise InputError([Diagnostic("BT-112", f"no such file {quoted(entry)}", entry)])

    def _read_file(self, path: Path) -> Document:
        texts = self.permissions.texts
        return read(path) if texts is None else read_text(texts[str(path)], str(path))


def read_trees(
    shelf: TreeLibrary, limits: GoalLimitsTable, places: Places
) -> tuple[dict[str, Tree], list[Diagnostic]]:
    """Return the named trees of a shelf as far as they can be read, and what is wrong with them.

    `limits` and `places` are the mission's, also for the goals of trees that it includes.
    """
    trees: dict[str, Tree] = {}
    diagnostics: list[Diagnostic] = []
    for name, signature in shelf.signatures.items():
        document, path = signature.document, (*signature.path, "do")
        part: object = document.data
        for key in path:
            part = part[key] if isinstance(part, dict) and key in part else None
        reader = NodeReader(document, shelf.signatures, limits, places)
        body = reader.node(part, path)
        follow = reader.follows(signature.path, signature.types)
        diagnostics += reader.diagnostics
        if body is not None:
            trees[name] = Tree(
                name=name,
                body=body,
                document=document,
                path=signature.path,
                inputs=signature.definition.inputs,
                types=signature.types,
                outputs=signature.definition.outputs,
                follow=follow,
                lost=frozenset(reader.lost),
            )
    return trees, diagnostics


def size_diagnostics(document: Document, mission: Mission) -> Iterator[Diagnostic]:
    """Yield a diagnostic for trees that use themselves, or a mission that is too large."""
    trees = mission.trees
    uses = {name: [use for use in _uses(tree.body) if use in trees] for name, tree in trees.items()}
    try:
        order = tuple(TopologicalSorter(uses).static_order())
    except CycleError as error:
        ring: list[str] = error.args[1][:0:-1]
        first = ring.index(min(ring))
        ring = [*ring[first:], *ring[:first]]
        more = ("...",) if len(ring) > SHOWN_RING else ()
        message = f"a tree cannot use itself: {' -> '.join((*ring[:SHOWN_RING], *more, ring[0]))}"
        yield trees[ring[0]].document.diagnostic("BT-211", trees[ring[0]].path, message, key=True)
        return
    sizes: dict[str, tuple[int, int]] = {}
    for name in order:
        sizes[name] = _size(trees[name].body, sizes)
    count, levels = _size(mission.tree, sizes)
    if count > MOST_NODES:
        message = f"the mission has {count:,} nodes with all uses of trees"
        yield document.diagnostic(
            "BT-209", ("tree",), f"{message}; the limit is {MOST_NODES:,}", key=True
        )
    if levels > MOST_LEVELS:
        message = f"the mission has {levels:,} levels of nodes with the trees it uses"
        yield document.diagnostic(
            "BT-209", ("tree",), f"{message}; the limit is {MOST_LEVELS}", key=True
        )


def reached(node: NodeModel, mission: Mission) -> Iterator[NodeModel]:
    """Yield a node and all below it, with those of the trees that are used, each tree once."""
    waiting, seen = [node], set[str]()
    while waiting:
        for below in waiting.pop().walk():
            yield below
            if isinstance(below, TreeNode) and below.tree not in seen:
                seen.add(below.tree)
                if below.tree in mission.trees:
                    waiting.append(mission.trees[below.tree].body)


def used(mission: Mission) -> dict[str, None]:
    """Return the names of the trees that a mission uses, directly or not."""
    uses = (node.tree for node in reached(mission.tree, mission) if isinstance(node, TreeNode))
    return dict.fromkeys(name for name in uses if name in mission.trees)


def _uses(body: NodeModel) -> list[str]:
    return list(dict.fromkeys(step.tree for step in body.walk() if isinstance(step, TreeNode)))


def _size(body: NodeModel, sizes: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return the nodes and the levels of a tree; those of the trees that it uses are known."""
    count, levels = 0, 0
    waiting = [(body, 1)]
    while waiting:
        step, level = waiting.pop()
        inner = sizes.get(step.tree, (0, 0)) if isinstance(step, TreeNode) else (0, 0)
        count += 1 + inner[0]
        levels = max(levels, level + inner[1])
        waiting += [(below, level + 1) for below in step.below]
    return count, levels


def _located(document: Document, entry: str, permissions: Permissions) -> tuple[Path, Path]:
    """Return an included file as it is shown, and where it really is. Raises InputError.

    A file that may not be used is told of as one that is not there.
    """
    base = Path(document.file).parent
    shipped = [folder.resolve() for folder in files.folders("missions")]
    candidates = [base / entry] if _real(Path(document.file)) else []
    candidates += [folder / entry for folder in files.folders("missions")]
    candidates = [path for path in candidates if permissions.allows(path, "missions")]
    path = next((candidate for candidate in candidates if _real(candidate) is not None), None)
    if path is None:
        is_link = any(_is_link(candidate) for candidate in candidates)
        missing = f"the symbolic links of {quoted(entry)} do not lead to a file"
        raise InputError(
            [Diagnostic("BT-112", missing if is_link else f"no such file {quoted(entry)}", entry)]
        )
    real = _real(path)
    assert real is not None
    allowed = [base.resolve(), *shipped]
    if not any(real.is_relative_to(folder) for folder in allowed):
        message = f"{quoted(entry)} is outside the folder of the file that includes it"
        raise InputError([Diagnostic("BT-112", message, entry)])
    return path, real


def _real(path: Path) -> Path | None:
    """Return where a file really is, links followed; None where there is none."""
    try:
        return path.resolve(strict=True) if path.is_file() else None
    except (OSError, RuntimeError, ValueError):  # a ring of links, a name that is too long
        return None


def _is_link(path: Path) -> bool:
    try:
        return path.is_symlink()
    except OSError:  # a name that is too long
        return False


def all_steps(mission: Mission) -> Iterator[NodeModel]:
    """Yield every step of a mission and of its named trees."""
    return chain.from_iterable(tree.body.walk() for tree in mission.all_trees)


def has_python(mission: Mission) -> bool:
    """Return whether a mission has behaviours of users."""
    return any(isinstance(step, PythonNode) for step in all_steps(mission))
