"""Behaviours and nodes that users write in Python, found by the name that a mission gives."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.entry_points import entry_points
from bt_mission.base.errors import HintedError, described
from bt_mission.base.user_files import load_file
from bt_mission.language.expressions.values import Type
from bt_mission.language.permissions import is_within

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from py_trees.behaviour import Behaviour

GROUP = "bt_mission.leaves"
"""The entry points by which a package names its behaviours."""


class PythonError(HintedError):
    """A user's Python code that is not there, or cannot be used."""


def find_class(target: str, file: str) -> type[Behaviour]:
    """The class of a behaviour that a mission in ``file`` names; its module is imported.

    Args:
        target: ``module:Class``, ``file.py:Class`` (a file in the mission's folder or below), or
            the name of an entry point of the group ``bt_mission.leaves``.
        file: The mission's.

    Raises:
        PythonError: When it is not there, is no behaviour, or its module cannot be imported.
    """
    where, _, name = target.partition(":")
    if not name:
        return _behaviour(_plugged(where), target)
    return _behaviour(_member(where, name, file, _is_behaviour, "behaviours"), target)


def program_of(target: str) -> list[str]:
    """Return the program that ``nodes`` names, and its arguments; empty for a factory."""
    words = words_of(target)
    return words if words and (words[0].endswith(".py") or ":" not in words[0]) else []


def words_of(line: str) -> list[str]:
    """Split a file and its arguments as a shell does.

    Raises:
        PythonError: A quotation has no end.
    """
    try:
        return shlex.split(line)
    except ValueError as error:
        raise PythonError("BT-215", f"the arguments cannot be read: {error}") from error


def parts_of(target: str) -> tuple[str, str]:
    """Return the file or module of a target, and the name in it; that of a program is empty."""
    program = program_of(target)
    where, _, name = target.partition(":")
    return (program[0], "") if program else (where, name)


@dataclass(frozen=True)
class FoundProgram:
    """A program that is there.

    Attributes:
        file: Its code, absolute.
        arguments: After its name on the command line.
        module: Its module, if that is installed; empty for a file.
        function: What a console script calls; empty for code that runs as ``__main__``.
    """

    file: Path
    arguments: list[str]
    module: str = ""
    function: str = ""


def find_program(target: str, file: str) -> FoundProgram:
    """Return the program that another file names; nothing is imported.

    Args:
        target: A file in the folder of `file` or below, a module, or a console script of an
            installed package, with its arguments.

    Raises:
        PythonError: It does not exist, is no Python file, or is for ROS 1.
    """
    program = program_of(target)
    if not program:
        raise _no_program(target)
    where, *arguments = program
    module, function = "", ""
    if where.endswith(".py"):
        path = _leaf_file(where, file)
    else:
        scripts = entry_points("console_scripts", where)
        module, _, function = next((each.value for each in scripts), where).partition(":")
        path = _module_file(module, where)
    code = path.read_bytes()
    try:
        tree = ast.parse(code, where)
    except (SyntaxError, ValueError) as error:
        if _IMPORTS_ROSPY.search(code):  # with the syntax of Python 2
            raise _for_ros_1(where) from error
        raise PythonError("BT-215", f"{where} {_why(error)}") from error
    imported = {
        name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
        )
    }
    if "rospy" in imported:
        raise _for_ros_1(where)
    return FoundProgram(path, arguments, module, function)


_IMPORTS_ROSPY = re.compile(rb"^\s*(import|from)\s+rospy\b", re.MULTILINE)


def _for_ros_1(where: str) -> PythonError:
    hint = "port it to rclpy, the library of ROS 2"
    return PythonError("BT-215", f"{where} is a program for ROS 1: it imports rospy", hint)


def called_program(words: Sequence[str]) -> FoundProgram:
    """Return the program that a command line calls, in any folder.

    Raises:
        PythonError: As :func:`find_program`.
    """
    where, *arguments = words or [""]
    path = Path(os.path.realpath(where))
    is_file = where.endswith(".py")
    if is_file and not path.is_file():
        hint = None if Path(where).is_absolute() else f"it is looked for in {Path.cwd()}"
        raise PythonError("BT-215", f"no such file: {where}", hint)
    return find_program(
        shlex.join([path.name if is_file else where, *arguments]), str(path.parent / "called")
    )


def _module_file(module: str, where: str) -> Path:
    """Return the file that ``python -m`` runs; no package is imported for that."""
    first, *rest = module.split(".")
    spec = find_spec(first) if first.isidentifier() else None
    if spec is not None and spec.submodule_search_locations is None and not rest and spec.origin:
        return Path(spec.origin)
    for folder in (spec and spec.submodule_search_locations) or ():
        inside = Path(folder, *rest)
        for path in (inside.with_suffix(".py"), inside / "__main__.py"):
            if path.is_file():
                return path
    raise _no_program(where)


def _no_program(where: str) -> PythonError:
    return PythonError(
        "BT-215",
        f"expected a Python file, an installed module or console script, got {quoted(where)}",
        "a file ends with .py; install the package, or source its workspace",
    )


