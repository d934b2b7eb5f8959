"""What a search may vary, as a file of ranges says it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, PlainValidator

from bt_mission.core.diagnostics import (
    Diagnostic,
    InputError,
    describe,
    did_you_mean,
    in_order,
    quoted,
)
from bt_mission.core.files import look_for, names
from bt_mission.core.yaml.document import Document, read, read_text
from bt_mission.core.yaml.models import validate
from bt_mission.faults.world import MOST_OBSTACLES
from bt_mission.language.checks.requirements import MissionNames
from bt_mission.language.mission import Mission
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import Written
from bt_mission.language.requirements.written import WrittenFormula
from bt_mission.search.kinds import unknown_kind
from bt_mission.sessions.check import has_camera
from bt_mission.sweeps.space import NUMBER, Interval, Parameter, parse_parameter, read_parameters
from sim.world.world import FASTEST

_SPAN = re.compile(rf"\s*({NUMBER})\s*\.\.\s*({NUMBER})\s*")


class Span(NamedTuple):
    """Two ends, both included."""

    low: float
    high: float


def _span(value: Any) -> Span:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return Span(value, value)
    found = _SPAN.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        raise fields.refusal(
            f"expected a number or a range such as '0.5..2', got {describe(value)}"
        )
    low, high = float(found[1]), float(found[2])
    if low > high:
        raise fields.refusal(f"expected the lower end first, got {value}")
    return Span(low, high)


def _positive_span(value: Any) -> Span:
    span = _span(value)
    if span.low <= 0:
        raise fields.refusal(f"expected more than 0, got {span.low:g}")
    return span


def _speed_span(value: Any) -> Span:
    span = _span(value)
    if span.low < 0 or span.high > FASTEST:
        raise fields.refusal(f"expected speeds from 0 to {FASTEST:g} m/s, got {describe(value)}")
    return span


def _time_span(value: Any) -> Span:
    span = _span(value)
    if span.low < 0:
        raise fields.refusal(f"expected a time from 0 s up, got {span.low:g}")
    return span


def _seeds(value: Any) -> range:
    span = _span(value)
    if span.low < 0 or any(one != int(one) for one in span):
        raise fields.refusal(
            f"expected integers from 0 up, such as '0..999', got {describe(value)}"
        )
    return range(int(span.low), int(span.high) + 1)


AnySpan = Annotated[Any, PlainValidator(_span)]
PositiveSpan = Annotated[Any, PlainValidator(_positive_span)]
SpeedSpan = Annotated[Any, PlainValidator(_speed_span)]
TimeSpan = Annotated[Any, PlainValidator(_time_span)]
Seeds = Annotated[Any, PlainValidator(_seeds)]


class StartRanges(Written):
    """Where the robot may start, m and degrees of the map; places that are not free are moved."""

    x: AnySpan | None = None
    y: AnySpan | None = None
    yaw: AnySpan = Span(0.0, 360.0)


class ObstacleRanges(Written):
    """Obstacles that may appear; m from the robot as it stands then, s since the start.

    Where there is no room, an obstacle appears at the nearest place that has some. One in three
    moves, m/s; none where `speed` is 0.
    """

    most: Annotated[int, Field(ge=0, le=MOST_OBSTACLES)] = 3
    times: TimeSpan | None = None
    ahead: AnySpan = Span(0.5, 2.0)
    left: AnySpan = Span(-0.6, 0.6)
    size: PositiveSpan = Span(0.1, 0.4)
    lasting: PositiveSpan | None = None
    speed: SpeedSpan = Span(0.1, 0.5)


class FaultRanges(Written):
    """Faults that may happen, s since the start.

    Without `kinds`, those of `DEFAULT_KINDS`. Without `times`, faults begin at a time of the run or
    with an event of the mission. Without `lasting`, they go on for 0.25 s to 3 s, or for a little
    less or more than a limit of the mission.
    """

    most: Annotated[int, Field(ge=0, le=10)] = 3
    kinds: list[fields.Line] | None = None
    times: TimeSpan | None = None
    lasting: PositiveSpan | None = None


class Ranges(Written):
    """The whole file; everything may be left out."""

    description: str = ""
    seeds: Seeds = range(1000)
    worlds: list[fields.Line] = []
    inputs: dict[fields.Variable, Any] = {}
    start: Literal["anywhere"] | StartRanges | None = None
    obstacles: ObstacleRanges = ObstacleRanges()
    faults: FaultRanges = FaultRanges()
    assume: list[WrittenFormula] = []
    limit: Annotated[float, Field(gt=0, le=100_000)] | None = None


class RangesFile:
    """What was read of a file of ranges, with the places of its parts.

    Args:
        document: None is a file that says nothing.

    Raises:
        InputError: With what is wrong with its form.
    """

    def __init__(self, document: Document | None = None) -> None:
        self.document = read_text("{}") if document is None else document
        self.ranges = validate(self.document, Ranges)
        wrong = [*self._wrong_kinds()]
        self.parameters = self._parameters(wrong)

    def _parameters(self, wrong: list[Diagnostic]) -> tuple[Parameter, ...]:
        """Return inputs and worlds, as a sweep varies them; raise what is wrong."""
        found: list[Parameter] = []
        for name, values in self.ranges.inputs.items():
            try:
                found += _input(name, values)
            except InputError as error:
                wrong += [
                    self.document.fault(("inputs", name), one.message, one.hint)
                    for one in error.faults
                ]
        if wrong:
            raise InputError(in_order(wrong))
        if self.ranges.worlds:
            found += read_parameters({"world": self.ranges.worlds}, self.document.file)
        return tuple(found)

    def _wrong_kinds(self) -> Iterator[Diagnostic]:
        for number, kind in enumerate(self.ranges.faults.kinds or ()):
            if found := unknown_kind(kind):
                yield self.document.fault(("faults", "kinds", number), *found)

    def check_worlds(self, near: Path) -> None:
        """Look for the worlds.

        Raises:
            InputError: With those that are not there.
        """
        wrong = [
            self.document.fault(
                ("worlds", number),
                f"no such world: {quoted(one)}",
                did_you_mean(one, names("worlds")),
            )
            for number, one in enumerate(self.ranges.worlds)
            if look_for("worlds", one, near=near) is None
        ]
        if wrong:
            raise InputError(wrong)

    def check_inputs(self, mission: Mission) -> None:
        """Look for the inputs in the mission.

        Raises:
            InputError: With those that it does not have.
        """
        wrong = []
        for name in self.ranges.inputs:
            if name not in mission.inputs:
                known = ", ".join(mission.inputs) or "none"
                message = f"the mission has no input {quoted(name)} (its inputs: {known})"
                hint = did_you_mean(name, mission.inputs)
                wrong.append(self.document.fault(("inputs", name), message, hint, key=True))
        if wrong:
            raise InputError(wrong)

    def check_camera(self, mission: Mission) -> None:
        """Look for the camera that the kinds of faults need.

        Raises:
            InputError: With the kinds that need one where the robot has none.
        """
        kinds = enumerate(self.ranges.faults.kinds or ())
        needing = [(n, kind) for n, kind in kinds if kind.partition("_")[0] == "camera"]
        if needing and not has_camera(mission):
            raise InputError(
                self.document.fault(
                    ("faults", "kinds", number),
                    f"{quoted(kind)}: the robot '{mission.robot}' has no camera",
                )
                for number, kind in needing
            )

    def check_assumptions(self, mission: Mission) -> None:
        """Look for the nodes and variables that assumptions name.

        Raises:
            InputError: With those that the mission does not have.
        """
        names = MissionNames(mission)
        wrong = [
            self.document.fault(("assume", number), one.message, one.hint, offset=one.column - 1)
            for number, formula in enumerate(self.ranges.assume)
            for one in names.unknown_in(formula.root)
        ]
        if wrong:
            raise InputError(wrong)

    def refused_value(self, name: str, message: str) -> Diagnostic:
        """Tell that a mission refuses a value of an input, at its place."""
        return self.document.fault(("inputs", name), message)


def read_ranges(path: Path | None) -> RangesFile:
    """Read a file of ranges; None is one that says nothing.

    Raises:
        InputError: With every error of its form.
        BtMissionError: For a file that cannot be read.
    """
    return RangesFile(None if path is None else read(path))


def _input(name: str, values: Any) -> tuple[Parameter, ...]:
    if isinstance(values, list):
        return read_parameters({name: values}, name)
    if isinstance(values, Mapping) or values is None:
        raise InputError([Diagnostic("expected a range such as '0.1..0.26', or a list", name)])
    parameter = parse_parameter(f"{name}={values}", name)
    if isinstance(values, str) and not isinstance(parameter, Interval):
        raise InputError([Diagnostic("expected a range such as '0.1..0.26', or a list", name)])
    return (parameter,)
