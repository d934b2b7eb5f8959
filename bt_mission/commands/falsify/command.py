"""``bt-mission falsify``: search for a scenario that breaks a mission."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Coroutine
from dataclasses import replace
from itertools import chain
from itertools import count as numbers
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import RUNS
from bt_mission.base.text import counted
from bt_mission.cli.argument_types import count, input_file, whole
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import (
    FAULT,
    JSON,
    MISSION,
    NO_PYTHON,
    REQUIRE,
    ROBOT,
    SET,
    SIMULATOR,
    WORLD,
    announce,
    mission_file,
    nature_option,
)
from bt_mission.cli.outputs import refuse_used_folder
from bt_mission.cli.parser import Command, Option
from bt_mission.cli.workers import (
    WORKER_OPTIONS,
    base_changes,
    is_alone,
    pool_for,
    require_dask,
    run_interruptible,
    stop_at_signal,
)

if TYPE_CHECKING:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.commands.falsify.result import CounterexampleFiles
    from bt_mission.commands.falsify.search import Counterexample, SearchState
    from bt_mission.commands.falsify.session import SearchOptions, SearchSession
    from bt_mission.scenarios.concrete.base_scenario import BaseScenario
    from bt_mission.scenarios.concrete.ranges import RangesFile
    from bt_mission.scenarios.concrete.row import ScenarioRow
    from bt_mission.scenarios.concrete.worker import ScenarioRunner

SOUGHT = {
    "violated": "no violated requirement",
    "failed": "no mission that fails",
    "orphaned": "no orphaned goal",
    "collision": "no collision",
    "anything": "no violated requirement, failed mission, orphaned goal or collision",
}
"""Targets of a search, with the words for a search that found nothing."""

EPILOG = """\
examples:
  bt-mission falsify explore                    search for a violated requirement
  bt-mission falsify explore --find collision   ... for a collision
  bt-mission falsify mine.yaml --require safe.yaml --within ranges.yaml --budget 200
  bt-mission falsify mine.yaml --reference good.yaml --keep-going 5
                                                up to five causes that do not affect good.yaml

a file of ranges; every key is optional (bt-mission docs ranges):
  seeds: 0..999
  worlds: [dqn_stage1, dqn_stage4]
  inputs: {speed: 0.1..0.26}
  start: anywhere
  obstacles: {most: 1, ahead: 0.8..2}
  faults: {most: 2, kinds: [network, lidar_dead], times: 0..20}
  assume: [always clearance > 0.05]