def find_factory(target: str, file: str) -> Callable[..., Any]:
    """The function or class that a file names as a factory of nodes; its module is imported.

    Args:
        target: ``module:name`` or ``file.py:name`` (a file in the folder of `file` or below).
        file: The file that names it.

    Raises:
        PythonError: When it is not there, cannot be called, or its module cannot be imported.
    """
    where, _, name = target.partition(":")
    function: Callable[..., Any] | object = _member(
        where, name, file, callable, "functions or classes"
    )
    if not callable(function):
        raise PythonError(
            "BT-215",
            f"{target} is neither a function nor a class",
            "it has to return an rclpy node",
        )
    return function


def _member(where: str, name: str, file: str, is_wanted: Callable[[Any], bool], wanted: str) -> Any:
    is_file = where.endswith(".py")
    module = _from_file(where, _leaf_file(where, file)) if is_file else _imported(where)
    if not hasattr(module, name):
        known = [
            key
            for key, value in vars(module).items()
            if is_wanted(value) and not key.startswith("_")
        ]
        has = f"{wanted}: {listed(known)}" if known else f"it has no {wanted}"
        raise PythonError("BT-215", f"no '{name}' in {where} ({has})", did_you_mean(name, known))
    return getattr(module, name)


def locate(
    target: str, file: str, folders: tuple[Path, ...] | None, *, is_node: bool = False
) -> None:
    """Look for the code that a mission in ``file`` names, as far as that goes without importing.

    Args:
        target: As for `find_class`.
        file: The mission's.
        folders: Where files of leaves may lie, links followed; modules are refused then. None is
            the folder of the mission, and any module.
        is_node: Whether it makes nodes, and is no leaf.

    Raises:
        PythonError: For an entry point or a file that is not there, or is not allowed.
    """
    where, name = parts_of(target)
    if not name and not where.endswith(".py"):
        if is_node:
            find_program(target, file)
        else:
            _entry_point(where)
        if folders is not None and is_node:
            raise PythonError("BT-216", f"the program {quoted(where)} must not be run here")
    elif where.endswith(".py"):
        path = _leaf_file(where, file)
        if folders is not None and not is_within(path, folders):
            raise PythonError("BT-216", f"{where} is outside the folders of missions")
    elif folders is not None:
        hint = f"put it in a file beside the mission, and write 'file.py:{name}'"
        raise PythonError("BT-216", f"the module {quoted(where)} must not be imported here", hint)


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
    members: dict[str, Any] = {}
    for base in reversed(kind.__mro__):
        if base is object or base.__module__.partition(".")[0] == "py_trees":
            continue
        annotated = inspect.get_annotations(base)
        members |= {name: annotated.get(name) for name in (*annotated, *vars(base))}
    callables = {name for name in members if callable(getattr(kind, name, None))}
    return {
        name: _TYPES.get(kind_of)
        for name, kind_of in members.items()
        if not name.startswith("_") and name not in callables
    }


def _entry_point(name: str) -> EntryPoint:
    there = entry_points(GROUP)
    matching = [entry_point for entry_point in there if entry_point.name == name]
    if not matching:
        known = sorted(entry_point.name for entry_point in there)
        has = f"known: {listed(known)}" if known else f"no package provides '{GROUP}'"
        hint = did_you_mean(name, known) or "a class is written as 'module:Class'"
        raise PythonError("BT-215", f"unknown plug-in '{name}' ({has})", hint)
    return matching[0]


def _plugged(name: str) -> Any:
    entry_point = _entry_point(name)
    try:
        return entry_point.load()
    except (Exception, SystemExit) as error:
        raise PythonError(
            "BT-215", f"the plug-in '{name}' ({entry_point.value}) {_why(error)}"
        ) from error


def _imported(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except (Exception, SystemExit) as error:  # whatever a user's module raises
        raise PythonError("BT-215", f"the module {module} {_why(error)}") from error


def _leaf_file(where: str, file: str) -> Path:
    folder = Path(file).resolve().parent
    path = (folder / where).resolve()
    if not path.is_relative_to(folder):
        raise PythonError("BT-216", f"{where} is outside the folder of the mission")
    if not path.is_file():
        raise PythonError("BT-215", f"no such file: {where}", "expected it beside the mission")
    return path


def _from_file(where: str, path: Path) -> Any:
    try:
        return load_file(path)
    except (Exception, SystemExit) as error:  # whatever a user's module raises
        raise PythonError("BT-215", f"{where} {_why(error)}") from error


def _behaviour(member: Any, target: str) -> type[Behaviour]:
    if not _is_behaviour(member):
        raise PythonError("BT-215", f"{target} is not a subclass of py_trees' Behaviour")
    kind: type[Behaviour] = member
    return kind


def _is_behaviour(value: object) -> bool:
    from py_trees.behaviour import Behaviour  # noqa: PLC0415 - missions with leaves are rare

    return inspect.isclass(value) and issubclass(value, Behaviour) and value is not Behaviour


def _why(error: BaseException) -> str:
    return f"cannot be imported: {described(error, '')}"
