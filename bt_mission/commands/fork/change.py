"""The change of a fork."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, listed, quoted
from bt_mission.base.text import seconds
from bt_mission.base.yaml.document import read_text
from bt_mission.executive.behaviours.builder import revise_tree
from bt_mission.language.checks.scope import written_by
from bt_mission.language.expressions.values import WORDS, Plain, fits, show, type_of
from bt_mission.language.inputs import SET_OPTION, overridden
from bt_mission.language.mission import Mission
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.scenarios.faults.planned import PlannedFault, WhenTrue

ROUNDING_S = 1e-6


@dataclass(frozen=True)
class ForkChange:
    """Takes effect at the control step of a fork, before the tree is ticked there.

    A running node keeps what it read when it started: variables and another version of the mission
    are read when a node starts, and by conditions at every tick.

    Args:
        values: Variables of the mission with their new values.
        edit: Another version of the mission.
        new_tree: Where the tree of that version is another one; it then runs from the start, and
            has to do the same as the recorded one up to the fork.
        is_revision: Whether that version has another tree, and the run is revised to it, since it
            was revised before.
        faults: What goes wrong besides what was recorded, as it is written.
    """

    values: Mapping[str, Plain] = field(default_factory=dict)
    edit: Mission | None = None
    new_tree: Diagnostic | None = None
    faults: tuple[str, ...] = ()
    is_revision: bool = False

    def __str__(self) -> str:
        names = [] if self.edit is None else [Path(self.edit.file).name]
        values = (f"{name}={show(value)}" for name, value in self.values.items())
        return ", ".join([*names, *values, *(f"'{fault}'" for fault in self.faults)])

    @property
    def is_none(self) -> bool:
        """Whether nothing is changed."""
        return not self.values and self.edit is None and not self.faults

    @property
    def is_from_start(self) -> bool:
        """Whether the other version runs from the start."""
        return self.new_tree is not None

    @property
    def is_applied(self) -> bool:
        """Whether the run is changed while it is under way, other than by faults."""
        return bool(self.values) or (self.edit is not None and not self.is_from_start)

    def as_dict(self) -> dict[str, Any]:
        """Return the change as JSON data."""
        edit = None if self.edit is None else self.edit.file
        return {
            "set": dict(self.values),
            "mission": edit,
            "from_start": self.is_from_start,
            "faults": list(self.faults),
        }

    def mission_of(self, recorded: Mission) -> Mission:
        """Return the mission with which the run begins."""
        if self.edit is None:
            return recorded
        if self.is_from_start:
            return self.edit
        return replace(recorded, requirements=self.edit.requirements)

    def apply(self, runner: MissionRunner) -> None:
        """Give the variables their values, and have the nodes go by the other version.

        Raises:
            InputError: Where a variable holds a value of another type.
            BtMissionError: The mission cannot be revised at that instant.
        """
        scope = runner.scope
        for name, value in self.values.items():
            wanted = type_of(scope.values.get(name))
            wanted = "number" if wanted == "integer" else wanted
            if wanted is not None and not fits(type_of(value), wanted):
                message = f"'{name}' is {WORDS[wanted]} at that instant"
                raise InputError([_diagnostic(name, value, message)])
        scope.values.update(self.values)
        if self.edit is not None and self.is_revision:
            revision = runner.revise(self.edit)
            if revision.is_refused:
                raise InputError(
                    [_diagnostic("mission", self.edit.file, reason) for reason in revision.reasons]
                )
        elif self.edit is not None and not self.is_from_start:
            revise_tree(self.edit, scope)


def values_of(mission: Mission, given: Iterable[tuple[str, str]]) -> dict[str, Plain]:
    """Return new values for variables of a mission, read as `--set` reads them.

    Raises:
        InputError: For a variable that the mission has not, or a value of another type.
    """
    followed = {topic.variable for topic in mission.follow}
    written = {name for node in mission.tree.walk() for name in written_by(node)} - followed
    known = [*mission.inputs, *sorted(written - mission.inputs.keys())]
    values: dict[str, Plain] = {}
    diagnostics = []
    for name, text in given:
        if name in mission.inputs:
            taken, wrong = overridden(mission.inputs, {name: text})
            values[name] = taken[name]
            diagnostics += wrong
        elif name in written:
            values[name] = _plain(text)
        elif name in followed:
            message = f"'{name}' follows a topic; only the topic changes it"
            diagnostics.append(_diagnostic(name, text, message))
        else:
            message = f"unknown variable {quoted(name)} (the mission's: {listed(known)})"
            diagnostics.append(_diagnostic(name, text, message, did_you_mean(name, known)))
    if diagnostics:
        raise InputError(diagnostics)
    return values


def refuse_earlier(faults: Iterable[PlannedFault], at_s: float) -> None:
    """Refuse faults that begin before a fork.

    Raises:
        InputError: With each of them.
    """
    wrong = []
    for fault in faults:
        begins = fault.begins
        if not isinstance(begins, WhenTrue) and begins.time_s < at_s - ROUNDING_S:
            message = f"it begins before the fork, which is at {seconds(at_s)}"
            wrong.append(fault.locate("BT-1004", message, None, str(begins.time_s)))
    if wrong:
        raise InputError(wrong)


def _plain(text: str) -> Plain:
    try:
        value: Any = read_text(text).data
    except InputError:
        return text
    return text if value is None or isinstance(value, dict) else value


def _diagnostic(name: str, value: object, message: str, hint: str | None = None) -> Diagnostic:
    return Diagnostic("BT-1004", message, SET_OPTION, 1, 1, f"{name}={value}", hint)
