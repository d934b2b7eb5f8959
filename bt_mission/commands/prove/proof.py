"""Proves a mission; the result and the findings, as text and as JSON."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from bt_mission.base.diagnostics import listed
from bt_mission.base.text import counted, escape_control
from bt_mission.commands.prove.abstraction import ROUNDS_OF_CUT
from bt_mission.commands.prove.answers import AnswerSet
from bt_mission.commands.prove.choices import UNBOUNDED, Script
from bt_mission.commands.prove.claims import (
    OF_SOME_RUN,
    ONE_GOAL,
    PROPERTIES,
    Broken,
    Claims,
    name_of,
)
from bt_mission.commands.prove.environment import Environment
from bt_mission.commands.prove.explorer import (
    Bounds,
    ExplorationProgress,
    Explored,
    explore,
    replay,
)
from bt_mission.commands.prove.goal_servers import MOST_DELAYS
from bt_mission.commands.prove.known_steps import DivergedError
from bt_mission.commands.prove.revision import RevisedEverywhere, RevisionClaims
from bt_mission.language.mission import Mission, Requirement
from bt_mission.requirements.language.formula import root_of, vacuous_verdict
from bt_mission.requirements.language.premises import premises_of
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageRecord

USUAL_FAULTS = 2
_OUTCOME = re.compile(r"('[^']+') ([a-z ]+)(?::.*)?", re.DOTALL)
"""A reason that begins with a node and its outcome."""
MORE_FAULTS = 2
"""The additional ones allowed in the search for a node that no way has entered."""


@dataclass(frozen=True)
class ProofOptions:
    """The scope of a proof.

    Attributes:
        faults: Most faults on a way; infinite for no bound.
        requirements: Those besides the mission's own ones.
        rounds: Counts of `repeat` above it are cut to it; 0 for no bound and exact deadlines.
            None opens those above 10.
        with_outcomes: Collect the outcomes that nodes have on some way.
        revision: Another version of the mission, which is tried in every state.
    """

    faults: float = USUAL_FAULTS
    answers: AnswerSet = field(default_factory=AnswerSet)
    with_interrupts: bool = False
    requirements: tuple[Requirement, ...] = ()
    rounds: int | None = None
    bounds: Bounds = field(default_factory=Bounds)
    with_outcomes: bool = False
    revision: Mission | None = None

    def environment(
        self, mission: Mission, faults: float | None = None, **widened: bool
    ) -> Environment:
        """Return a mission before its first step."""
        environment = Environment(
            mission,
            self.answers,
            self.faults if faults is None else faults,
            has_interrupts=self.with_interrupts,
            rounds=self.rounds,
            requirements=self.all_requirements(mission),
            **widened,
        )
        environment.keys.keeps_all = self.revision is not None
        return environment

    def all_requirements(self, mission: Mission) -> tuple[Requirement, ...]:
        """Return the requirements of a mission, and those besides."""
        return (*mission.requirements, *self.requirements)


@dataclass(frozen=True)
class StagedFinding:
    """A finding as a scenario, and what its run on the stage has shown.

    Attributes:
        is_confirmed: Does the run with the real executive show it? None without a run.
        why_not: Why no run was made, or what it cannot decide.
        scenario: The path of the scenario; "" for none.
    """

    is_confirmed: bool | None = None
    why_not: str = ""
    scenario: str = ""

    def __str__(self) -> str:
        if self.is_confirmed is None:
            words = f"not decided on the stage: {self.why_not}"
        elif self.is_confirmed:
            words = "confirmed on the stage"
        else:
            words = "not seen on the stage (spurious: report it)"
        return words + (f": {self.scenario}" if self.scenario else "")


@dataclass(frozen=True)
class Finding:
    """A property that does not hold, with a shortest way to where it shows.

    Attributes:
        property: One of ``PROPERTIES``.
        node: The node to blame; "" for none.
        nodes: The paths of the nodes that it is about.
        requirement: The requirement that is violated; "" for none.
        steps: What happens, a line for each answer.
        way: The script of each step.
        broken: What the exploration saw; None for a node that no way enters.
        stage: The result of a run on the stage, or None.
    """

    property: str
    node: str
    text: str
    steps: tuple[str, ...]
    way: tuple[Script, ...] = ()
    requirement: str = ""
    nodes: tuple[str, ...] = ()
    broken: Broken | None = None
    stage: StagedFinding | None = None

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        stage = self.stage or StagedFinding()
        return {
            "property": self.property,
            "node": self.node or None,
            "nodes": list(self.nodes),
            "requirement": self.requirement or None,
            "text": self.text,
            "steps": list(self.steps),
            "scenario": stage.scenario or None,
            "confirmed": stage.is_confirmed,
            "undecided": stage.why_not or None,
        }

    def __str__(self) -> str:
        steps = [f"    {number}. {step}" for number, step in enumerate(self.steps, 1)]
        if not steps and self.broken is not None:
            steps = ["    at once"]
        lines = [f"  {self.property}: {self.text}", *steps]
        if self.stage is not None:
            lines.append(f"    {self.stage}")
        return "\n".join(map(escape_control, lines))


@dataclass(frozen=True)
class RequirementVerdict:
    """A requirement of a mission.

    Attributes:
        verdict: ``proved``, ``violated``, ``needs physics``; ``not violated`` or ``open`` where
            the exploration is not exhaustive; ``not exercised`` or ``not applicable`` where it is,
            and a premise comes true in no run.
        why: Why it needs physics, or which premise never comes true.
    """

    requirement: str
    verdict: str
    why: str = ""

    def __str__(self) -> str:
        why = f" ({self.why})" if self.why else ""
        return f"{self.verdict}: requirement '{self.requirement}'{why}"


@dataclass(frozen=True)
class Proof:
    """The result of a proof of a mission.

    Attributes:
        exhaustive: Were all states visited within the bound on faults, with no count cut?
        why_not: Why not.
        faults: The bound; None for none.
        proved: The names of the properties that hold; none if the exploration is not exhaustive.
        not_violated: The names of those that no visited state violates, where all states were
            visited: with cut counts or sampled values all of them, with abstract deadlines those
            that hold because of some run.
        failures: The reasons for which it fails on some way: the outcomes that end the mission.
        never_entered: Nodes that no way enters within the bound on faults.
        requirements: Its requirements with their verdicts.
        abstracted: Loops that may end after any round, and deadlines that may be met at any tick.
            A finding may need a run that real time rules out.
        outcomes: The nodes with the outcomes that they can have; those that some way reaches are
            counted. Empty where nobody asked.
        revision: Whether the mission can become another version in every state; None without one.
    """

    mission: str
    exhaustive: bool
    why_not: tuple[str, ...]
    faults: int | None
    states: int
    paths: int
    proved: tuple[str, ...]
    not_violated: tuple[str, ...]
    findings: tuple[Finding, ...]
    failures: tuple[str, ...]
    never_entered: tuple[str, ...]
    requirements: tuple[RequirementVerdict, ...]
    abstracted: tuple[str, ...] = ()
    outcomes: tuple[CoveragePlace, ...] = ()
    is_interrupted: bool = False
    revision: RevisedEverywhere | None = None

    @property
    def not_exercised(self) -> tuple[RequirementVerdict, ...]:
        """The requirements of which the exploration shows nothing, and that do not allow it."""
        return tuple(entry for entry in self.requirements if entry.verdict == "not exercised")

    @property
    def endings(self) -> list[str]:
        """The failures: the outcomes of a node in one text, others as they are."""
        outcomes: dict[str, list[str]] = {}
        for reason in self.failures:
            of_node = _OUTCOME.match(reason)
            node, outcome = of_node.groups() if of_node else (reason, "")
            outcomes.setdefault(node, []).append(outcome)
        return [
            f"{node} {', '.join(dict.fromkeys(names))}".rstrip() for node, names in outcomes.items()
        ]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        data = {
            "mission": self.mission,
            "exhaustive": self.exhaustive,
            "why_not": list(self.why_not),
            "faults": self.faults,
            "states": self.states,
            "paths": self.paths,
            "proved": list(self.proved),
            "not_violated": list(self.not_violated),
            "findings": [entry.as_dict() for entry in self.findings],
            "ends_mission": list(self.failures),
            "never_entered": list(self.never_entered),
            "abstracted": list(self.abstracted),
            "requirements": [asdict(entry) for entry in self.requirements],
        }
        if self.revision is not None:
            data["revision"] = self.revision.as_dict()
        if self.outcomes:
            data["tree"] = [
                {"node": place.label, "reached": _reached(place), "missing": place.missing}
                for place in self.outcomes
            ]
        return data

    def __str__(self) -> str:
        bound = "any number of" if self.faults is None else "at most"
        faults = "faults" if self.faults is None else counted(self.faults, "fault")
        counts = f"{counted(self.states, 'state')}, {counted(self.paths, 'end')}"
        lines = [f"{self.mission}: {counts}, for all runs with {bound} {faults}"]
        lines += [f"  not exhaustive: {why}" for why in self.why_not]
        lines += [f"  abstract: {text}" for text in self.abstracted]
        lines += [f"  proved: {name}: {PROPERTIES[name]}" for name in self.proved]
        lines += [f"  not violated: {name}: {PROPERTIES[name]}" for name in self.not_violated]
        lines += [f"  never entered: '{name}'" for name in self.never_entered]
        lines += [f"  ends the mission: {reasons}" for reasons in self.endings]
        lines += [f"  {entry}" for entry in self.requirements]
        text = "\n".join(map(escape_control, lines))
        revision = [] if self.revision is None else [str(self.revision)]
        return "\n".join([text, *revision, *map(str, self.findings)])


def _reached(place: CoveragePlace) -> list[str]:
    return [name for part in (place.outcomes, place.branches) for name in part if part[name]]


def prove(
    mission: Mission,
    options: ProofOptions | None = None,
    elapsed_s: Callable[[], float] = float,
    on_progress: Callable[[ExplorationProgress], bool] = lambda _: True,
) -> Proof:
    """Visit the states of a mission, and say which properties hold.

    Args:
        mission: Without errors (``examine``).
        options: What is considered.
        elapsed_s: Returns the seconds of processor time that have passed, for the budget.
        on_progress: Called now and then; False ends the exploration.

    Raises:
        BtMissionError: When the mission cannot be set up, such as an unknown type.
    """
    options = options or ProofOptions()
    try:
        return _proved(mission, options, elapsed_s, on_progress, learns=True)
    except DivergedError:
        return _proved(mission, options, elapsed_s, on_progress, learns=False)


def _proved(
    mission: Mission,
    options: ProofOptions,
    elapsed_s: Callable[[], float],
    on_progress: Callable[[ExplorationProgress], bool],
    *,
    learns: bool,
) -> Proof:
    """Return the result. Raises DivergedError where known steps lead to what no run shows."""
    claims, environment = Claims(), options.environment(mission)
    revision = None
    if options.revision is not None:
        revision = RevisedEverywhere()
        claims = RevisionClaims(mission, options.revision, revision)
    record = None
    if options.with_outcomes:
        record = CoverageRecord.attach(mission, environment.executive)
    explored = explore(environment, claims, options.bounds, elapsed_s, on_progress, learns=learns)
    claims.finish(
        explored,
        are_samples=bool(environment.cases.sampled),
        is_abstract=environment.has_loose_deadlines or bool(environment.opened),
    )
    if revision is not None:
        revision.find_ways(lambda state: _steps_to(state, explored, mission, options))
    never = tuple(claims.never_entered(environment))
    findings = [
        _finding(broken, explored, mission, options, is_checked=learns)
        for broken in claims.broken.values()
    ]
    why_not = [explored.why_not] if explored.why_not else []
    why_not += [
        f"'{name}' is repeated {environment.rounds or ROUNDS_OF_CUT} times instead of {count:,} "
        "(--rounds)"
        for name, count in environment.cut.items()
    ]
    why_not += [f"not all values are tried: {text}" for text in environment.cases.sampled]
    widened = None
    is_timed = bool(explored.beside or environment.delayed)
    is_narrow = is_timed or bool(environment.cases.without_extremes)
    if is_narrow and not why_not:
        widened = _widened(mission, options, elapsed_s, on_progress, is_untimed=is_timed)
    if never and not why_not:
        findings += _dead_nodes(
            mission, options, elapsed_s, on_progress, learns=learns, is_timed=is_timed
        )
    broken_names = {entry.property for entry in findings}
    considered = set(PROPERTIES) - (set() if options.with_interrupts else {"interrupt"})
    considered.discard("requirement")
    moved = {"base", *environment.moved_parts}
    considered -= {name for part, name in ONE_GOAL.items() if part not in moved}
    if never:
        considered.discard("dead_node")
    unbroken = tuple(name for name in PROPERTIES if name in considered and name not in broken_names)
    unproved = frozenset(claims.unproved)
    if environment.has_loose_deadlines:
        unproved |= OF_SOME_RUN
    if why_not:
        unproved = frozenset(unbroken)
    elif is_narrow:
        unproved |= _unproved_by(widened, unbroken)
    why_not += _left_out(explored, environment) if explored.is_exhaustive else ()
    return Proof(
        mission=mission.name,
        exhaustive=not why_not,
        why_not=tuple(why_not),
        faults=None if math.isinf(options.faults) else int(options.faults),
        states=explored.progress.states,
        paths=explored.progress.paths,
        proved=tuple(name for name in unbroken if name not in unproved),
        not_violated=tuple(name for name in unbroken if name in unproved)
        if explored.is_exhaustive
        else (),
        findings=tuple(findings),
        failures=tuple(claims.failures),
        never_entered=never,
        requirements=tuple(
            _verdict(
                entry,
                environment,
                findings,
                claims,
                explored,
                is_proved=not why_not or _holds_widened(widened, entry),
            )
            for entry in options.all_requirements(mission)
        ),
        abstracted=tuple(environment.abstracted),
        outcomes=record.places if record is not None else (),
        is_interrupted=explored.why_not == "interrupted",
        revision=revision,
    )


def _left_out(explored: Explored, environment: Environment) -> Iterator[str]:
    """Yield which numbers and which instants of answers were not taken."""
    for name in environment.cases.without_extremes:
        extremes = f"NaN, infinite or beyond 1e12 of {name}"
        yield f"not all values are tried: {extremes}, without a fault left"
    if explored.beside:
        what = f"{listed(explored.beside)} {'is' if len(explored.beside) == 1 else 'are'} running"
        yield f"not all instants are taken: of answers that come while {what}"
    if environment.delayed:
        after = f"{listed(environment.delayed)} behind {counted(MOST_DELAYS, 'other event')}"
        yield f"not all instants are taken: of answers of {after}"


def _widened(
    mission: Mission,
    options: ProofOptions,
    elapsed_s: Callable[[], float],
    on_progress: Callable[[ExplorationProgress], bool],
    *,
    is_untimed: bool,
) -> Claims | None:
    """Return what is violated where extreme numbers cost no fault; None if that is open.

    Args:
        is_untimed: May every limit be over at any tick, too? All orders of instants are among
            those. So what holds in all of them holds in all runs.
    """
    claims = Claims()
    environment = options.environment(mission, is_untimed=is_untimed, are_extremes_free=True)
    try:
        explored = explore(environment, claims, options.bounds, elapsed_s, on_progress)
    except DivergedError:
        return None
    is_whole = explored.is_exhaustive and not environment.cut and not environment.cases.sampled
    return claims if is_whole else None


def _unproved_by(widened: Claims | None, names: Sequence[str]) -> frozenset[str]:
    """Return the properties that an exploration of more than all runs does not prove."""
    if widened is None:
        return frozenset(names)
    broken = {entry.name for entry in widened.broken.values()}
    return (frozenset(names) & broken) | (OF_SOME_RUN - {"dead_node"})


def _holds_widened(widened: Claims | None, requirement: Requirement) -> bool:
    if widened is None:
        return False
    return all(entry.requirement != requirement.name for entry in widened.broken.values())


def _verdict(
    requirement: Requirement,
    environment: Environment,
    findings: Sequence[Finding],
    claims: Claims,
    explored: Explored,
    *,
    is_proved: bool,
) -> RequirementVerdict:
    name = requirement.name
    if name in environment.requirements.needs_physics:
        why = environment.requirements.needs_physics[name]
        return RequirementVerdict(name, "needs physics", why)
    if any(entry.requirement == name for entry in findings):
        return RequirementVerdict(name, "violated")
    if not explored.is_exhaustive:
        return RequirementVerdict(name, "open")
    for premise in premises_of(root_of(requirement)):
        if (name, premise) not in claims.met:
            return RequirementVerdict(name, vacuous_verdict(requirement), premise.why_not)
    return RequirementVerdict(name, "proved" if is_proved else "not violated")


def _finding(
    broken: Broken,
    explored: Explored,
    mission: Mission,
    options: ProofOptions,
    *,
    is_checked: bool,
) -> Finding:
    way, environment = explored.way_to(broken.state), options.environment(mission)
    steps = [line for words in replay(environment, way) for line in words]
    if is_checked and environment.shape != explored.digest_of(broken.state):
        raise DivergedError
    name = name_of(broken, steps)
    return Finding(
        name,
        broken.node,
        broken.text,
        tuple(steps),
        tuple(way),
        broken.requirement,
        _paths(_nodes_of(broken, environment), environment),
        broken,
    )


def _nodes_of(broken: Broken, environment: Environment) -> list[str]:
    """Return the names of the nodes that a finding is about, where it shows."""
    running = [leaf.name for leaf in environment.executive.running_leaves]
    return list(broken.nodes) or list(filter(None, [broken.node])) or running


def _paths(names: Sequence[str], environment: Environment) -> tuple[str, ...]:
    executive = environment.executive
    return tuple(executive.path_of(node) for node in executive.nodes if node.name in names)


def _steps_to(
    state: int, explored: Explored, mission: Mission, options: ProofOptions
) -> tuple[str, ...]:
    way = explored.way_to(state)
    return tuple(line for words in replay(options.environment(mission), way) for line in words)


def _dead_nodes(
    mission: Mission,
    options: ProofOptions,
    elapsed_s: Callable[[], float],
    on_progress: Callable[[ExplorationProgress], bool],
    *,
    learns: bool,
    is_timed: bool,
) -> list[Finding]:
    """Look for ways with more faults into the nodes that none has entered."""
    faults = options.faults + MORE_FAULTS
    claims, environment = Claims(), options.environment(mission, faults)

    def is_wanted(progress: ExplorationProgress) -> bool:
        return on_progress(progress) and len(claims.entered) < len(environment.executive.nodes)

    explored = explore(environment, claims, options.bounds, elapsed_s, is_wanted, learns=learns)
    if not explored.is_exhaustive or environment.cut or environment.cases.sampled:
        return []
    bound = "" if faults == UNBOUNDED else f" with at most {faults:g} faults"
    return [
        Finding(
            "dead_node",
            name,
            f"no way{bound} enters '{name}'" + (", of the instants that are taken" * is_timed),
            (),
            nodes=_paths([name], environment),
        )
        for name in claims.never_entered(environment)
    ]