exit codes: 0 nothing found, 1 counterexample found or a requirement not exercised in any run, 2 bad
input, 130 interrupted (counterexamples found until then are written)
"""


def falsify(options: argparse.Namespace) -> int:
    """Search; gives the exit code."""
    if not is_alone(options):
        require_dask()
    announce(f"loading {options.file}, starting the simulation")
    from bt_mission.base.dds.middleware import prepare_middleware
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.commands.falsify.session import load_search
    from bt_mission.requirements.checks import with_requirements
    from bt_mission.scenarios.concrete.base_scenario import load_base
    from bt_mission.scenarios.concrete.ranges import read_ranges

    ranges = read_ranges(options.within)
    path, changes = mission_file(options), base_changes(options)
    if options.require:  # what is wrong is told of their files, not of the scenario
        plain = load_base(path, replace(changes, requirements={}))
        with_requirements(plain.mission, options.require)
    base = load_search(path, changes, ranges, options.find)
    good = None
    if options.reference is not None:
        from bt_mission.commands.falsify.reference import load_reference

        good = load_reference(options.reference, base, ranges)
    folder = _folder(options, base)
    prepare_middleware()
    with InterruptSignals(most=1) as interrupts:
        session = _searched(base, good, ranges, options, interrupts)
    return _tell_search(session, folder, options)


def _searched(
    base: BaseScenario,
    good: BaseScenario | None,
    ranges: RangesFile,
    options: argparse.Namespace,
    interrupts: InterruptSignals,
) -> SearchSession:
    """Search; gives what it has come to."""
    from contextlib import ExitStack
    from functools import partial

    from bt_mission.commands.falsify.reference import Reference
    from bt_mission.commands.falsify.session import SearchSession
    from bt_mission.scenarios.concrete.worker import ScenarioWorker
    from bt_mission.scenarios.run import run_scenario
    from bt_mission.scenarios.runner import silence_logs
    from bt_mission.views.terminal.progress import ProgressDisplay

    def watch(state: SearchState) -> bool:
        if state.runs == 1 and session.as_it_is is not None:
            _warn_of(session.as_it_is)
        progress.show(state.runs)
        return not interrupts.count

    with ExitStack() as stack:
        reference = None
        if good is not None:
            silence_logs()
            run = partial(run_scenario, before_step=partial(stop_at_signal, interrupts))
            worker = stack.enter_context(ScenarioWorker(good.bundle, run))
            reference = Reference(good, worker)
        session = SearchSession(base, ranges, _search_options(options), watch, reference)
        progress = ProgressDisplay(
            base.mission.name,
            options.budget,
            lambda: (_search_notes(session.state), ()),
            sys.stderr,
            unit="runs",
        )
        stack.enter_context(progress)
        searching = _carry_out(base, session.run, options, interrupts)
        if run_interruptible(searching, interrupts):  # a run of a long mission takes minutes
            session.state.is_interrupted = True
    return session


def _search_options(options: argparse.Namespace) -> SearchOptions:
    from bt_mission.commands.falsify.session import SearchOptions

    return SearchOptions(
        options.find,
        options.budget,
        options.search_seed,
        options.simplify,
        options.keep_going,
    )


async def _carry_out(
    base: BaseScenario,
    search: Callable[[ScenarioRunner], Coroutine[Any, Any, None]],
    options: argparse.Namespace,
    interrupts: InterruptSignals,
) -> None:
    """Search with the workers that the options name."""
    if is_alone(options):
        from functools import partial

        from bt_mission.scenarios.concrete.worker import ScenarioWorker
        from bt_mission.scenarios.run import run_scenario
        from bt_mission.scenarios.runner import silence_logs

        silence_logs()
        run = partial(run_scenario, before_step=partial(stop_at_signal, interrupts))
        with ScenarioWorker(base.bundle, run) as worker:
            await search(worker)
        return
    async with pool_for(options, base.bundle) as pool:
        await search(pool)


def _folder(options: argparse.Namespace, base: BaseScenario) -> Path:
    """Return where the result goes: by default a folder that is not there yet.

    Raises:
        BtMissionError: Where something else is there already.
    """
    stem = base.path.name.removesuffix(".yaml").removesuffix(".scenario")
    if options.output is None:
        names = chain([stem], (f"{stem}_{number}" for number in numbers(2)))
        return next(path for name in names if not (path := Path("found") / name).exists())
    folder: Path = options.output
    refuse_used_folder(folder)
    return folder


def _warn_of(as_it_is: ScenarioRow) -> None:
    """Warn of a mission that does not succeed with nothing varied."""
    if as_it_is.outcome != "success":
        end = f"{as_it_is.outcome}: {as_it_is.reason}" if as_it_is.reason else as_it_is.outcome
        print(
            f"without any change, the mission ends in {end}; --find failed finds this in the "
            f"first run",
            file=sys.stderr,
        )


def _search_notes(state: SearchState) -> list[str]:
    """Return what a search has found so far."""
    notes = [f"causes found: {len(state.counterexamples)}"] if state.counterexamples else []
    if state.simplifying_runs:
        faults = ", ".join(
            str(len(counterexample.candidate.faults)) for counterexample in state.counterexamples
        )
        return [*notes, f"minimized in {state.simplifying_runs} runs, remaining faults: {faults}"]
    return notes if state.smallest is None else [*notes, _smallest(state.smallest)]


def _smallest(smallest: tuple[float, str]) -> str:
    """Return the smallest margin in words."""
    share, name = smallest
    return f"nearest to a violation: '{name}', {share:.0%} of its usual margin"


def _tell_search(session: SearchSession, folder: Path, options: argparse.Namespace) -> int:
    """Write what was found, and say it; gives the exit code."""
    from bt_mission.commands.falsify.result import sentence, write_all

    state = session.state
    try:
        files = write_all(
            session.base, state.counterexamples, folder, runs_again=not state.is_interrupted
        )
    except BtMissionError:
        for unsaved in state.counterexamples:
            words = sentence(unsaved.failure, None, unsaved.candidate)
            print(f"found: {words}", file=sys.stderr)
        raise
    if options.json:
        print(json.dumps(_search_as_dict(session, files, options)))
    else:
        print("\n".join(_search_lines(session, files)))
    if state.is_interrupted:
        return INTERRUPTED
    return MISSION_FAILED if state.counterexamples or state.unexercised else SUCCESS


def _search_as_dict(
    session: SearchSession, files: list[CounterexampleFiles], options: argparse.Namespace
) -> dict[str, Any]:
    state = session.state
    return {
        "mission": session.base.mission.name,
        "searched_for": session.aim,
        "search_seed": options.search_seed,
        "budget": options.budget,
        "runs": state.runs,
        "errors": state.errors,
        "outside_assumptions": state.outside,
        "broke_the_reference": state.unfair,
        "simplifying_runs": state.simplifying_runs,
        "interrupted": state.is_interrupted,
        "smallest_margin": None
        if state.smallest is None
        else {"share": state.smallest[0], "requirement": state.smallest[1]},
        "not_exercised": list(state.unexercised),
        "found": [_find_as_dict(*pair) for pair in zip(state.counterexamples, files, strict=True)],
    }


def _find_as_dict(counterexample: Counterexample, files: CounterexampleFiles) -> dict[str, Any]:
    return {
        "kind": counterexample.failure.kind,
        "what": counterexample.failure.what,
        "node": counterexample.failure.node,
        "reason": counterexample.failure.reason,
        "runs": counterexample.runs,
        "sentence": files.sentence,
        "faults": [fault.text for fault in counterexample.candidate.faults],
        "repeats": files.repeats,
        "trace_sha256": counterexample.row.trace_sha256,
        "folder": str(files.folder),
        "scenario": str(files.scenario),
        "recording": files.recording and str(files.recording),
        "report": files.report and str(files.report),
    }


def _search_lines(session: SearchSession, files: list[CounterexampleFiles]) -> list[str]:
    state = session.state
    lines: list[str] = []
    name = session.base.mission.name
    notes = f"; {state.errors} could not run: {state.first_error}" if state.errors else ""
    if state.outside:
        notes += f"; {state.outside} violated the assumptions"
    if state.unfair:
        notes += f"; {state.unfair} also broke the reference"
    runs = counted(state.runs, "run")
    if not files:
        what = "interrupted" if state.is_interrupted else f"nothing found ({SOUGHT[session.aim]})"
        lines.append(f"{name}: {what} in {runs}{notes}")
        if state.smallest is not None:
            lines.append(f"  {_smallest(state.smallest)}")
        lines += [f"  not exercised in any run: '{name}'" for name in state.unexercised]
        return lines
    if state.runs == 1:
        lines.append(f"{name}: {files[0].sentence}")
        lines.append("  it breaks without any change, so there was no search")
        return lines + _files_of(files[0])
    effort = f"found after {runs}, minimized in {state.simplifying_runs}{notes}"
    if len(files) == 1:
        return [f"{name}: {files[0].sentence}", f"  {effort}", *_files_of(files[0])]
    lines.append(f"{name}: {len(files)} causes {effort}")
    for number, (counterexample, file) in enumerate(
        zip(state.counterexamples, files, strict=True), 1
    ):
        lines += [
            f"{number}. {file.sentence} ({counted(counterexample.runs, 'run')})",
            *_files_of(file),
        ]
    return lines


def _files_of(files: CounterexampleFiles) -> list[str]:
    lines = []
    if files.repeats is False:
        lines.append("  the trace of the scenario file differs from the trace in the search")
    return [
        *lines,
        f"  {files.scenario}: bt-mission run repeats it",
        "  as a test of pytest it fails until the mission is fixed",
        f"  {files.recording}, {files.report}: the run"
        if files.recording
        else f"  not recorded, as the search was interrupted: bt-mission run {files.scenario} "
        f"--record FILE.mcap",
    ]


COMMANDS = {
    "falsify": Command(
        falsify,
        "Runs a mission with different seeds, appearing obstacles and timed faults until a "
        "requirement is violated, the mission fails, a goal is orphaned or the robot collides. "
        "Then minimizes the counterexample: fewest faults, roundest numbers, shortest run, each "
        "step checked by a run. Writes a folder with a scenario, which pytest collects as a test "
        "that fails until the mission is fixed, a recording and its report.",
        (
            MISSION,
            Option(
                "--budget RUNS",
                "maximum number of runs (default: 200), without those that minimize "
                "counterexamples",
                count,
                200,
            ),
            Option(
                "--find",
                "what to search for (default: a violated requirement; anything if the mission "
                "has no requirements)",
                choices=tuple(SOUGHT),
            ),
            Option(
                "--reference GOOD.yaml",
                "a correct mission; scenarios that also break this one do not count",
                input_file,
                takes=RUNS,
            ),
            Option(
                "--keep-going N",
                "continue until N different causes are found (default: 1)",
                count,
                1,
            ),
            Option(
                "--within RANGES.yaml",
                "a file with the ranges of what varies",
                input_file,
                takes=("ranges",),
            ),
            Option(
                "--search-seed SEED",
                "seed of the search; the same seed repeats it exactly (default: 0)",
                whole,
                0,
            ),
            Option(
                "--simplify RUNS",
                "maximum number of runs to minimize each counterexample, 0 for none (default: 150)",
                whole,
                150,
            ),
            nature_option("usual"),
            REQUIRE,
            FAULT,
            SET,
            WORLD,
            ROBOT,
            SIMULATOR,
            NO_PYTHON,
            Option(
                "-o --output FOLDER",
                "folder for the result (default: found/NAME, or found/NAME_2 if that exists)",
                Path,
            ),
            *WORKER_OPTIONS,
            JSON,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
