"""The declaration of a node's ROS parameters: default, limits, description.

Parameters that belong together are the fields of a frozen dataclass, made by `number` and `text`.
Its `PREFIX`, if it has one, comes before the names of its own fields, not of inherited ones.
Parameters whose limits depend on the robot are single specs by name.
`executors.process` declares both.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, TypeAlias

Default: TypeAlias = bool | int | float | str


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One parameter: a text, a switch, or a number from `low` to `high`, both included.

    The type is that of the default. A text is one of `choices`, or any but an empty one without
    choices. Unless `is_fixed`, it may be set while the node runs.
    """

    default: Default
    description: str
    low: float = 0.0
    high: float = 0.0
    choices: tuple[str, ...] = ()
    is_fixed: bool = True

    @property
    def constraint(self) -> str:
        """The choices as text; empty without any."""
        if len(self.choices) == 2:
            return " or ".join(self.choices)
        return f"one of {', '.join(self.choices)}" if self.choices else ""

    def why_invalid(self, name: str, value: str) -> str | None:
        """Return why a text is invalid for the parameter of that name, or None."""
        if not value:
            return f"{name} must be a text, got {value!r}"
        if self.choices and value not in self.choices:
            return f"{name} must be {self.constraint}, got '{value}'"
        return None


def number(
    default: float, limits: tuple[float, float], description: str, *, is_fixed: bool = False
) -> Any:
    """Return a field of a dataclass that is a number, or a switch, as a parameter.

    Unless `is_fixed`, it may be set while the node runs, and holds from the next goal on.
    """
    spec = ParameterSpec(default, description, *limits, is_fixed=is_fixed)
    return field(default=default, metadata={"spec": spec})


def text(name: str, default: str, description: str, choices: tuple[str, ...] = ()) -> Any:
    """Return a field of a dataclass for a text parameter with its own name."""
    spec = ParameterSpec(default, description, choices=choices)
    return field(default=default, metadata={"spec": spec, "name": name})


def specs(declared: Any) -> dict[str, tuple[str, ParameterSpec]]:
    """Return name and spec of the parameter of each field of a dataclass that has one."""
    kind = declared if isinstance(declared, type) else type(declared)
    prefixes = {
        name: vars(base).get("PREFIX", "")
        for base in reversed(kind.__mro__)
        for name in vars(base).get("__annotations__", ())
    }
    return {
        field.name: (
            prefixes[field.name] + field.metadata.get("name", field.name),
            field.metadata["spec"],
        )
        for field in fields(declared)
        if "spec" in field.metadata
    }
