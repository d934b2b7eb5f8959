"""Names of a package that are loaded when they are first used (PEP 562)."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def lazy_names(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package.

    Args:
        package: Its name.
        modules: Each public name with the module that defines it; ``module:name`` where it has
            another name there.
    """

    def __getattr__(name: str) -> Any:  # noqa: N807 - it becomes that of the package
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, defined = modules[name].partition(":")
        value = getattr(importlib.import_module(module), defined or name)
        setattr(sys.modules[package], name, value)
        return value

    return __getattr__
