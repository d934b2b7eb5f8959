"""The signals of requirements that no topic carries: a line for each control step.

The lines of ``~/signals`` are JSON. ``t`` is the ROS time (ns) at which requirements were evaluated
or would have been. ``values`` are the signals that have another value than in the line before, by
their text. ``state`` is the state of the simulation (base64), from which the other true signals
follow. Everything before a line in the file had happened by then. The first line also has the start
of the mission (``start``, ns), the number of the step (``cycle``), and ``keys``, the signals of
every step.
"""

from __future__ import annotations

import gzip
import json
from binascii import b2a_base64
from collections.abc import Callable, Mapping, Sequence
from operator import is_
from typing import Any, get_args

from bt_mission.base.verdicts import OnViolation
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Requirement
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.formula import Formula, root_of, signals_in
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.sessions.stage_signals import OF_STATE

TOPIC = "signals"
ACCEPTED_GOALS = "accepted_goals"
"""The key of the goals under way that their servers have accepted: a list of UUIDs."""
COUNTED = ("collisions",)
"""True signals that do not follow from a simulation's state."""
REQUIREMENTS, SIMULATION = "requirements", "simulation"
"""The names of facts."""
LEVEL = 6
"""Of gzip: takes a third of the time of the highest, for a file that is a twentieth larger."""
MODEL_FILE, MODEL_TYPE = "simulation.mjb.gz", "application/gzip"

_ENCODER = json.JSONEncoder(separators=(",", ":"))
_json = _ENCODER.encode
_PLAIN = (bool, int, float, str)


class SignalSamples:
    """Samples a mission's signals at every control step.

    Args:
        runner: The mission.
        take: Called with each line.
        guarded: Wraps a function so that its errors do not end the run.
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
        self._truth: dict[str, Any] = {}
        self._variables: dict[str, Any] = {}
        ledger = runner.ledger
        self._readers: dict[str, Reader] = {
            "open_goals": lambda: len(ledger.open_goals),
            ACCEPTED_GOALS: lambda: [goal.id.hex() for goal in ledger.open_goals if goal.accepted],
        }
        follows = {"$", "time", *(OF_STATE if self._simulation is not None else ())}
        for requirement in runner.mission.requirements:
            for signal in signals_in(root_of(requirement)):
                reader = self._signals.reader(signal)
                if not isinstance(reader, str) and signal.name not in follows:
                    self._readers[signal.key] = reader
        self._readings = [(key, _json(key), read) for key, read in self._readers.items()]
        runner.requirements.add_sampler(self._sampler)

    def close(self) -> None:
        """Sample no more."""
        self._runner.requirements.remove_sampler(self._sampler)

    @property
    def facts(self) -> dict[str, str]:
        """The facts at the start."""
        facts = {REQUIREMENTS: json.dumps(written(self._runner.mission.requirements))}
        if self._simulation is not None:
            facts[SIMULATION] = json.dumps(self._simulation.facts)
        return facts

    def attach_to(self, file: McapFile, time_ns: int) -> None:
        """Add the model of the simulation, if any, to a file."""
        if self._simulation is not None:
            file.attach(
                MODEL_FILE,
                MODEL_TYPE,
                gzip.compress(self._simulation.data, LEVEL, mtime=0),
                time_ns,
            )

    def _sample(self) -> None:
        runner = self._runner
        state, truth = self._signals.truth()
        variables = runner.scope.values
        # Built by hand, since this runs at every step; mostly only the state is new, and the
        # signals of each step.
        line = f'{{"t":{runner.now_ns}'
        if not self._last:
            executive = runner.executive
            counted = [key for key in COUNTED if key in truth]
            keys = [*self._readers, *(key for key in counted if key not in self._readers)]
            first = {"start": executive.started_ns, "cycle": executive.cycles, "keys": keys}
            line += "," + _json(first)[1:-1]
        if (
            self._last
            and truth == self._truth
            and variables == self._variables
            and all(map(is_, variables.values(), self._variables.values()))
        ):
            changed = self._new_readings()
        else:
            changed = self._all_that_is_new(truth, variables)
        if changed:
            line += f',"values":{{{changed}}}'
        if state:
            line += f',"state":"{b2a_base64(state, newline=False).decode("ascii")}"'
        self._take(line + "}")

    def _new_readings(self) -> str:
        """Read the signals of each step; return the changed ones, in JSON without its braces."""
        last = self._last
        changed = []
        for key, name, read in self._readings:
            value, known = read(), last[key]
            if value is not known and (value != known or type(value) is not type(known)):
                last[key] = value
                changed.append(f"{name}:{_json(value)}")
        return ",".join(changed)

    def _all_that_is_new(self, truth: Mapping[str, Any], variables: Mapping[str, Any]) -> str:
        """Return the changed signals of all, in JSON without its braces."""
        self._truth, self._variables = dict(truth), dict(variables)
        values: dict[str, Any] = {key: read() for key, read in self._readers.items()}
        values |= truth
        for name, value in variables.items():
            if _has_json(value):
                values[f"${name}"] = value
        changed, self._last = self._changed(values), values
        return _json(changed)[1:-1]

    def _changed(self, values: Mapping[str, Any]) -> dict[str, Any]:
        last = self._last
        changed = {
            key: value
            for key, value in values.items()
            if key not in last or last[key] != value or type(last[key]) is not type(value)
        }
        return changed | dict.fromkeys(last.keys() - values.keys())


def _has_json(value: Any) -> bool:
    """Return whether a variable can be recorded: a message, or a list of some, cannot."""
    if isinstance(value, list):
        return all(map(_has_json, value))
    return isinstance(value, _PLAIN)


def written(requirements: Sequence[Requirement]) -> list[dict[str, str]]:
    """Return requirements as a recording holds them."""
    return [
        {
            "name": requirement.name,
            "formula": requirement.text,
            "on_violation": requirement.on_violation,
        }
        for requirement in requirements
    ]


def requirements_in(file: RecordedFile) -> tuple[Requirement, ...]:
    """Return the requirements of a recorded run.

    Raises:
        RecordingError: A requirement cannot be read by this version.
    """
    formulas = []
    for requirement in file.facts.requirements:
        name, text = str(requirement.get("name", "?")), str(requirement.get("formula", ""))
        action = requirement.get("on_violation", "report")
        try:
            Formula(text)
        except ExpressionError as error:
            raise RecordingError(
                f"{file.path}: its requirement '{name}' cannot be read here: {error.message}"
            ) from error
        formulas.append(
            Requirement(name, text, action if action in get_args(OnViolation) else "report")
        )
    return tuple(formulas)
