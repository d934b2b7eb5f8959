"""Versions of the packages that a run depends on."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("bt-mission", "ros-jazzy-rclpy", "mujoco", "py-trees", "numpy", "mcap")


@cache
def versions() -> dict[str, str]:
    """Versions of these packages, of Python and of the machine; ``?`` for a missing one."""
    known = {"python": platform.python_version(), "machine": platform.machine()}
    for name in PACKAGES:
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "?"
    return known
