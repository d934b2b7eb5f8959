"""The progress of a goal: the bound of a number of its feedback, from the goal or the feedback."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

DONE_WORDS = {"current", "done", "elapsed", "completed", "travelled", "traveled", "so", "far"}
LEFT_WORDS = {"remaining", "left"}
PLAIN_WORDS = {"current", "count", "number", "total", "target", "goal", "desired", "max", "of"}


class ProgressBounds:
    """Finds the bound of each number of the feedback.

    The bound is, in this order: the sum with a field of the remaining amount (``current_angle`` and
    ``remaining_angle``); the goal's field of the same words (``current_image``, ``image_count``)
    and unit; the largest value so far, for a remaining amount. Otherwise there is no bound.

    Args:
        goal: The goal's fields by dotted name; fields that are not numbers are ignored.
        goal_units: Units of the goal's fields, where they are known.
        feedback_units: Units of the feedback's fields, where they are known.
    """

    def __init__(
        self,
        goal: Mapping[str, Any],
        goal_units: Mapping[str, str] | None = None,
        feedback_units: Mapping[str, str] | None = None,
    ) -> None:
        self._goal = {name: value for name, value in goal.items() if is_number(value)}
        self._goal_units = goal_units or {}
        self._units = feedback_units or {}
        self._most: dict[str, float] = {}

    def read(self, feedback: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
        """Each number that has a bound, with it: ``{"current_angle": (12.5, 90.0)}``."""
        numbers = {name: float(value) for name, value in feedback.items() if is_number(value)}
        bounds = {}
        for name, value in numbers.items():
            self._most[name] = max(self._most.get(name, 0.0), abs(value))
            bound = self._bound(name, numbers)
            if bound > 0:
                bounds[name] = (value, bound)
        return bounds

    def measure(self, feedback: Mapping[str, Any]) -> tuple[str, float, float] | None:
        """The progress of the goal: a field, its value, and its bound; None without a bound.

        Of several numbers with a bound, it is the first one that grows. A remaining amount counts
        as the part of its largest value that is done, under its name without that word:
        ``distance_remaining`` gives ``distance``.
        """
        left = None
        for name, (value, bound) in self.read(feedback).items():
            if not _words(name) & LEFT_WORDS:
                return name, abs(value), bound
            left = left or (_without_left(name), bound - abs(value), bound)
        return left

    def _bound(self, name: str, numbers: Mapping[str, float]) -> float:
        twin = _twin(name, numbers)
        if twin is not None:
            return abs(numbers[name]) + abs(numbers[twin])
        if _words(name) & LEFT_WORDS:
            return self._most[name]
        for other, value in self._goal.items():
            if self._is_same(name, other):
                return abs(float(value))
        return 0.0

    def _is_same(self, feedback: str, goal: str) -> bool:
        words, two = _words(feedback) - PLAIN_WORDS, _words(goal) - PLAIN_WORDS
        if not words or not two or not (words <= two or two <= words):
            return False
        unit, goal_unit = self._units.get(feedback, ""), self._goal_units.get(goal, "")
        return unit == goal_unit or not unit or not goal_unit


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _twin(name: str, numbers: Mapping[str, float]) -> str | None:
    words = _words(name)
    other_words = DONE_WORDS if words & LEFT_WORDS else LEFT_WORDS
    core = words - DONE_WORDS - LEFT_WORDS
    for other in numbers:
        theirs = _words(other)
        if other != name and theirs & other_words and theirs - DONE_WORDS - LEFT_WORDS == core:
            return other
    return None


def _without_left(name: str) -> str:
    """Return a field's name without the words for a remaining amount."""
    path, dot, last = name.rpartition(".")
    kept = [word for word in last.split("_") if word.lower() not in LEFT_WORDS]
    return f"{path}{dot}{'_'.join(kept)}" if kept else name


def _words(name: str) -> frozenset[str]:
    return frozenset(name.rpartition(".")[2].lower().split("_"))
