"""Ranges of variation: files of ranges for `sweep` and `falsify`, and the option ``--vary``."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import ConfigDict, Field, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    describe,
    did_you_mean,
    in_order,
    quoted,
)
from bt_mission.base.files import look_for, names
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.base.yaml.models import validate
from bt_mission.language.expressions.values import Plain
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import Written
from bt_mission.language.schema import DIALECT
from bt_mission.requirements.checks import MissionNames
from bt_mission.requirements.language.written import WrittenFormula
from bt_mission.scenarios.faults.drawing import unknown_kind
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.scenarios.written_faults import FaultReader
from bt_mission.sessions.check import has_camera
from bt_mission.sessions.file_checks import Checked, CheckedFile
from sim.world.world import FASTEST

EXAMPLES = "'speed=0.1,0.2' or 'speed=0.1..0.26'"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(
    rf"\s*(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER})\s*(?:step\s+(?P<step>{_NUMBER})\s*)?"
)
_COLON = re.compile(r"\s*([+-]?[\d.]+):([+-]?[\d.]+)\s*")
_DIGITS = 6
_MOST_STEPS = 1_000


# ---- parameters -------------------------------------------------------------------------------

_OPTION = Diagnostic("BT-708", "", "--vary", 1, 1)


@dataclass(frozen=True)
class ValueChoice:
    """A parameter with one of several values.

    Attributes:
        name: ``world``, ``robot``, ``start.x``, ``start.y``, ``start.yaw``, or an input.
        values: As YAML reads them.
        place: Its place, for errors.
    """

    name: str
    values: tuple[Plain, ...]
    place: Diagnostic = field(default=_OPTION, compare=False)

    def at(self, share: float) -> Plain:
        """The value at a share from 0 to below 1 of the way through."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]

    @property
    def ends(self) -> tuple[Plain, ...]:
        """Values that must be possible, so that all are."""
        return self.values

    def __str__(self) -> str:
        return f"{self.name}={','.join(map(str, self.values))}"


@dataclass(frozen=True)
class Interval:
    """A parameter with any value between two, both included.

    Attributes:
        name: See :class:`ValueChoice`, as for `place`.
        low: In the parameter's unit, as `high`.
        is_whole: Only whole numbers.
    """

    name: str
    low: float
    high: float
    is_whole: bool = False
    place: Diagnostic = field(default=_OPTION, compare=False)

    def at(self, share: float) -> Plain:
        """The value at a share from 0 to below 1 of the way, of six digits."""
        if self.is_whole:
            low, high = int(self.low), int(self.high)
            return min(low + int(share * (high - low + 1)), high)
        value = self.low + share * (self.high - self.low)
        return min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)

    @property
    def ends(self) -> tuple[Plain, ...]:
        """Values that must be possible, so that all are."""
        return (self.at(0.0), self.at(1.0))

    def __str__(self) -> str:
        return f"{self.name}={self.low:g}..{self.high:g}"


Parameter: TypeAlias = ValueChoice | Interval


def parse_parameter(text: str) -> Parameter:
    """Read a parameter as the command line has it, such as ``speed=0.1,0.2`` or ``speed=0.1..0.3``.

    Values are those of a YAML list without its brackets, or a range as in a file.

    Raises:
        InputError: With what is wrong with it.
    """
    place = replace(_OPTION, source=text)
    name, equals, written = (part.strip() for part in text.partition("="))
    if not equals or not name:
        message = f"expected NAME=VALUES, such as {EXAMPLES}"
        raise InputError([replace(place, message=message)])
    try:
        values = _parameter(written if _RANGE.fullmatch(written) else _listed(name, written))
    except PydanticCustomError as error:
        message = f"{quoted(name)}: {error.message()}"
        raise InputError([replace(place, message=message)]) from None
    if isinstance(values, Interval) and name in ("world", "robot"):
        message = f"{quoted(name)} has names, not numbers between two ends"
        raise InputError([replace(place, message=message)])
    return replace(values, name=name, place=place)


