"""Named places on the map: those of a mission, and the zones of its world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from typing_extensions import override

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.language.expressions.expression import Expression, Text
from bt_mission.language.expressions.syntax import (
    Constant,
    EvaluationScope,
    Name,
    SyntaxNode,
    Types,
    Unary,
)
from bt_mission.language.expressions.values import ExpressionError, LooseText, Plain, Type

Pose: TypeAlias = tuple[float, float, float]
"""X (m), y (m) and yaw (deg) in the map."""

_ZONE = "zone "


class AnyPlace(dict[str, Pose]):
    """The zones of a world that is not known here: it may have a place of any name."""

    def get(self, _name: str, _default: Any = None) -> Pose:
        """Return a pose that stands for one that is not known."""
        return 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Places:
    """Looks up places by name; a zone is also found as `zone NAME`.

    Args:
        own: Those of the mission, which come before zones.
        find_zones: Gives those of its world; asked when a goal names a place for the first time.
    """

    own: Mapping[str, Pose] = field(default_factory=dict)
    find_zones: Callable[[], Mapping[str, Pose]] = dict
    has_world: bool = True
    """Whether the mission names a world."""

    @cached_property
    def all(self) -> Mapping[str, Pose]:
        """Every place by its name."""
        return {**self.find_zones(), **self.own}

    def find(self, text: str) -> Pose | None:
        """Return the place that a text names, or None."""
        text = text.strip()
        zone = text.removeprefix(_ZONE).strip()
        return self.all.get(text) or self.all.get(zone) or self.find_zones().get(text)

    def unknown(self, text: str, column: int = 1) -> ExpressionError:
        """Return the error for a text that names no place."""
        if not self.all:
            zones = "its world no zones" if self.has_world else "names no world"
            message = f"unknown place {quoted(text)}: the mission has no 'places' and {zones}"
            head = "" if self.has_world else "'world: NAME' at its head, or "
            remedy = f"write {head}a pose: [x m, y m, yaw deg]"
            return ExpressionError("BT-308", message, column, remedy)
        hint = did_you_mean(text.strip().removeprefix(_ZONE), self.all)
        return ExpressionError(
            "BT-308", f"unknown place {quoted(text)} (places: {listed(self.all)})", column, hint
        )


@dataclass(frozen=True)
class PlaceLookup(Unary):
    """An expression for a pose, the name of a place, or a list of these for a field with many."""

    places: Places

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        pose: Plain = self._pose(self.operand.evaluate(scope))
        return pose

    @override
    def infer(self, types: Types) -> Type | None:
        kind = self.operand.infer(types)
        return "list" if kind == "text" else kind

    def _pose(self, value: Plain) -> Any:
        if isinstance(value, str):
            pose = self.places.find(value)
            if pose is None:
                raise self.places.unknown(value, self.column)
            return list(pose)
        return [self._pose(item) for item in value] if isinstance(value, list | tuple) else value


def with_places(text: Text, places: Places) -> Text:
    """Return a text for a field that holds a pose, with the names of places in it looked up."""
    pose = places.find(text.text)
    expression = text.expression
    if pose is not None:
        return text.reading(Expression.of(text.text, Constant(1, list(pose))))
    if isinstance(expression, Expression):
        root = PlaceLookup(expression.root.column, expression.root, places)
        return text.reading(Expression.of(expression.text, root, expression))
    if isinstance(expression, LooseText) and text.text[:1].isalpha():
        return text.reading(places.unknown(text.text))
    return text


def place_of(root: SyntaxNode) -> tuple[Name, Places] | None:
    """Return the bare name that should be a place, with the places that there are."""
    if isinstance(root, PlaceLookup) and isinstance(root.operand, Name):
        return root.operand, root.places
    return None
