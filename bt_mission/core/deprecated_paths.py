"""Import paths of earlier releases that the documentation named; they go with the next release."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

MOVED: Mapping[str, Mapping[str, str]] = {
    "bt_mission.lockstep": {"LockstepExecutor": "bt_mission.virtual_time.VirtualTimeExecutor"},
    "bt_mission.mission": {"load": "bt_mission.load", "load_text": "bt_mission.load_text"},
    "bt_mission.mission.short_names": {"ShortName": "bt_mission.ActionName"},
    "bt_mission.node": {"MissionNode": "bt_mission.MissionNode"},
    "bt_mission.recording.recorder": {"Recorder": "bt_mission.recording.writer.RunRecorder"},
    "bt_mission.ros_types": {"shapes": "bt_mission.ros.interface_types.shapes"},
    "bt_mission.stage": {"Stage": "bt_mission.Stage"},
    "bt_mission.testing.drawn": {},
    "bt_mission.testing.drawn.strategies": {
        "scenarios": "bt_mission.testing.generators.strategies.scenarios"
    },
    "bt_mission.tree": {},
    "bt_mission.tree.ports": {"port_leaves": "bt_mission.port_leaves"},
}
"""Each module of an earlier release, with its names and where they are now."""


class _MovedModules:
    """Finds modules that exist no longer, and hands on what they had.

    It has the methods of a finder and a loader, not the classes: to import these takes longer than
    the rest of the package.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a module of an earlier release."""
        del path, target
        if fullname not in MOVED:
            return None
        return ModuleSpec(
            fullname,
            self,  # type: ignore[arg-type]  # a loader by its methods
            is_package=any(n.startswith(f"{fullname}.") for n in MOVED),
        )

    def create_module(self, spec: ModuleSpec) -> None:
        """Have Python make the module, as it makes any other."""
        del spec

    def exec_module(self, module: ModuleType) -> None:
        """Give the module its names; each warns when it is used."""
        old = module.__name__

        def __getattr__(name: str) -> Any:  # noqa: N807 - it becomes that of the module
            if name not in MOVED[old]:
                raise AttributeError(f"module {old!r} has no attribute {name!r}")
            new = MOVED[old][name]
            warnings.warn(
                f"{old}.{name} is deprecated and goes with the next release: use {new}",
                DeprecationWarning,
                stacklevel=2,
            )
            place, _, renamed = new.rpartition(".")
            return getattr(import_module(place), renamed)

        module.__getattr__ = __getattr__  # type: ignore[method-assign]  # PEP 562


def install() -> None:
    """Let the old paths be imported, after everything that exists."""
    if not any(isinstance(finder, _MovedModules) for finder in sys.meta_path):
        sys.meta_path.append(_MovedModules())
