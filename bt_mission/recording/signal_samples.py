"""What requirements need to know at each control step, and no topic tells: a line for each step.

The lines of ``~/signals`` are JSON: ``t`` is the ROS time (ns) at which requirements were evaluated
or would have been, ``values`` those signals that have another value than in the line before, by
their text, and ``state`` the state of the simulation (base64), out of which the other true signals
follow. What stands before a line in the file had happened by then. The first line also has the
start of the mission (``start``, ns), the number of the step (``cycle``), and ``keys``, the signals
that every step is told of.
"""

from __future__ import annotations

import gzip
import json
from binascii import b2a_base64
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.requirements.formula import Formula, Requirement, signals_in
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.requirements.comparisons import Reader
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.sessions.stage_signals import OF_STATE

TOPIC = "signals"
COUNTED = ("collisions",)
"""True signals that do not follow from a simulation's state."""
REQUIREMENTS, SIMULATION = "requirements", "simulation"
"""The names of facts."""
MODEL_FILE, MODEL_TYPE = "simulation.mjb.gz", "application/gzip"

_ENCODER = json.JSONEncoder(separators=(",", ":"))
_KINDS = (bool, int, float, str, list)


class SignalSamples:
    """Samples a mission's signals at every control step.

    Args:
        runner: Whose mission it is.
        take: Takes each line.
        guarded: Makes what looks on harmless.
    """

    def __init__(
        self,
        runner: MissionRunner,
        take: Callable[[str], None],
        guarded: Callable[[Callable[[], None]], Callable[[], None]],
    ) -> None:
        self._runner = runner
        self._take = take
        self._sampler = guarded(self._sample)
        self._signals = runner.requirements.signals
        self._simulation = self._signals.simulation()
        self._last: dict[str, Any] = {}
        self._keys: list[str] = []
        self._readers: dict[str, Reader] = {}
        follows = {"$", "time", *(OF_STATE if self._simulation is not None else ())}
        for requirement in runner.mission.requirements:
            for signal in signals_in(requirement.root):
                found = self._signals.reader(signal)
                if not isinstance(found, str) and signal.name not in follows:
                    self._readers[signal.key] = found
        runner.requirements.add_sampler(self._sampler)

    def close(self) -> None:
        """Sample no more."""
        self._runner.requirements.remove_sampler(self._sampler)

    @property
    def facts(self) -> dict[str, str]:
        """What is to be told at the start."""
        found = {REQUIREMENTS: json.dumps(written(self._runner.mission.requirements))}
        if self._simulation is not None:
            found[SIMULATION] = json.dumps(self._simulation.facts)
        return found

    def attach_to(self, file: McapFile, time_ns: int) -> None:
        """Put the model of the simulation, if there is one, into a file."""
        if self._simulation is not None:
            file.attach(
                MODEL_FILE, MODEL_TYPE, gzip.compress(self._simulation.data, mtime=0), time_ns
            )

    def _sample(self) -> None:
        runner = self._runner
        state, truth = self._signals.truth()
        values: dict[str, Any] = {"open_goals": len(runner.ledger.open_goals)}
        for key, read in self._readers.items():
            values[key] = read()
        if not self._keys:
            self._keys = [*values, *(key for key in COUNTED if key in truth)]
        values |= truth
        for name, value in self._signals.variables():
            if isinstance(value, _KINDS):
                values[f"${name}"] = value
        # Put together by hand, since this happens at every step; most often only the state is new.
        line = f'{{"t":{runner.now_ns}'
        if not self._last:
            executive = runner.executive
            first = {"start": executive.started_ns, "cycle": executive.cycles, "keys": self._keys}
            line += "," + _ENCODER.encode(first)[1:-1]
        if values != self._last or self._readers:
            if changed := self._changed(values):
                line += f',"values":{_ENCODER.encode(changed)}'
            self._last = values
        if state:
            line += f',"state":"{b2a_base64(state, newline=False).decode("ascii")}"'
        self._take(line + "}")

    def _changed(self, values: Mapping[str, Any]) -> dict[str, Any]:
        last = self._last
        changed = {
            key: value
            for key, value in values.items()
            if key not in last or last[key] != value or type(last[key]) is not type(value)
        }
        return changed | dict.fromkeys(last.keys() - values.keys())


def written(requirements: Sequence[Requirement]) -> list[dict[str, str]]:
    """Return requirements as a recording holds them."""
    return [
        {"name": one.name, "formula": one.text, "on_violation": one.on_violation}
        for one in requirements
    ]


def requirements_in(file: RecordedFile) -> tuple[Requirement, ...]:
    """Return the requirements that a recorded run had.

    Raises:
        RecordingError: For one that cannot be read here.
    """
    found = []
    for one in file.facts.requirements:
        name, text = str(one.get("name", "?")), str(one.get("formula", ""))
        action = one.get("on_violation", "report")
        try:
            root = Formula(text).root
        except ExpressionError as error:
            raise RecordingError(
                f"{file.path}: its requirement '{name}' cannot be read here: {error.message}"
            ) from error
        found.append(
            Requirement(name, text, root, action if action in ("fail", "halt") else "report")
        )
    return tuple(found)