def _listed(name: str, written: str) -> list[Any]:
    expected = f"expected values as in {EXAMPLES}"
    if colon := _COLON.fullmatch(written):
        raise fields.refusal(f"{expected}; write '{name}={colon[1]}..{colon[2]}'")
    try:
        values = read_text(f"[{written}]").data
    except InputError:
        values = None
    if not isinstance(values, list) or not values:
        raise fields.refusal(expected)
    return values


def refuse_repeated(parameters: Sequence[Parameter]) -> None:
    """Refuse parameters that are given twice.

    Raises:
        InputError: With the first such name.
    """
    seen: set[str] = set()
    for parameter in parameters:
        if parameter.name in seen:
            raise InputError(
                [replace(parameter.place, message=f"{quoted(parameter.name)} is given twice")]
            )
        seen.add(parameter.name)


# ---- values of a file -------------------------------------------------------------------------


class ValueRange(NamedTuple):
    """Two ends, both included."""

    low: float
    high: float


def _span(value: Any) -> ValueRange:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return ValueRange(value, value)
    match = _RANGE.fullmatch(value) if isinstance(value, str) else None
    if match is None or match["step"]:
        raise fields.refusal(
            f"expected a number or a range such as '0.5..2', got {describe(value)}"
        )
    low, high = float(match["low"]), float(match["high"])
    if low > high:
        raise fields.refusal(f"expected the lower end first, got {value}")
    return ValueRange(low, high)


def _span_from(value: Any, *, low: float, words: str, high: float = float("inf")) -> ValueRange:
    span = _span(value)
    if span.low < low or span.high > high:
        raise fields.refusal(f"expected {words}, got {describe(value)}")
    return span


def _positive_span(value: Any) -> ValueRange:
    span = _span(value)
    if span.low <= 0:
        raise fields.refusal(f"expected more than 0, got {span.low:g}")
    return span


def _seeds(value: Any) -> Sequence[int]:
    if isinstance(value, list):
        spans = [_seeds(item) for item in value]
        seeds = tuple(seed for part in spans for seed in part)
        if not seeds or len(set(seeds)) < len(seeds):
            raise fields.refusal(f"expected different seeds, got {describe(value)}")
        return seeds
    span = _span(value)
    if span.low < 0 or any(end != int(end) for end in span):
        raise fields.refusal(
            f"expected integers from 0 up, such as '0..999', got {describe(value)}"
        )
    return range(int(span.low), int(span.high) + 1)


def _names(written: Any) -> Parameter:
    if not isinstance(written, list) or not all(isinstance(name, str) for name in written):
        raise fields.refusal(f"expected a list of names, got {describe(written)}")
    return _parameter(written)


def _parameter(written: Any) -> Parameter:
    """Return a parameter without a name: of a list, a range, or a range with a step."""
    match = _RANGE.fullmatch(written) if isinstance(written, str) else None
    if match:
        return _ranged(match)
    if written is None or isinstance(written, Mapping | str):
        message = "expected a range such as '0.1..0.26', or a list"
        raise fields.refusal(f"{message}, got {describe(written)}")
    values = written if isinstance(written, list) else [written]
    if not values or any(item is None or isinstance(item, dict) for item in values):
        raise fields.refusal(f"expected values as in {EXAMPLES}")
    for number, value in enumerate(values):
        if value in values[:number] and type(value) is type(values[values.index(value)]):
            raise fields.refusal(f"the value {value} appears twice")
    return ValueChoice("", tuple(values))


