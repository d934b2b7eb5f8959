"""``bt-mission prove``: every answer that the servers of a mission may give."""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.file_kinds import MISSIONS, refuse_other_formats
from bt_mission.cli.argument_types import count, input_file, whole
from bt_mission.cli.checked import permissions_of
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import (
    JSON,
    MISSION,
    NO_PYTHON,
    REQUIRE,
    ROBOT,
    SET,
    WORLD,
    mission_file,
)
from bt_mission.cli.outputs import refuse_used_folder
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.commands.prove.explorer import Bounds, ExplorationProgress
    from bt_mission.commands.prove.proof import Proof, ProofOptions
    from bt_mission.language.mission import Mission
    from bt_mission.scenarios.scenario import ScenarioResult

EPILOG = """\
examples:
  bt-mission prove explore                      all runs with at most two faults of servers
  bt-mission prove explore --faults 0           ... in which every server answers as usual
  bt-mission prove mine.yaml --faults all       ... with any number of faults
  bt-mission prove mine.yaml --answers usual,turn:reject,*:late
                                                turn rejects no goal, and no server is late
  bt-mission prove mine.yaml --with interrupts  ... with Ctrl-C at any time
  bt-mission prove mine.yaml --require order.yaml
                                                ... with the requirements of a file
  bt-mission prove mine.yaml -o findings        save each finding as a scenario and a test
  bt-mission prove mine.yaml --budget 20000     at most 20000 states; 30s limits the time

exit codes: 0 no violation found, 1 a property does not hold, a requirement is not exercised or a
revision is refused in some state, 2 bad input, 130 interrupted
"""

_BUDGET = re.compile(r"(?P<number>[0-9]+)(?P<unit>s?)")
USUAL_MEMORY = 1000
PAGE = "proof.html"


def prove(options: argparse.Namespace) -> int:
    """Explore the mission; gives the exit code."""
    refuse_other_formats(mission_file(options), MISSIONS)
    if options.output is not None:
        refuse_used_folder(options.output)
    mission = _checked(options)
    proof_options = _proof_options(options, mission)
    if options.revision is not None:
        proof_options = replace(proof_options, revision=_other_version(options))
    proof = _proved(mission, proof_options, is_quiet=options.json)
    if (options.output or options.confirm) and not proof.is_interrupted:
        proof = _confirmed(proof, mission, proof_options, options.output)
    print(json.dumps(proof.as_dict()) if options.json else proof)
    if options.tree and not options.json:
        from bt_mission.commands.prove.outcomes import outcome_rows

        print(*outcome_rows(proof.outcomes, sys.stdout.encoding), sep="\n")
    if proof.is_interrupted:
        return INTERRUPTED
    if options.output is not None:
        print(f"the page: {options.output / PAGE}", file=sys.stderr)
    is_refused = proof.revision is not None and bool(proof.revision.refusals)
    fails = proof.findings or proof.not_exercised or is_refused
    return MISSION_FAILED if fails else SUCCESS


def _other_version(options: argparse.Namespace) -> Mission:
    """Load and check the version of `--revision`. Raises InputError with every error."""
    from bt_mission.language.loader import required
    from bt_mission.sessions.check import examine
    from bt_mission.sessions.goal_checks import OUR_SERVERS

    permissions = permissions_of(options)
    return required(examine(options.revision, servers=OUR_SERVERS, permissions=permissions))


def _checked(options: argparse.Namespace) -> Mission:
    """Load and check the mission; print the warnings. Raises InputError with every error."""
    from bt_mission.base.diagnostics import InputError
    from bt_mission.sessions.check import examine
    from bt_mission.sessions.goal_checks import OUR_SERVERS

    mission, diagnostics = examine(
        mission_file(options),
        set=dict(options.set),
        world=options.world,
        robot=options.robot,
        servers=OUR_SERVERS,
        permissions=permissions_of(options),
    )
    if mission is None:
        raise InputError(diagnostics)
    for warning in diagnostics:
        print(warning, file=sys.stderr)
    return mission


def _proof_options(options: argparse.Namespace, mission: Mission) -> ProofOptions:
    from bt_mission.commands.prove.answers import parse_answers
    from bt_mission.commands.prove.proof import ProofOptions
    from bt_mission.requirements.checks import MissionNames, read_requirements

    return ProofOptions(
        faults=options.faults,
        answers=parse_answers(options.answers),
        with_interrupts=options.considered == "interrupts",
        requirements=read_requirements(
            options.require, MissionNames(mission), {entry.name for entry in mission.requirements}
        ),
        rounds=options.rounds,
        bounds=_bounds(options),
        with_outcomes=options.tree or options.output is not None,
    )


def _bounds(options: argparse.Namespace) -> Bounds:
    from bt_mission.commands.prove.explorer import Bounds

    number, is_time = options.budget or (None, False)
    return Bounds(
        states=None if is_time else number,
        seconds=number if is_time else None,
        megabytes=options.memory,
    )


