"""Watches a condition while a mission runs: is it true now, and for how long has it been?"""

from __future__ import annotations

from bt_mission.language.requirements.formula import Condition, signals_in
from bt_mission.requirements.comparisons import Reader
from bt_mission.requirements.compiler import Compiler
from bt_mission.requirements.monitor import SignalSource


class ConditionMonitor:
    """Evaluates a condition at one control step after another.

    Args:
        source: Gives its signals.
        held_ns: For so long it has to be true without a break.

    Attributes:
        why_unknown: Why it cannot be evaluated here; empty where it can.
    """

    def __init__(self, condition: Condition, source: SignalSource, held_ns: int = 0) -> None:
        self._held_ns = held_ns
        self._since_ns: int | None = None
        readers: dict[str, Reader] = {}
        missing: list[str] = []
        for signal in signals_in(condition.root):
            found = source.reader(signal)
            if isinstance(found, str):
                missing.append(f"{signal.key}: {found}")
            else:
                readers[signal.key] = found
        self.why_unknown = "; ".join(missing)
        self._past = None if missing else Compiler(readers).condition(condition.root)

    def step(self, since_start_ns: int) -> bool:
        """Take the next instant; tell whether the condition has been true for long enough."""
        value = None if self._past is None else self._past.at(since_start_ns)
        if value is None or not value[1]:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = since_start_ns
        return since_start_ns - self._since_ns >= self._held_ns
