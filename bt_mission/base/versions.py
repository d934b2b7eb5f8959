"""Versions of the packages that a run depends on."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("bt-mission", "ros-jazzy-rclpy", "mujoco", "py-trees", "numpy", "mcap")


@cache
def versions() -> dict[str, str]:
    """Return the versions of packages, Python and machine; ``?`` for a missing one."""
    known = {"python": platform.python_version(), "machine": platform.machine()}
    for name in PACKAGES:
        try:
            known[name] = version(name)
        except PackageNotFoundError:
            known[name] = "?"
    return known
