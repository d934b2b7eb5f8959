"""Whose code a file is: ours, a library's, or that of the user."""

from __future__ import annotations

import sysconfig
from functools import lru_cache
from pathlib import Path

_DEBUGGERS = ("bdb", "pdb")
_OURS = ("bt_mission", "sim", "action_servers")
_CALLERS = (
    "rclpy/task.py",
    "rclpy/executors.py",
    "rclpy/action/server.py",
    "rclpy/action/client.py",
    "py_trees/behaviour.py",
    "bt_mission/ros/executors/callbacks.py",
    "bt_mission/executive/behaviours/python_leaf.py",
    "bt_mission/ros/virtual_time/execute_callbacks.py",
)
"""The modules that call callbacks, also those of installed packages."""

_MESSAGES = ("msg", "srv", "action")
"""The folders of generated classes, which rclpy calls, too."""


_HERE = Path(__file__).resolve().parents[2]


def is_ours(file: str) -> bool:
    """Return whether a file is one of this project, also a module that calls callbacks."""
    return any(Path(file).is_relative_to(_HERE / name) for name in _OURS)


@lru_cache(maxsize=4096)
def owner_of(file: str) -> str:
    """Return whose code a file is: caller, ours, debugger, library, package, or user."""
    if file.startswith("<"):
        return "library"
    if file.endswith(_CALLERS):
        return "caller"
    path = Path(file)
    if is_ours(file):
        return "ours"
    if "site-packages" in path.parts or "dist-packages" in path.parts:
        return "library" if path.parent.name in _MESSAGES else "package"
    if path.is_relative_to(sysconfig.get_path("stdlib")):
        return "debugger" if path.stem in _DEBUGGERS else "library"
    return "user"
