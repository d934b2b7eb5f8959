"""The variables that are known at a step of a mission, and of what type."""

from __future__ import annotations

import random
from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass, field

from bt_mission.core.diagnostics import did_you_mean, listed
from bt_mission.language.expressions.expression import Expression, Value
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.values import ExpressionError, Plain, Type, joined, type_of


@dataclass
class Variables:
    """The names known at one step. It changes as the file is walked: use it at once."""

    inputs: Mapping[str, Plain]
    types: MutableMapping[str, Type | None]
    lines: Mapping[str, int]
    given: frozenset[str] = frozenset()
    """The inputs of this tree, which nobody writes."""
    loops: dict[str, int] = field(default_factory=dict)
    """Variables that a `for_each` around this step goes through, with its line."""
    left: dict[str, int] = field(default_factory=dict)
    """Those of a `for_each` that has ended, with its line."""

    def note(self, name: str, found: Type | None) -> None:
        """Take in that a variable is written; where writers disagree, its type is not known."""
        self.types[name] = joined({self.types.get(name, found), found})

    def type_of(self, value: Value) -> Type | None:
        """Return the type of a value, as far as it is known."""
        if not isinstance(value, Expression):
            return type_of(value)
        try:
            return value.infer(lambda name: self.types.get(name.name))
        except ExpressionError:
            return None

    def element_type(self, elements: Value) -> Type | None:
        """Return the type that all elements of a list have; None where that is not known."""
        if isinstance(elements, Expression) and self.fixes(elements.names) and not elements.draws:
            try:
                elements = elements.evaluate(self.inputs, random.Random(0))
            except ExpressionError:
                return None
        if not isinstance(elements, list):
            return None
        return joined({type_of(one) for one in elements})

    def fixed(self, name: str) -> str | None:
        """Return why a variable cannot be written here, or None."""
        if name in self.given:
            return f"'{name}' is an input, and inputs never change; choose another name"
        if name in self.loops:
            line = self.loops[name]
            return f"'{name}' is what the for_each in line {line} goes through; choose another name"
        return None

    def unknown(self, name: Name) -> tuple[str, str | None] | None:
        """Return what is wrong with a name that is not known here, and a hint, or None."""
        if name.name in self.types:
            return None
        if name.name in self.left:
            return f"is known only inside the for_each in line {self.left[name.name]}", None
        if name.name in self.lines:
            return f"is only written later, in line {self.lines[name.name]}", None
        why = f"is written by nothing (known here: {listed(self.types)})"
        return why, did_you_mean(name.name, [*self.types, "true", "false"])

    def fixes(self, names: frozenset[str]) -> bool:
        """Return whether these names have the same values in every run of this mission."""
        return names <= self.inputs.keys()
