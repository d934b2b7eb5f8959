"""A scenario: a mission, its place, what goes wrong, and the expected result."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from bt_mission.base.diagnostics import Diagnostic, InputError, quoted
from bt_mission.base.nature import Nature
from bt_mission.base.text import escape_control, seconds
from bt_mission.base.verdicts import RequirementResult
from bt_mission.base.yaml.document import Document, Key
from bt_mission.executive.report import Report
from bt_mission.language.mission import Mission, NodeFactory
from bt_mission.scenarios.coverage.record import CoverageRecord
from bt_mission.scenarios.faults.parameters import MAY_NOT_HAPPEN
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.scenarios.servers import ServerScript
from bt_mission.sessions.stage_robot import StageOptions
from sim.robot.fit import SpawnError
from sim.world.world import World

LIMIT_S = 600.0
"""Virtual seconds after which a run counts as one that never ends."""

TIME_IS_UP = "its time is up"
"""The reason of a mission that a test, or the limit of its scenario, ends. One for both: the trace
of a test is that of its scenario."""

Outcome = Literal["success", "failure", "interrupted", "any"]


@dataclass(frozen=True)
class Expectation:
    """The expected result of a run.

    Attributes:
        reason: A regular expression that the mission's reason must have a match of.
        failed: Name of the node whose failure came last, or of one above it.
        after: The mission ends at this time or later, s since the start.
        before: The mission ends at this time or earlier, s since the start.
        violated: The requirements that are violated; all others are not.
        orphaned_goals: How many goals no server confirms the end of; None is any number.
        collisions: How often the robot touches something; None is as often as it likes.
    """

    outcome: Outcome = "success"
    reason: str = ""
    failed: str = ""
    after: float | None = None
    before: float | None = None
    violated: tuple[str, ...] = ()
    orphaned_goals: int | None = 0
    collisions: int | None = None


@dataclass(frozen=True)
class Scenario:
    """Everything that a run follows from, and its expected result.

    Attributes:
        start: X m, y m and yaw degrees of the robot; None is where the world says.
        nature: Instead of the mission's; None is that.
        world: Instead of the mission's; None is that.
        faults: Obstacles included, which appear at 0 s.
        servers: Instead of the shipped ones.
        limit: The mission is interrupted at this time, s since the start.
    """

    name: str
    mission: Mission
    description: str = ""
    world: World | None = None
    simulator: NodeFactory | None = None
    start: tuple[float, float, float] | None = None
    nature: Nature | None = None
    faults: tuple[PlannedFault, ...] = ()
    servers: tuple[ServerScript, ...] = ()
    expect: Expectation = Expectation()
    limit: float = LIMIT_S
    document: Document = field(repr=False, compare=False, kw_only=True)

    @property
    def file(self) -> str:
        """Where it is written."""
        return self.document.file

    @property
    def stage_options(self) -> StageOptions:
        """How its stage is set up."""
        return StageOptions(
            world=self.world,
            simulator=self.simulator,
            start=self.start,
            nature=self.nature,
            props=MOST_OBSTACLES,
            nodes=self.servers,
        )

    @contextmanager
    def at_its_start(self) -> Iterator[None]:
        """Have a start without room for the robot refused at its place in the file.

        Raises:
            InputError: Where the stage raises SpawnError.
        """
        try:
            yield
        except SpawnError as error:
            paths: tuple[tuple[Key, ...], ...] = (("start",), ("world", "spawn"), ("world",), ())
            path = next(candidate for candidate in paths if self.document.has(*candidate))
            raise InputError([self.document.diagnostic("BT-803", path, str(error))]) from error

    def judge(self, report: Report) -> ScenarioResult:
        """Compare the result with the expected one."""
        return ScenarioResult(self, report, tuple(self._differences(report)))

    def _differences(self, report: Report) -> Iterator[Diagnostic]:
        expect = self.expect
        if expect.outcome not in ("any", report.status):
            reason = f": {report.reason}" if report.reason else ""
            got = f"{report.status}{reason}, at {seconds(report.virtual_s)}"
            yield self._fault("outcome", f"expected {expect.outcome}, got {got}")
        if expect.reason and not re.search(expect.reason, report.reason):
            message = f"expected a reason with {quoted(expect.reason)}, got {report.reason!r}"
            yield self._fault("reason", message)
        path = report.failure.nodes if report.failure else ()
        if expect.failed and expect.failed not in path:
            got = " > ".join(path) or "no failure"
            yield self._fault("failed", f"expected a failure of {quoted(expect.failed)}, got {got}")
        if expect.after is not None and report.virtual_s < expect.after - 1e-9:
            message = f"expected the end at {expect.after:g} s or later"
            yield self._fault("after", f"{message}, got {seconds(report.virtual_s)}")
        if expect.before is not None and report.virtual_s > expect.before + 1e-9:
            message = f"expected the end at {expect.before:g} s or earlier"
            yield self._fault("before", f"{message}, got {seconds(report.virtual_s)}")
        yield from self._violations(report)
        yield from self._missing_faults(report)
        yield from self._unused_servers(report)
        if expect.orphaned_goals not in (None, report.goals_left_behind):
            message = f"expected {expect.orphaned_goals} orphaned goals"
            yield self._fault("orphaned_goals", f"{message}, got {report.goals_left_behind}")
        if expect.collisions is not None and report.collisions != expect.collisions:
            message = f"expected {expect.collisions} collisions, got {report.collisions}"
            yield self._fault("collisions", message)

    def _violations(self, report: Report) -> Iterator[Diagnostic]:
        for requirement in report.requirements:
            is_expected = requirement.name in self.expect.violated
            if requirement.fails and not is_expected:
                written = self.document.has("requirements", requirement.name)
                path: tuple[Key, ...] = ("requirements", requirement.name) if written else ()
                yield self.document.diagnostic("BT-706", path, f"requirement {requirement}")
            elif is_expected and requirement.verdict != "violated":
                message = f"expected a violation of {quoted(requirement.name)}, got: {requirement}"
                number = self.expect.violated.index(requirement.name)
                yield self.document.diagnostic("BT-706", ("expect", "violated", number), message)

    def _missing_faults(self, report: Report) -> Iterator[Diagnostic]:
        """Yield the faults that never happened, each at its place."""
        for written, outcome in zip(self.faults, report.faults, strict=False):
            if outcome.fails:
                hint = f"if the run may end before it, add '{MAY_NOT_HAPPEN.name}' to the fault"
                yield written.locate("BT-706", f"fault {outcome}", hint)

    def _unused_servers(self, report: Report) -> Iterator[Diagnostic]:
        """Yield the servers and answers for which no goal came, each at its place."""
        unused = [(script, *item) for script in self.servers for item in script.lines().items()]
        for script, number, line in unused:
            if line in report.untested:
                place = () if number is None else (number,)
                message = f"not tested: {line}"
                hint = "if no goal may come for it, add 'may_not_be_asked: true' to the answer"
                path: tuple[Key, ...] = ("servers", script.written, *place)
                yield self.document.diagnostic("BT-706", path, message, hint, key=number is None)

    def _fault(self, key: str, message: str) -> Diagnostic:
        path: tuple[Key, ...] = ("expect", key) if self.document.has("expect", key) else ("expect",)
        return self.document.diagnostic(
            "BT-706", path if self.document.has("expect") else (), message
        )


@dataclass(frozen=True)
class ScenarioResult:
    """The result of a run of a scenario.

    Attributes:
        report: Of the run: outcome, requirements, faults, trace.
        differences: Differences from the expected result, each with its place in the scenario.
        coverage: The places of the mission that the run reached; None if not requested.
    """

    scenario: Scenario
    report: Report
    differences: tuple[Diagnostic, ...] = ()
    coverage: CoverageRecord | None = None

    @property
    def passed(self) -> bool:
        """Is the result as expected?"""
        return not self.differences

    @property
    def is_whole(self) -> bool:
        """Did the run end, alone or at its limit?"""
        return self.report.status != "interrupted" or self.report.reason == TIME_IS_UP

    @property
    def requirements(self) -> dict[str, RequirementResult]:
        """The verdict of each requirement, by its name."""
        return {requirement.name: requirement for requirement in self.report.requirements}

    @property
    def violated(self) -> tuple[str, ...]:
        """Names of the requirements that are violated."""
        return tuple(
            requirement.name
            for requirement in self.report.requirements
            if requirement.verdict == "violated"
        )

    def as_dict(self) -> dict[str, Any]:
        """The result, ready for JSON: name, passed, differences."""
        differences = [difference.headline for difference in self.differences]
        return {"name": self.scenario.name, "passed": self.passed, "differences": differences}

    def __str__(self) -> str:
        name = escape_control(self.scenario.name)
        if not self.passed:
            lines = "\n".join(map(str, self.differences))
            return f"{lines}\nscenario {name}: failed"
        expect = self.scenario.expect
        expected: list[str] = [] if expect.outcome in ("success", "any") else [expect.outcome]
        if expect.violated:
            expected.append(escape_control(f"violated: {', '.join(expect.violated)}"))
        return f"scenario {name}: passed" + (f" (expected {'; '.join(expected)})" * bool(expected))