def _ranged(match: re.Match[str]) -> Parameter:
    low, high = float(match["low"]), float(match["high"])
    if not low < high:
        raise fields.refusal(f"expected the lower end first, got {low:g}..{high:g}")
    numbers = [text for text in match.groups() if text is not None]
    is_whole = all(re.fullmatch(r"[+-]?\d+", text) for text in numbers)
    if not match["step"]:
        return Interval("", low, high, is_whole)
    step = float(match["step"])
    if step <= 0 or (high - low) / step > _MOST_STEPS:
        raise fields.refusal(f"expected a step above 0 with at most {_MOST_STEPS:,} values")
    kind = int if is_whole else float
    steps = (low + number * step for number in range(int((high - low) / step + 1e-9) + 1))
    return ValueChoice("", tuple(kind(float(f"{at:.{_DIGITS}g}")) for at in steps))


def _coordinate(written: Any) -> Parameter:
    """Return a parameter of numbers; a number alone is an interval of one value."""
    if isinstance(written, int | float) and not isinstance(written, bool):
        return Interval("", written, written)
    parameter = _parameter(written)
    if any(isinstance(end, bool) or not isinstance(end, int | float) for end in parameter.ends):
        raise fields.refusal(f"expected numbers, got {describe(written)}")
    return parameter


_speeds = partial(_span_from, low=0, high=FASTEST, words=f"speeds from 0 to {FASTEST:g} m/s")
_times = partial(_span_from, low=0, words="a time from 0 s up")
_RANGED = WithJsonSchema({"type": ["number", "string"]})
_LISTED = WithJsonSchema({"type": ["number", "string", "array"]})
AnySpan = Annotated[Any, PlainValidator(_span), _RANGED]
PositiveSpan = Annotated[Any, PlainValidator(_positive_span), _RANGED]
SpeedSpan = Annotated[Any, PlainValidator(_speeds), _RANGED]
TimeSpan = Annotated[Any, PlainValidator(_times), _RANGED]
Coordinate = Annotated[Any, PlainValidator(_coordinate), _LISTED]
Values = Annotated[Any, PlainValidator(_parameter), WithJsonSchema({})]
Names = Annotated[
    Any, PlainValidator(_names), WithJsonSchema({"type": "array", "items": {"type": "string"}})
]
Seeds = Annotated[Any, PlainValidator(_seeds), _LISTED]
Plan = Annotated[
    list[Any], WithJsonSchema({"type": "array", "items": {"type": ["string", "object"]}})
]


class _Ranged(Written):
    """Defaults are written as in a file."""

    model_config = ConfigDict(validate_default=True)


class StartRanges(_Ranged):
    """Starts of the robot, m and degrees in the map.

    `falsify` moves an occupied start to the nearest free place.
    """

    x: Coordinate | None = None
    y: Coordinate | None = None
    yaw: Coordinate = "0..360"


class ObstacleRanges(_Ranged):
    """Obstacles that may appear: m from the robot at that time, s since the start.

    Without space there, an obstacle appears at the nearest free place. One in three moves (m/s);
    none if `speed` is 0.
    """

    most: Annotated[int, Field(ge=0, le=MOST_OBSTACLES)] = 3
    times: TimeSpan | None = None
    ahead: AnySpan = "0.5..2"
    left: AnySpan = "-0.6..0.6"
    size: PositiveSpan = "0.1..0.4"
    lasting: PositiveSpan | None = None
    speed: SpeedSpan = "0.1..0.5"


class FaultRanges(_Ranged):
    """Faults that may happen, s since the start.

    Default of `times`: any time of the run, or an event of the mission. Default of `lasting`:
    0.25 s to 3 s, or slightly less or more than a limit of the mission.
    """

    most: Annotated[int, Field(ge=0, le=10)] = 3
    kinds: list[fields.Line] | None = None
    times: TimeSpan | None = None
    lasting: PositiveSpan | None = None


