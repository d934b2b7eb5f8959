"""Behaviours that users write in Python, found by the name that a mission gives."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from bt_mission.core.diagnostics import did_you_mean, listed
from bt_mission.core.errors import HintedError
from bt_mission.language.expressions.values import Type

GROUP = "bt_mission.leaves"
"""The entry points by which a package names its behaviours."""


class PythonError(HintedError):
    """A behaviour of a user's that is not there, or cannot be used."""


def find_class(target: str, file: str) -> type[Behaviour]:
    """The class that a mission in ``file`` names.

    Args:
        target: ``module:Class``, ``file.py:Class`` (a file in the mission's folder or below), or
            the name of an entry point of the group ``bt_mission.leaves``.

    Raises:
        PythonError: When it is not there, is no behaviour, or its module cannot be imported.
    """
    where, _, name = target.partition(":")
    if not name:
        return _behaviour(_plugged(where), target)
    is_file = where.endswith(".py")
    with _importing(where if is_file else f"the module {where}"):
        module = _from_file(where, file) if is_file else importlib.import_module(where)
    if not hasattr(module, name):
        known = [key for key, value in vars(module).items() if _is_behaviour(value)]
        has = f"behaviours: {listed(known)}" if known else "it has no behaviours"
        raise PythonError(f"no '{name}' in {where} ({has})", did_you_mean(name, known))
    return _behaviour(getattr(module, name), target)


_KINDS: dict[type, Type] = {
    int: "integer",
    float: "number",
    bool: "bool",
    str: "text",
    list: "list",
}
_TYPES: dict[Any, Type] = {**_KINDS, **{kind.__name__: word for kind, word in _KINDS.items()}}
"""The types of annotations, evaluated or as texts."""


def attributes_of(kind: type[Behaviour]) -> dict[str, Type | None]:
    """The attributes that a behaviour declares on its class, and their types where it says them.

    Those of py_trees itself are left out, and what begins with an underscore.
    """
    found: dict[str, Any] = {}
    for one in reversed(kind.__mro__):
        if one is object or one.__module__.partition(".")[0] == "py_trees":
            continue
        annotated = inspect.get_annotations(one)
        found |= {name: annotated.get(name) for name in (*annotated, *vars(one))}
    callables = {name for name in found if callable(getattr(kind, name, None))}
    return {
        name: _TYPES.get(kind_of)
        for name, kind_of in found.items()
        if not name.startswith("_") and name not in callables
    }


def _plugged(name: str) -> Any:
    there = entry_points(group=GROUP)
    found = [one for one in there if one.name == name]
    if not found:
        known = sorted(one.name for one in there)
        has = f"known: {listed(known)}" if known else f"no package has any of '{GROUP}'"
        hint = did_you_mean(name, known) or "a class is written as 'module:Class'"
        raise PythonError(f"no plug-in is called '{name}' ({has})", hint)
    with _importing(f"the plug-in '{name}' ({found[0].value})"):
        return found[0].load()


def _from_file(where: str, file: str) -> Any:
    folder = Path(file).resolve().parent
    path = (folder / where).resolve()
    if not path.is_relative_to(folder):
        raise PythonError(f"{where} lies outside of the folder of the mission")
    if not path.is_file():
        raise PythonError(f"no such file: {where}", "it is looked for beside the mission")
    key = f"bt_mission_leaf_{path.with_suffix('').as_posix().strip('/').replace('/', '_')}"
    if key not in sys.modules:
        spec = importlib.util.spec_from_file_location(key, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[key] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[key]
            raise
    return sys.modules[key]


def _behaviour(found: Any, target: str) -> type[Behaviour]:
    if not _is_behaviour(found):
        raise PythonError(f"{target} is no class of a py_trees Behaviour")
    kind: type[Behaviour] = found
    return kind


def _is_behaviour(value: object) -> bool:
    return inspect.isclass(value) and issubclass(value, Behaviour) and value is not Behaviour


@contextmanager
def _importing(what: str) -> Iterator[None]:
    """Turn whatever a module of a user's raises into an error that says so."""
    try:
        yield
    except PythonError:
        raise
    except (Exception, SystemExit) as error:
        message = f"{what} cannot be imported: {type(error).__name__}: {error}"
        raise PythonError(message) from error