def _confirmed(proof: Proof, mission: Mission, options: ProofOptions, folder: Path | None) -> Proof:
    """Run each finding on the stage; keep its files where there is a folder for them."""
    from tempfile import TemporaryDirectory

    from bt_mission.commands.prove.confirm import confirmed
    from bt_mission.commands.prove.proof import StagedFinding

    if folder is not None:
        findings = tuple(confirmed(proof.findings, mission, options, folder, _reported))
        proof = replace(proof, findings=findings)
        _write_pages(proof, folder)
        return proof
    with TemporaryDirectory() as name:
        findings = tuple(
            replace(entry, stage=replace(entry.stage or StagedFinding(), scenario=""))
            for entry in confirmed(proof.findings, mission, options, Path(name))
        )
    return replace(proof, findings=findings)


def _reported(scenario: Path) -> ScenarioResult:
    """Run a scenario, and write the report of the run beside it."""
    from tempfile import TemporaryDirectory

    from bt_mission.cli.recorded_scenario import record_scenario
    from bt_mission.scenarios.loader import load_scenario
    from bt_mission.views.web.report.page import write_report

    loaded = load_scenario(scenario)
    with TemporaryDirectory() as name:
        recording = Path(name) / "run.mcap"
        result = record_scenario(loaded, recording)
        write_report(recording, _report_of(scenario))
    return result


def _report_of(scenario: Path) -> Path:
    return scenario.with_name(scenario.name.removesuffix(".scenario.yaml") + ".html")


def _write_pages(proof: Proof, folder: Path) -> None:
    """Write the page of a proof; keep the report of each run that shows whether a finding holds."""
    from bt_mission.base.output import make_folder_of, write_file
    from bt_mission.commands.prove.page import page_of

    runs = {}
    for number, finding in enumerate(proof.findings, 1):
        if finding.stage is None or not finding.stage.scenario:
            continue
        report = _report_of(Path(finding.stage.scenario))
        if finding.stage.is_confirmed is None:
            report.unlink(missing_ok=True)
        else:
            runs[number] = report.name
    page = folder / PAGE
    make_folder_of(page)
    write_file(page, page_of(proof, runs))


def _proved(mission: Mission, options: ProofOptions, *, is_quiet: bool) -> Proof:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.commands.prove import proof
    from bt_mission.commands.prove.explorer import ExplorationProgress as Explored
    from bt_mission.views.terminal import progress

    newest, watch = Explored(), Stopwatch()

    def notes() -> tuple[list[str], list[str]]:
        return [f"{newest.waiting:,} waiting", f"depth {newest.depth}"], []

    shown = progress.ProgressDisplay(
        mission.name, None, notes, sys.stderr, unit="states", quiet=is_quiet
    )

    def show(explored: ExplorationProgress) -> bool:
        nonlocal newest
        newest = explored
        shown.show(explored.states)
        return not interrupts.count

    with InterruptSignals(most=1) as interrupts, shown:
        return proof.prove(mission, options, lambda: watch.elapsed_s, show)


def _faults(text: str) -> float:
    """Read a bound on faults."""
    return float("inf") if text == "all" else float(whole(text))


def _budget(text: str) -> tuple[int, bool]:
    """Read a number of states, or of seconds."""
    collected = _BUDGET.fullmatch(text)
    if collected is None or int(collected["number"]) == 0:
        message = f"expected a number of states or of seconds such as 20000 or 30s, got '{text}'"
        raise argparse.ArgumentTypeError(message)
    return int(collected["number"]), bool(collected["unit"])


COMMANDS = {
    "prove": Command(
        prove,
        "Checks a mission against every answer that its servers can give: goals that are "
        "rejected, aborted, lost or late, refused cancels, services and topics without answers. "
        "It runs the real tree and executive without a simulation; the explored answers replace "
        "world and servers. Each property that does not hold is shown with a shortest sequence "
        "of answers that violates it.",
        (
            MISSION.but(
                help="the mission: a YAML file, an XML file of Groot 2, or the name of a shipped "
                "one",
                completes="missions",
                takes=MISSIONS,
            ),
            Option(
                "--faults K",
                "allow at most K faulty answers per run, or all (default: 2)",
                _faults,
                2.0,
            ),
            Option(
                "--answers ANSWERS",
                "usual answers, or all, with rare ones; exclude some after a comma, such as "
                "usual,turn:reject,*:late (default: usual)",
                default="usual",
            ),
            REQUIRE,
            Option(
                "--with WHAT",
                "also consider this: Ctrl-C at any time",
                choices=("interrupts",),
                dest="considered",
            ),
            Option(
                "--rounds N",
                "reduce counts of repeats above N to N, 0 for exact counts and deadlines (default: "
                "a repeat with a count above 10 can end after any round)",
                whole,
            ),
            Option(
                "--budget STATES|SECONDS",
                "stop after this number of states, or after a time such as 30s",
                _budget,
            ),
            Option(
                "--memory MB",
                f"stop when the states take this much memory (default: {USUAL_MEMORY})",
                count,
                USUAL_MEMORY,
            ),
            Option(
                "-o --output FOLDER",
                "write each finding as a scenario with scripted servers and a test, run it on the "
                "stage, and write a page of the result and one of each run",
                Path,
            ),
            Option("--tree", "show each node with the outcomes that some run reaches"),
            Option("--confirm", "run each finding on the stage, without files"),
            SET,
            WORLD,
            ROBOT,
            NO_PYTHON,
            Option(
                "--revision FILE",
                "try to change the running mission to this version in every state, and show the "
                "states in which that is refused",
                input_file,
                takes=MISSIONS,
                page="change-while-it-drives",
            ),
            JSON,
        ),
        EPILOG,
    )
}
