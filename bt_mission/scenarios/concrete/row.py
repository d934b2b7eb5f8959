"""The result of one scenario: a row, whose types are those of its columns in SQLite and CSV."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    JsonValue,
    TypeAdapter,
    ValidationError,
)
from pydantic_core import PydanticCustomError

from bt_mission.base.nature import BY_NAME
from bt_mission.base.text import cut
from bt_mission.base.verdicts import FAILING, VACUOUS, Verdict
from bt_mission.scenarios.cause import Cause, CauseKind, kind_of, masked
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.scenario import ScenarioResult

RowOutcome = Literal["success", "failure", "interrupted", "error"]


def _of_json(text: Any) -> Any:
    """Return the value of a column that holds JSON."""
    try:
        value = json.loads(text)
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError, RecursionError):
        raise PydanticCustomError("json", "is not JSON") from None
    return value


def _known_quantities(value: Mapping[str, float]) -> Mapping[str, float]:
    if unknown := value.keys() - BY_NAME.keys():
        raise ValueError(f"unknown quantities of nature: {unknown}")
    return value


Json = BeforeValidator(_of_json)
Digits = Annotated[str, Field(pattern="^[0-9a-f]*$")]


@dataclass(frozen=True)
class RequirementMargin:
    """The result of a requirement in one run.

    Attributes:
        margin: By how much it holds, in the unit; negative by how much it is violated. None without
            a measure.
        at: The instant that decides, s since the start.
    """

    verdict: Verdict
    margin: float | None = None
    unit: str = ""
    at: float | None = None


@dataclass(frozen=True)
class ScenarioRow:
    """The result of one scenario; each field is a column.

    Attributes:
        id: Of the concrete scenario: two with the same id give the same run.
        number: Its place in the sweep.
        parameters: The values of what is varied.
        plan: The name of its plan of faults.
        faults: All faults, as texts.
        nature: What nature has drawn, by the names of its quantities.
        outcome: How the mission ended; ``error`` where it could not run, or killed its worker.
        passed: Whether the result is the expected one. For a mission that is success with no
            requirement violated and no goal orphaned, for a scenario what it expects.
        cause_kind: The kind of :attr:`cause`; empty where it has passed.
        reason: Why the mission ended so; where its end is not why the scenario has not passed, what
            differs from what is expected.
        failed_node: The node whose failure came last; empty where none made the tree fail.
        failed_path: The names from the root to it, with `` > `` between them.
        virtual_s: ROS time from start to end, s.
        wall_s: Wall time of the run with its set-up, s.
        distance_m: True length of the robot's path, m.
        least_margin: The smallest margin of all requirements that were exercised; units may differ.
        requirements: The result of each, by name.
        coverage: What of the tree was reached, in hexadecimal (`bt_mission.scenarios.coverage`).
        trace_sha256: Equal for two runs in which the same things happened at the same times.
        sample: Equal for two runs with the same outcome and signals, whatever their seeds; those
            are one sample. Empty where it could not run.
        versions: First digits of the digest of all versions; the store has them in full.
        worker: The process that ran it.
        attempts: How often a worker was given it: once more for each that died with it.
    """

    __pydantic_config__ = ConfigDict(allow_inf_nan=False)

    id: Annotated[Digits, Field(min_length=1, max_length=64)]
    number: int
    seed: int
    world: str = ""
    robot: str = ""
    parameters: Annotated[Mapping[str, JsonValue], Json] = field(default_factory=dict)
    plan: str = ""
    faults: Annotated[tuple[str, ...], Json] = ()
    nature: Annotated[Mapping[str, float], AfterValidator(_known_quantities), Json] = field(
        default_factory=dict
    )
    outcome: RowOutcome = "error"
    passed: bool = False
    cause_kind: CauseKind | Literal[""] = ""
    reason: str = ""
    failed_node: str = ""
    failed_path: str = ""
    virtual_s: float = 0.0
    wall_s: float = 0.0
    distance_m: float | None = None
    collisions: int | None = None
    goals_sent: int = 0
    orphaned_goals: int = 0
    ticks: int = 0
    least_margin: float | None = None
    requirements: Annotated[Mapping[str, RequirementMargin], Json] = field(default_factory=dict)
    coverage: Digits = ""
    trace_sha256: str = ""
    sample: Annotated[Digits, Field(max_length=16)] = ""
    versions: str = ""
    worker: str = ""
    attempts: int = 1

    @property
    def is_error(self) -> bool:
        """Whether it could not run."""
        return self.outcome == "error"

    @property
    def unexercised(self) -> tuple[str, ...]:
        """The requirements that were not exercised."""
        return tuple(
            name for name, each in self.requirements.items() if each.verdict == "not exercised"
        )

    @property
    def why_failed(self) -> str:
        """Why it has not passed, in one line; empty if it has."""
        if self.cause_kind == "":
            return ""
        if self.cause_kind in FAILING:
            return f"requirement {self.cause_kind}: {self._failing}"
        return self.reason.splitlines()[0] if self.reason else self.outcome

    @property
    def cause(self) -> Cause | None:
        """Why it has not passed, equal for rows with the same cause; None if it has."""
        if self.cause_kind == "":
            return None
        if self.cause_kind in FAILING:
            return Cause(self.cause_kind, self._failing)
        place = self.failed_path if self.cause_kind in ("failed", "interrupted") else ""
        return Cause(self.cause_kind, place, masked(self.why_failed))

    @property
    def _failing(self) -> str:
        """Name the requirement that is the cause, of several the one that was decided first."""
        failing = [
            (name, requirement)
            for name, requirement in self.requirements.items()
            if requirement.verdict == self.cause_kind
        ]
        return min(failing, key=lambda pair: math.inf if pair[1].at is None else pair[1].at)[0]


_ROW = TypeAdapter(ScenarioRow)


def row_of_columns(columns: Mapping[str, Any]) -> ScenarioRow:
    """Return a row of its columns, which may be foreign.

    Raises:
        ValueError: With the first invalid column.
    """
    try:
        row = _ROW.validate_python(columns)
    except ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0])
        what = first["msg"] if first["type"] == "json" else "is invalid"
        raise ValueError(f"column '{name}': {cut(repr(columns[name]), 60)} {what}") from None
    verdicts = {requirement.verdict for requirement in row.requirements.values()}
    is_shown = row.cause_kind not in FAILING or row.cause_kind in verdicts
    if row.passed != (row.cause_kind == "") or not is_shown:
        raise ValueError(f"column 'cause_kind': '{row.cause_kind}' contradicts the other columns")
    return row


def row_of(scenario: ConcreteScenario, result: ScenarioResult, *, wall_s: float) -> ScenarioRow:
    """Return the row of a scenario that has run."""
    report = result.report
    margins = {
        requirement.name: RequirementMargin(
            requirement.verdict, requirement.margin, requirement.unit, requirement.at
        )
        for requirement in report.requirements
    }
    failure = report.failure
    kind = kind_of(result)
    reason = report.reason
    if kind in (*FAILING, "untested", "unexpected"):
        reason = "; ".join(difference.message for difference in result.differences)
    known = [
        requirement.margin
        for requirement in report.requirements
        if requirement.margin is not None and requirement.verdict not in VACUOUS
    ]
    return ScenarioRow(
        id=scenario.id,
        number=scenario.number,
        seed=report.seed,
        world=report.world or "",
        robot=report.robot,
        parameters=scenario.parameters,
        plan=scenario.plan,
        faults=tuple(fault.text for fault in result.scenario.faults),
        nature=report.nature,
        outcome=report.status,  # type: ignore[arg-type] # a mission that has ended has one of these
        passed=result.passed,
        cause_kind=kind or "",
        reason=reason,
        failed_node=failure.nodes[-1] if failure else "",
        failed_path=" > ".join(failure.nodes) if failure else "",
        virtual_s=report.virtual_s,
        wall_s=round(wall_s, 4),
        distance_m=report.distance_travelled_m,
        collisions=report.collisions,
        goals_sent=report.goals_sent,
        orphaned_goals=report.goals_left_behind,
        ticks=report.ticks,
        least_margin=min(known, default=None),
        requirements=margins,
        coverage=result.coverage.as_hex() if result.coverage else "",
        trace_sha256=report.trace_sha256,
        sample=report.sample,
    )


def row_of_error(scenario: ConcreteScenario, reason: str, *, attempts: int = 1) -> ScenarioRow:
    """Return the row of a scenario that could not run, or that kills its workers."""
    return ScenarioRow(
        id=scenario.id,
        number=scenario.number,
        seed=int(scenario.data.get("seed", 0)),
        parameters=scenario.parameters,
        plan=scenario.plan,
        cause_kind="error",
        reason=reason,
        attempts=attempts,
    )