class Ranges(_Ranged):
    """The whole file; all keys are optional."""

    description: str = ""
    seeds: Seeds = "0..999"
    worlds: Names | None = None
    robots: Names | None = None
    inputs: dict[fields.Variable, Values] = {}
    start: Literal["anywhere"] | StartRanges | None = None
    plans: dict[fields.Line, Plan] = {}
    obstacles: ObstacleRanges = Field(default_factory=ObstacleRanges)
    faults: FaultRanges = Field(default_factory=FaultRanges)
    assume: list[WrittenFormula] = []
    limit: Annotated[float, Field(gt=0, le=100_000)] | None = None


def ranges_schema() -> dict[str, Any]:
    """Return the JSON Schema of a file of ranges."""
    return {"$schema": DIALECT, **Ranges.model_json_schema(), "title": "bt-mission ranges"}


# ---- the file ---------------------------------------------------------------------------------

NOT_READ: Mapping[str, Iterable[str]] = {
    "sweep": ("obstacles", "faults", "assume"),
    "falsify": ("robots", "plans"),
    "--fault-plan": Ranges.model_fields.keys() - {"description", "plans"},
}
"""Keys that a command or an option does not read."""


class RangesFile:
    """A file of ranges, with the places of its parts.

    Attributes:
        parameters: Inputs, worlds and robots, as a sweep varies them.

    Args:
        document: None is an empty file.

    Raises:
        InputError: With what is wrong with its form.
    """

    def __init__(self, document: Document | None = None) -> None:
        self.document = read_text("{}") if document is None else document
        self.ranges = validate(self.document, Ranges)
        if wrong := [*self._wrong_kinds(), *self._wrong_plans()]:
            raise InputError(in_order(wrong))
        self.parameters = tuple(self._named(self.ranges.inputs, "inputs"))
        for key, name in (("worlds", "world"), ("robots", "robot")):
            if values := getattr(self.ranges, key):
                self.parameters += (
                    replace(
                        values, name=name, place=self.document.diagnostic("BT-708", (key,), "")
                    ),
                )

    @property
    def start(self) -> tuple[Parameter, ...]:
        """The ranges of the start that are written, as a sweep varies them."""
        start = self.ranges.start
        if not isinstance(start, StartRanges):
            return ()
        given = {axis: getattr(start, axis) for axis in start.model_fields_set}
        return tuple(
            ValueChoice(parameter.name, (parameter.low,), parameter.place)
            if isinstance(parameter, Interval) and parameter.low == parameter.high
            else parameter
            for parameter in self._named(given, "start", "start.")
        )

    def _named(
        self, written: Mapping[str, Parameter], key: str, before: str = ""
    ) -> Iterator[Parameter]:
        for name, values in written.items():
            place = self.document.diagnostic("BT-708", (key, name), "")
            yield replace(values, name=f"{before}{name}", place=place)

    def _wrong_kinds(self) -> Iterator[Diagnostic]:
        for number, kind in enumerate(self.ranges.faults.kinds or ()):
            if unknown := unknown_kind(kind):
                yield self.document.diagnostic("BT-702", ("faults", "kinds", number), *unknown)

    def _wrong_plans(self) -> Iterable[Diagnostic]:
        reader = FaultReader(self.document)
        for name, plan in self.ranges.plans.items():
            for number, entry in enumerate(plan):
                reader.fault(entry, ("plans", name, number))
        return reader.wrong

    def refuse_others(self, reader: str) -> None:
        """Refuse keys that a command or an option does not read.

        Args:
            reader: A key of `NOT_READ`.

        Raises:
            InputError: With each of them.
        """
        wrong = [
            self.document.diagnostic(
                "BT-708", (key,), f"{reader} does not read {quoted(key)}", key=True
            )
            for key in self.ranges.model_fields_set.intersection(NOT_READ[reader])
        ]
        if reader == "sweep" and self.ranges.start == "anywhere":
            message = "a sweep has ranges of 'x', 'y' and 'yaw'; 'anywhere' is for falsify"
            wrong.append(self.document.diagnostic("BT-708", ("start",), message))
        if wrong:
            raise InputError(in_order(wrong))

    def check_worlds(self, near: Path) -> None:
        """Look for the worlds. Raises InputError with those that are not there."""
        wrong = [
            self.document.diagnostic(
                "BT-110",
                ("worlds", number),
                f"unknown world {quoted(world)}",
                did_you_mean(world, names("worlds")),
            )
            for number, world in enumerate(self.ranges.worlds.values if self.ranges.worlds else ())
            if look_for("worlds", world, near=near) is None
        ]
        if wrong:
            raise InputError(wrong)

    def check_inputs(self, mission: Mission) -> None:
        """Check that the mission has the inputs. Raises InputError with the others."""
        if wrong := [*self._unknown_inputs(mission)]:
            raise InputError(wrong)

    def check_mission(self, mission: Mission) -> None:
        """Check that the mission has the inputs and nodes, and the robot a camera for its faults.

        Raises:
            InputError: With all that are missing.
        """
        parts = (self._unknown_inputs, self._needing_camera, self._unknown_names)
        if wrong := [fault for part in parts for fault in part(mission)]:
            raise InputError(in_order(wrong))

    def _unknown_inputs(self, mission: Mission) -> Iterator[Diagnostic]:
        for name in self.ranges.inputs:
            if name not in mission.inputs:
                known = ", ".join(mission.inputs) or "none"
                message = f"unknown input {quoted(name)} (the mission's inputs: {known})"
                hint = did_you_mean(name, mission.inputs)
                yield self.document.diagnostic("BT-310", ("inputs", name), message, hint, key=True)

    def _needing_camera(self, mission: Mission) -> Iterator[Diagnostic]:
        for number, kind in enumerate(self.ranges.faults.kinds or ()):
            if kind.partition("_")[0] == "camera" and not has_camera(mission):
                message = f"{quoted(kind)}: the robot '{mission.robot}' has no camera"
                yield self.document.diagnostic("BT-508", ("faults", "kinds", number), message)

    def _unknown_names(self, mission: Mission) -> Iterator[Diagnostic]:
        known = MissionNames(mission)
        for number, formula in enumerate(self.ranges.assume):
            for unknown in known.unknown_in(formula.root):
                offset = unknown.column - 1
                yield self.document.diagnostic(
                    unknown.code, ("assume", number), unknown.message, unknown.hint, offset=offset
                )


