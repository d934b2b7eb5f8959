"""Python files of a user: loaded from their folder, with the modules that lie beside them.

``import helper`` finds ``helper.py`` in the folder of the file, as ``python FILE`` does, also
within a function that runs later. Each folder is a package with its own name, so two folders may
have a ``helper`` each, and ``sys.path`` stays as it is.
"""

from __future__ import annotations

import ast
import importlib.util
import os
import sys
from collections.abc import Iterator
from hashlib import sha256
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from typing_extensions import override

from bt_mission.base.files import contents_of
from bt_mission.base.user_loops import LoopLoader

_INSTALLED = ("site-packages", "dist-packages")


def load_file(path: Path) -> ModuleType:
    """Return the module of a file, which is imported once.

    Raises:
        BaseException: Whatever its code raises.
    """
    package = _package_of(path.parent)
    name = f"{package}.{path.stem.replace('.', '_')}"
    if name not in sys.modules:
        loader = _Loader(name, str(path), package, path.parent)
        spec = importlib.util.spec_from_file_location(name, path, loader=loader)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


def _package_of(folder: Path) -> str:
    """Return the name of the package that stands for a folder, with its finder."""
    name = f"bt_mission_leaf_{sha256(os.fsencode(folder)).hexdigest()[:16]}"
    if name not in sys.modules:
        module = ModuleType(name)
        module.__path__ = [str(folder)]
        sys.modules[name] = module
        sys.meta_path.insert(0, _Finder(name, folder))
    return name


class _Finder:
    """Finds the modules of one folder, and of the packages in it."""

    def __init__(self, package: str, folder: Path) -> None:
        self._package, self._folder = package, folder

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Return the file of a module of this folder."""
        below = name.removeprefix(f"{self._package}.")
        if below == name:
            return None
        place = self._folder.joinpath(*below.split("."))
        file = next(filter(Path.is_file, _forms(place)), None)
        if file is None:
            return None
        loader = _Loader(name, str(file), self._package, self._folder)
        folders = [str(place)] if file.parent == place else None
        return importlib.util.spec_from_file_location(
            name, file, loader=loader, submodule_search_locations=folders
        )


def _forms(place: Path) -> tuple[Path, Path]:
    """Return the files that a module may have: that of a package, and its own."""
    return place / "__init__.py", place.with_name(f"{place.name}.py")


class _Loader(LoopLoader):
    """Compiles a file whose imports of modules beside it lead into its package."""

    def __init__(self, name: str, file: str, package: str, folder: Path) -> None:
        super().__init__(name, file)
        self._imports = _Imports(package, folder)

    @override
    def changed(self, tree: ast.Module) -> ast.Module:
        changed: ast.Module = self._imports.visit(tree)
        return changed


class _Imports(ast.NodeTransformer):
    """Puts the name of the package before that of a module in its folder."""

    def __init__(self, package: str, folder: Path) -> None:
        self._package, self._folder = package, folder

    def visit_Import(self, node: ast.Import) -> Any:
        """``import a.b`` binds ``a``, and ``import a.b as c`` binds ``a.b``."""
        lines: list[ast.stmt] = []
        for alias in node.names:
            if not self._is_beside(alias.name):
                lines.append(ast.Import([alias]))
                continue
            parent, _, last = f"{self._package}.{alias.name}".rpartition(".")
            if alias.asname:
                lines.append(ast.ImportFrom(parent, [ast.alias(last, alias.asname)], 0))
                continue
            top = alias.name.partition(".")[0]
            if top != alias.name:  # loads it; the name that this binds is that of our package
                lines.append(ast.ImportFrom(parent, [ast.alias(last, "_")], 0))
            lines.append(ast.ImportFrom(self._package, [ast.alias(top)], 0))
        return [ast.fix_missing_locations(ast.copy_location(line, node)) for line in lines]

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.ImportFrom:
        """``from a import b``; relative imports stay."""
        if not node.level and node.module and self._is_beside(node.module):
            node.module = f"{self._package}.{node.module}"
        return node

    def _is_beside(self, module: str) -> bool:
        return _place_beside(module, self._folder) is not None


def _place_beside(module: str, folder: Path) -> Path | None:
    """Return the file of a module in a folder; what Python has or is installed comes first."""
    top, *below = module.split(".")
    if top in sys.stdlib_module_names or not any(map(Path.is_file, _forms(folder / top))):
        return None
    spec = importlib.util.find_spec(top)
    if spec is not None and any(part in str(spec.origin) for part in _INSTALLED):
        return None
    forms = _forms(folder.joinpath(top, *below))
    return next(filter(Path.is_file, forms), _forms(folder / top)[0])


def files_beside(path: Path) -> Iterator[Path]:
    """Yield the files of modules in its folder that a file imports, and that they import."""
    seen, waiting = {path}, [path]
    while waiting:
        file = waiting.pop()
        try:
            tree = ast.parse(contents_of(file), str(file))
        except (OSError, SyntaxError, ValueError):  # reported where the file is imported
            continue
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            for name in names:
                place = _place_beside(name, path.parent)
                if place is not None and place.is_file() and place not in seen:
                    seen.add(place)
                    waiting.append(place)
                    yield place
