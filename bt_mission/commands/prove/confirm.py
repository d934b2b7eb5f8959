"""A finding as a scenario with scripted servers, its test, and its run on the stage."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bt_mission.base.actions import moved_part
from bt_mission.base.diagnostics import listed
from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import make_folder_of, write_file
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.commands.prove.claims import ONE_GOAL
from bt_mission.commands.prove.played import played
from bt_mission.commands.prove.proof import Finding, ProofOptions, StagedFinding
from bt_mission.commands.prove.requirements import STATUSES
from bt_mission.language.mission import Mission
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.scenario import ScenarioResult
from bt_mission.scenarios.writer import mission_as_data

LONGEST_S = 100.0
"""A mission that runs for this long behind the end of a way counts as one without an end."""
BEHIND_S = 10.0
"""How long a run continues behind the end of a way that shows at once."""

MOST_SEEDS = 8
"""Number of seeds to try for a run with random draws."""

LONGEST_REASON = 80
"""Characters of a reason in a scenario, which takes patterns of 200."""

PART_OF = {name: part for part, name in ONE_GOAL.items()}
"""The parts that one goal at a time moves, by their property."""
CLEANED = "the clean-up runs"
ACCOUNTED = "the ledger holds the goal"
NO_RUN = {
    "dead_node": "no run shows that a node is never entered",
    "interrupt": "a run that does not end after Ctrl-C is not tried",
}
"""By property, why no run shows it."""
_PLACE = re.compile(r"^\S+:\d+:\d+: ")


@dataclass(frozen=True)
class Confirmation:
    """The expected result of a scenario, and how its run confirms the finding.

    Attributes:
        expect: Part of the scenario.
        requirements: Part of the scenario.
        limit_s: The run ends this many seconds behind the end of the way; None for the usual.
        has_open_goals: Do goals that the way leaves open never end?
        why_not: Why a run that does not show it decides nothing; "" if it does.
    """

    shows: Callable[[ScenarioResult], bool]
    expect: Mapping[str, Any] = field(default_factory=dict)
    requirements: Mapping[str, str] = field(default_factory=dict)
    limit_s: float | None = None
    has_open_goals: bool = True
    why_not: str = ""


def check_of(finding: Finding) -> Confirmation:
    """Return the check of a finding.

    Raises:
        BtMissionError: No run shows it.
    """
    broken = finding.broken
    why = NO_RUN.get(finding.property, "no run shows it")
    match broken.name if broken is not None else "":
        case name if broken is not None and name in PART_OF:
            part = PART_OF[name]
            one_goal, actions = f"one goal at the {part}", broken.about.split()
            accepted = [f'accepted("{owner}")' for owner in dict.fromkeys(broken.nodes)]
            uncounted = [action for action in actions if moved_part(action) != part]
            return Confirmation(
                lambda result: one_goal in result.violated,
                requirements={
                    one_goal: f"never {' and '.join([f'goals_at_{part} > 1', *accepted])}"
                },
                limit_s=BEHIND_S,
                why_not=f"goals_at_{part} does not count {listed(uncounted)}" if uncounted else "",
            )
        case "requirement":
            return Confirmation(
                lambda result: finding.requirement in result.violated, limit_s=BEHIND_S
            )
        case "unset_variable" | "unhandled":
            pattern = _reason_of(finding)
            return Confirmation(
                lambda result: re.search(pattern, result.report.reason) is not None,
                expect={"reason": f"^(?!.*{pattern})"},
            )
        case "ends" if finding.property == "ends":
            is_cycle = broken is not None and broken.about == "cycle"
            return Confirmation(
                lambda result: result.report.status == "interrupted",
                limit_s=LONGEST_S,
                has_open_goals=not is_cycle,
            )
        case "cleanup" if finding.property == "cleanup":
            cleanup = f"{finding.nodes[0]}.1"
            has_run = " or ".join(f'{word}("{cleanup}")' for word in STATUSES)
            return Confirmation(
                lambda result: CLEANED in result.violated,
                requirements={CLEANED: f"eventually {has_run}"},
                limit_s=BEHIND_S,
            )
        case "goals_accounted" if finding.property == "goals_accounted":
            owner = finding.nodes[0]
            return Confirmation(
                lambda result: ACCOUNTED in result.violated,
                requirements={ACCOUNTED: f'never accepted("{owner}") and open_goals < 1'},
                limit_s=BEHIND_S,
                why_not="a run shows a lost goal only while its leaf waits for it",
            )
    raise BtMissionError(why, code="BT-713")


def _added(finding: Finding, options: ProofOptions) -> dict[str, str]:
    """Return the requirement of a finding, where the mission does not have it."""
    return {
        entry.name: entry.text
        for entry in options.requirements
        if entry.name == finding.requirement
    }


def _reason_of(finding: Finding) -> str:
    """Return a regular expression for the reason of a mission that ends by an error."""
    if finding.property == "unset_variable" and finding.broken is not None:
        return rf"'\$?{re.escape(finding.broken.about)}' has no value"
    reason = finding.text.removeprefix("the mission ends: ")
    return re.escape(_PLACE.sub("", reason)[:LONGEST_REASON])


def scenario_data(
    finding: Finding, mission: Mission, options: ProofOptions, folder: Path
) -> dict[str, Any]:
    """Return the scenario of a finding.

    Args:
        options: Those of the exploration.
        folder: Where it will be written; paths in it are relative to that.

    Raises:
        BtMissionError: It holds what no scenario expresses.
    """
    check = check_of(finding)
    way = played(lambda: options.environment(mission), finding.way)
    if way.others:
        raise BtMissionError(f"a scenario does not script: {way.others[0]}", code="BT-713")
    limit_s = None if check.limit_s is None else way.end_s + check.limit_s
    parts: dict[str, Any] = {
        "scenario": f"{mission.name}: {finding.property}",
        "description": _line(finding.text),
        **mission_as_data(mission, folder),
        "faults": way.faults,
        "servers": way.servers(ends_open_goals=not check.has_open_goals),
        "requirements": {**_added(finding, options), **check.requirements},
        "limit": way.interrupt_s if limit_s is None else limit_s,
        "expect": {"outcome": "any", "orphaned_goals": "any", **check.expect},
    }
    if check.limit_s == LONGEST_S:
        parts["expect"]["before"] = parts["limit"] = limit_s
    return {name: value for name, value in parts.items() if value}


def confirmed(
    findings: Sequence[Finding],
    mission: Mission,
    options: ProofOptions,
    folder: Path,
    run: Callable[[Path], ScenarioResult] = run_scenario,
) -> Iterator[Finding]:
    """Write each finding as a scenario and a test into a folder, run it, and add what it shows.

    Args:
        findings: Of the mission.
        mission: The mission.
        options: Those of the exploration.
        folder: For the files.
        run: Runs a scenario.

    Raises:
        BtMissionError: A file cannot be written.
    """
    names: set[str] = set()
    for finding in findings:
        name = _name(mission.name, finding, names)
        try:
            data = scenario_data(finding, mission, options, folder)
        except BtMissionError as error:
            yield replace(finding, stage=StagedFinding(why_not=str(error)))
            continue
        yield replace(finding, stage=_run(finding, data, mission, options, folder / name, run))


def _run(
    finding: Finding,
    data: Mapping[str, Any],
    mission: Mission,
    options: ProofOptions,
    stem: Path,
    run: Callable[[Path], ScenarioResult],
) -> StagedFinding:
    """Write the files of a finding, and run them; of random draws, with several seeds."""
    check, way = check_of(finding), played(lambda: options.environment(mission), finding.way)
    environment = way.environment
    has_draws = bool(environment.scope.generators)
    seeds = [{}, *({"seed": seed} for seed in range(MOST_SEEDS))] if has_draws else [{}]
    for seed in seeds:
        files = _written(finding, {**data, **seed}, stem)
        try:
            result = run(Path(files.scenario))
        except BtMissionError as error:
            return replace(files, why_not=f"it cannot run: {error}")
        if check.shows(result):
            return replace(files, is_confirmed=True)
    abstract = [*environment.abstracted, *(f"'{name}' is cut" for name in environment.cut)]
    abstract += [*way.doubts, *filter(None, [check.why_not])]
    if has_draws:
        abstract.append(f"it needs other random draws than those of {MOST_SEEDS} seeds")
    if abstract:
        _written(finding, data, stem)
        return replace(files, why_not=abstract[-1])
    return replace(files, is_confirmed=False)


def _written(finding: Finding, data: Mapping[str, Any], stem: Path) -> StagedFinding:
    """Write the scenario."""
    scenario = stem.with_name(f"{stem.name}.scenario.yaml")
    make_folder_of(scenario)
    lines = [f"{finding.property}: {finding.text}"]
    lines += [f"{number}. {step}" for number, step in enumerate(finding.steps, 1)]
    wrapped = [line for whole in lines for line in textwrap.wrap(_line(whole), 90)]
    comment = "\n".join(f"# {line}" for line in wrapped)
    write_file(scenario, f"{comment}\n#\n#   bt-mission run {scenario.name}\n\n{to_yaml(data)}")
    return StagedFinding(scenario=str(scenario))


def _name(mission: str, finding: Finding, names: set[str]) -> str:
    """Return a new name for files."""
    stem = re.sub(r"\W+", "_", f"{mission}_{finding.property}").strip("_")
    name, number = stem, 1
    while name in names:
        number += 1
        name = f"{stem}_{number}"
    names.add(name)
    return name


def _line(text: str) -> str:
    return " ".join(escape_control(text).split())
