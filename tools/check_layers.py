#!/usr/bin/env python3
"""Check the layers of the packages: print them, and every cycle and upward import.

Imports are read from the syntax trees, wherever they stand: at the top, inside functions and under
``TYPE_CHECKING``. Exit code 0 when there is neither a cycle nor an upward import, else 1.
"""

from __future__ import annotations

import ast
import functools
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bt_mission.base.commands import ROWS, row_of  # noqa: E402 - from the root

LAYERS: tuple[tuple[str, ...], ...] = (
    ("bt_mission.base",),
    ("bt_mission.cdr", "bt_mission.robots", "bt_mission.language", "bt_mission.ros.executors"),
    ("bt_mission.requirements", "bt_mission.executive", "bt_mission.ros.virtual_time"),
    ("bt_mission.programs", "bt_mission.ros"),
    ("bt_mission.sessions",),
    ("bt_mission.recording", "bt_mission.scenarios"),
    ("bt_mission.views",),
    ("bt_mission.testing", "bt_mission.cli"),
    ("bt_mission.commands",),
)
"""Packages of bt_mission, from the lowest layer: each imports those of lower layers.

A part of a package may have a layer of its own, below the rest of it.
"""

COMMANDS = "bt_mission.commands"


def _needs() -> dict[str, set[str]]:
    """Return the folders of commands that import those of other ones, as the rows say."""
    needs: dict[str, set[str]] = {}
    for row in ROWS:
        needs.setdefault(row.folder, set()).update(row_of(name).folder for name in row.needs)
    return needs


NEEDS = _needs()

PARTS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "action_servers": (
        ("core",),
        ("driving", "navigation", "robot_io"),
        ("mapping", "camera", "arbiter"),
        ("server",),
    ),
    "sim": (
        ("world", "faults", "frames"),
        ("physics",),
        ("sensors",),
        ("robot", "spawnables"),
        ("simulation", "entities"),
        ("views",),
        ("ros",),
    ),
    "bt_mission.language": (
        ("expressions",),
        ("nodes",),
        ("file", "mission"),
        ("node_reader",),
        ("trees",),
        ("checks",),
        ("loader",),
    ),
    "bt_mission.executive": (("goals",), ("events",), ("behaviours",)),
}
"""Parts of one package, from the lowest; a module that is not named belongs to no layer."""

SHARED = ("bt_mission.base", "bt_mission.cdr", "bt_mission.robots", "bt_mission.ros.executors")
"""What ``action_servers`` and ``sim`` import of bt_mission."""

ASSEMBLES = (
    "bt_mission.sessions",
    "bt_mission.scenarios",
    "bt_mission.cli",
    "bt_mission.commands",
    "bt_mission.testing",
)
"""Packages that put ``action_servers`` and ``sim`` together with the executive."""

SPEAKS_ROS = (
    "bt_mission.ros",
    "bt_mission.programs",
    "bt_mission.sessions",
    "bt_mission.scenarios",
    "bt_mission.recording",
    "bt_mission.testing",
    "bt_mission.cli",
    "bt_mission.commands",
    "sim.ros",
    "action_servers.mapping.node",
    "action_servers.robot_io",
    "action_servers.arbiter.node",
    "action_servers.server",
)
"""Packages and modules that may import rclpy and generated messages."""

TOPS = ("bt_mission", "action_servers", "sim")


@dataclass(frozen=True)
class Import:
    """One import: the module that has it, the module that it names, and the line."""

    importer: str
    imported: str
    line: int