def read_ranges(path: Path | None) -> RangesFile:
    """Read a file of ranges; None is an empty one.

    Raises:
        InputError: With every error of its form.
        BtMissionError: A file cannot be read.
    """
    return RangesFile(None if path is None else read(path))


def check_ranges(path: Path, _robot: str | None = None, _world: str | None = None) -> Checked:
    """Check a file of ranges alone; the names in it are those of a mission.

    Raises:
        InputError: With every error.
    """
    ranges = read_ranges(path).ranges
    written = [key for key in Ranges.model_fields if key in ranges.model_fields_set]
    return CheckedFile(str(path), path.stem, ", ".join(written) or "nothing"), ()


def with_fault_plans(plans: Mapping[str, list[Any]], paths: Sequence[Path]) -> dict[str, list[Any]]:
    """Add the plans of files that have nothing else; a sweep runs each point with each plan.

    Raises:
        InputError: With all errors of a file, or for a repeated name.
    """
    named = dict(plans)
    for path in paths:
        file = read_ranges(path)
        file.refuse_others("--fault-plan")
        if not file.ranges.plans:
            message = "expected plans such as 'plans: {blind: [at 5.0: drop scan lasting 2]}'"
            raise InputError([file.document.diagnostic("BT-708", (), message)])
        for name, faults in file.ranges.plans.items():
            if name in named:
                message = f"the plan {quoted(name)} already exists"
                raise InputError(
                    [file.document.diagnostic("BT-208", ("plans", name), message, key=True)]
                )
            named[name] = faults
    return named