def modules(root: Path = ROOT) -> dict[str, Path]:
    """Return the file of each module of the three packages, by its dotted name."""
    modules_by_name = {}
    for top in TOPS:
        for path in sorted((root / top).rglob("*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            modules_by_name[name.removesuffix(".__init__")] = path
    return modules_by_name


def imported_names(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Yield the full name of each import of a module, and its line."""
    yield from _imported_names(list(ast.walk(tree)))


def _imported_names(nodes: list[ast.AST]) -> Iterator[tuple[str, int]]:
    for node in nodes:
        match node:
            case ast.Import(names=aliases):
                yield from ((alias.name, node.lineno) for alias in aliases)
            case ast.ImportFrom(names=aliases, module=str(parent), level=0):
                yield from ((f"{parent}.{alias.name}", node.lineno) for alias in aliases)
            case ast.Call(
                func=ast.Attribute(attr="import_module")
                | ast.Name(id="import_module" | "__import__"),
                args=[ast.Constant(value=str(name)), *_],
            ):
                yield name, node.lineno


@functools.lru_cache(maxsize=1)
def nodes_of(text: str) -> list[ast.AST]:
    """Return all nodes of the tree of a text; several rules ask for those of one module."""
    return list(ast.walk(ast.parse(text)))


@functools.lru_cache(maxsize=1)
def names_imported_by(text: str) -> list[tuple[str, int]]:
    """Return the full name of each import of a text, and its line."""
    return list(_imported_names(nodes_of(text)))


def imports_of(name: str, text: str, known: Mapping[str, object]) -> list[Import]:
    """Return the imports of ours that a module has, each resolved to a module."""
    imports = []
    for full, line in names_imported_by(text):
        module = full if full in known else full.rpartition(".")[0]
        if module in known and module != name:
            imports.append(Import(name, module, line))
    return imports


def is_in(name: str, package: str) -> bool:
    """Return whether a module is a package, or lies in it."""
    return name == package or name.startswith(f"{package}.")


def _rank(name: str, layers: tuple[tuple[str, ...], ...], prefix: str = "") -> int | None:
    for rank, packages in enumerate(layers):
        if any(is_in(name, prefix + package) for package in packages):
            return rank
    return None


def _layer_of(name: str) -> str:
    """Return the entry of LAYERS that a module lies in, the innermost one; empty for none."""
    entries = (entry for layer in LAYERS for entry in layer if is_in(name, entry))
    return max(entries, key=len, default="")


def _package(name: str, prefix: str = "bt_mission") -> str:
    return ".".join(name.split(".")[: prefix.count(".") + 2])


def _between_tops(importer: str, imported: str) -> str | None:
    """Return why a package of one top-level folder may not import one of another."""
    top = importer.partition(".")[0]
    if top == "bt_mission":
        may = any(is_in(importer, package) for package in ASSEMBLES)
        return None if may else f"only {', '.join(ASSEMBLES)} import servers and simulator"
    may = any(is_in(imported, package) for package in SHARED)
    return None if may else f"{top} imports of bt_mission only {', '.join(SHARED)}"


def _between_commands(importer: str, imported: str) -> str | None:
    """Return why a command may not import another one."""
    here, there = _package(importer, COMMANDS), _package(imported, COMMANDS)
    if there in (COMMANDS, here) or there in NEEDS.get(here, ()):
        return None
    return "a command imports another one, and its row has no such `needs`"


def _between_layers(importer: str, imported: str) -> str | None:
    """Return why a package of bt_mission may not import another one."""
    if imported == "bt_mission":
        return None
    here, there = (_rank(_layer_of(name), LAYERS) for name in (importer, imported))
    if here is None or there is None:
        return "a package without a layer; give it one in tools/check_layers.py"
    return f"layer {here} imports layer {there}" if there >= here else None


def _between_parts(importer: str, imported: str) -> str | None:
    """Return why a part of a package may not import another part of it."""
    for package, parts in PARTS.items():
        if not (is_in(importer, package) and is_in(imported, package)):
            continue
        here, there = _rank(importer, parts, f"{package}."), _rank(imported, parts, f"{package}.")
        same = _package(importer, package) == _package(imported, package)
        if here is not None and there is not None and not same and there >= here:
            return f"inside {package} part {here} imports part {there}"
    return None


def fault_of(edge: Import) -> str | None:
    """Return why an import is against the layers, or None when it is not."""
    importer, imported = edge.importer, edge.imported
    if importer in TOPS or importer == "bt_mission.__main__":
        return None
    if importer.partition(".")[0] != imported.partition(".")[0]:
        return _between_tops(importer, imported)
    if is_in(importer, COMMANDS) and is_in(imported, COMMANDS):
        return _between_commands(importer, imported)
    if is_in(importer, "bt_mission") and _layer_of(importer) != _layer_of(imported):
        return _between_layers(importer, imported)
    return _between_parts(importer, imported)


def cycles(imports: list[Import]) -> list[list[str]]:
    """Return the modules that import each other in a ring: of the first ring that is found."""
    graph: dict[str, set[str]] = {}
    for edge in imports:
        graph.setdefault(edge.importer, set()).add(edge.imported)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return [sorted(set(error.args[1]))]
    return []


@functools.cache
def all_imports() -> list[Import]:
    """Return every import between modules of ours."""
    known = modules()
    return [
        edge
        for name, path in known.items()
        for edge in imports_of(name, path.read_text(encoding="utf-8"), known)
    ]


def upward(imports: list[Import]) -> list[str]:
    """Return a line for each import that is against the layers."""
    return [
        f"{edge.importer}:{edge.line}: imports {edge.imported}: {why}"
        for edge in imports
        if (why := fault_of(edge)) is not None
    ]


def main() -> int:
    """Print layers, cycles and upward imports; return the exit code."""
    known, imports = modules(), all_imports()
    for rank, packages in enumerate(LAYERS):
        counted = (
            f"{package_name} ({sum(_layer_of(name) == package_name for name in known)})"
            for package_name in packages
        )
        print(f"layer {rank}: {', '.join(counted)}")
    for package, parts in PARTS.items():
        print(f"{package}: {' < '.join(', '.join(part) for part in parts)}")
    found_cycles, against = cycles(imports), upward(imports)
    print(f"{len(known)} modules, {len(imports)} imports between them")
    print(f"{len(found_cycles)} cycles")
    for group in found_cycles:
        print(f"  {', '.join(group)}")
    print(f"{len(against)} upward imports")
    for line in against:
        print(f"  {line}")
    return 1 if found_cycles or against else 0


if __name__ == "__main__":
    sys.exit(main())
