"""``bt-mission falsify``: search for a scenario that breaks a mission."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Coroutine
from dataclasses import replace
from itertools import chain
from itertools import count as numbers
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli import falsify_cover, falsify_results
from bt_mission.cli.argument_types import count, input_file, seed, whole
from bt_mission.cli.options import (
    add_fault_option,
    add_mission_file,
    add_nature_option,
    add_python_option,
    add_require_option,
    add_set_option,
    mission_file,
)
from bt_mission.cli.run import announce, leaving_at_once
from bt_mission.cli.workers import (
    add_worker_options,
    base_changes,
    is_alone,
    pool_for,
    refuse_worker_options,
)
from bt_mission.core.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.core.interrupts import InterruptSignals
    from bt_mission.search.search import SearchState
    from bt_mission.search.session import SearchSession
    from bt_mission.sweeps.base import BaseScenario
    from bt_mission.sweeps.ranges import RangesFile
    from bt_mission.sweeps.runner import ScenarioRunner

AIMS = ("violated", "failed", "orphaned", "collision", "anything")
STRATEGIES = ("optuna", "random")
DEFAULT_STRATEGY = "optuna"

EPILOG = """\
examples:
  bt-mission falsify explore                    is there a run that violates a requirement?
  bt-mission falsify explore --find collision   ... in which the robot touches something?
  bt-mission falsify explore --cover            what of its tree does no run reach?
  bt-mission falsify mine.yaml --require safe.yaml --within ranges.yaml --budget 200
  bt-mission falsify mine.yaml --reference good.yaml --keep-going 5
                                                up to five causes that good.yaml does not have

a file of ranges, in which everything may be left out (docs/reference/ranges.md):
  seeds: 0..999
  worlds: [dqn_stage1, dqn_stage4]
  inputs: {speed: 0.1..0.26}
  start: anywhere
  obstacles: {most: 1, ahead: 0.8..2}
  faults: {most: 2, kinds: [network, lidar_dead], times: 0..20}
  assume: [always clearance > 0.05]

exit codes: 0 nothing was found, 1 something was, 2 bad input, 130 interrupted: what was found so
far is written
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "falsify",
        description="Runs a mission with other seeds, obstacles that appear, and faults at their "
        "times, until a requirement is violated, the mission fails, a goal is orphaned or the "
        "robot touches something. What is found is minimized: fewest faults, roundest numbers, "
        "shortest run, each step checked by running it. The result is a folder with a scenario, a "
        "test that fails until the mission is fixed, a recording and its report.",
        epilog=EPILOG,
    )
    add_mission_file(parser)
    _add_search_options(parser)
    add_nature_option(parser, "usual")
    add_require_option(parser)
    add_fault_option(parser)
    add_set_option(parser)
    parser.add_argument("--world", help="a world's name or file instead of the mission's")
    parser.add_argument("--robot", help="a robot's name or file instead of the mission's")
    add_python_option(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="where the result is written (default: found/NAME, or else found/NAME_2)",
    )
    add_worker_options(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object at the end")
    parser.set_defaults(command=falsify)


def _add_search_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--budget",
        type=count,
        default=1000,
        metavar="RUNS",
        help="so many runs at most (default: 1000), besides those that minimize what is found",
    )
    parser.add_argument(
        "--find",
        choices=AIMS,
        help="what to search for (default: a violated requirement; in a mission without any, "
        "anything)",
    )
    parser.add_argument(
        "--cover",
        action="store_true",
        help="instead drive towards nodes, outcomes and branches of the tree that no run has "
        "reached, and list those that stay",
    )
    parser.add_argument(
        "--reference",
        type=input_file,
        metavar="GOOD.yaml",
        help="a mission that is good: what breaks it in the same scenario does not count",
    )
    parser.add_argument(
        "--keep-going",
        type=count,
        default=1,
        metavar="N",
        help="go on until N different causes are found (default: 1)",
    )
    parser.add_argument(
        "--within", type=input_file, metavar="RANGES.yaml", help="what may vary, and by how much"
    )
    parser.add_argument(
        "--strategy",
        choices=STRATEGIES,
        default=DEFAULT_STRATEGY,
        help=f"how scenarios are chosen (default: {DEFAULT_STRATEGY})",
    )
    parser.add_argument(
        "--search-seed",
        type=seed,
        default=0,
        metavar="SEED",
        help="another search; the same one repeats exactly (default: 0)",
    )
    parser.add_argument(
        "--simplify",
        type=whole,
        default=150,
        metavar="RUNS",
        help="the most runs that minimize each find, 0 to leave it (default: 150)",
    )


def falsify(options: argparse.Namespace) -> int:
    """Search; gives the exit code."""
    with leaving_at_once():
        return _falsify(options)


def _falsify(options: argparse.Namespace) -> int:
    if not is_alone(options):
        refuse_worker_options(options)
    if options.cover:
        for name in ("find", "output", "reference"):
            if getattr(options, name) is not None:
                raise BtMissionError(f"--cover lists what was reached: it has no --{name}")
        if options.keep_going != 1:
            raise BtMissionError("--cover lists what was reached: it has no --keep-going")
    announce(f"loading {options.file}, starting the simulation")
    from bt_mission.core.dds.middleware import prepare_middleware
    from bt_mission.core.interrupts import InterruptSignals
    from bt_mission.language.checks.requirements import with_requirements
    from bt_mission.search.session import load_search
    from bt_mission.sweeps.base import load_base
    from bt_mission.sweeps.ranges import read_ranges

    ranges = read_ranges(options.within)
    path, changes = mission_file(options), base_changes(options)
    if options.require:  # what is wrong is told of their files, not of the scenario
        plain = load_base(path, replace(changes, requirements={}))
        with_requirements(plain.mission, options.require)
    base = load_search(path, changes, ranges, options.find)
    good = None
    if options.reference is not None:
        from bt_mission.search.reference import load_reference

        good = load_reference(options.reference, base, ranges)
    folder = None if options.cover else _folder(options, base)
    prepare_middleware()
    with InterruptSignals(most=1) as interrupts:
        if folder is None:
            return _cover(base, ranges, options, interrupts)
        session = _searched(base, good, ranges, options, interrupts)
    return falsify_results.tell(session, folder, options)


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

    from bt_mission.cli.search_progress import SearchProgress
    from bt_mission.scenarios.run import run_scenario
    from bt_mission.scenarios.runner import silence_logs
    from bt_mission.search.reference import Reference
    from bt_mission.search.session import SearchOptions, SearchSession, aim_of
    from bt_mission.sweeps.runner import SerialRunner
    from bt_mission.sweeps.work import ScenarioWorker

    progress = SearchProgress()

    def watch(state: SearchState) -> bool:
        if state.runs == 1 and session.as_it_is is not None:
            falsify_results.warn_of(session.as_it_is)
        runs = state.runs + state.simplifying_runs
        progress.show(runs, lambda: falsify_results.progress_line(state, options.budget))
        return not interrupts.count

    wanted = SearchOptions(
        aim_of(base, options.find),
        options.budget,
        options.strategy,
        options.search_seed,
        options.simplify,
        options.keep_going,
    )
    with ExitStack() as stack:
        reference = None
        if good is not None:
            silence_logs()
            run = partial(run_scenario, before_step=_leaving(interrupts))
            worker = stack.enter_context(ScenarioWorker(good.bundle, run))
            reference = Reference(good, SerialRunner(worker))
        session = SearchSession(base, ranges, wanted, watch, reference)
        if _is_cut_short(base, session.run, options, interrupts):
            session.state.is_interrupted = True
    progress.end()
    return session


def _cover(
    base: BaseScenario,
    ranges: RangesFile,
    options: argparse.Namespace,
    interrupts: InterruptSignals,
) -> int:
    """Drive towards what was not reached; gives the exit code."""
    from bt_mission.cli.search_progress import SearchProgress
    from bt_mission.search.cover import CoverSession, CoverState

    progress = SearchProgress()

    def watch(state: CoverState) -> bool:
        progress.show(state.runs, lambda: falsify_cover.progress_line(state, options.budget))
        return not interrupts.count

    session = CoverSession(base, ranges, options.strategy, options.search_seed, watch)
    if _is_cut_short(base, lambda runner: session.run(runner, options.budget), options, interrupts):
        session.state.is_interrupted = True
    progress.end()
    return falsify_cover.tell(session, options)


def _is_cut_short(
    base: BaseScenario,
    search: Callable[[ScenarioRunner], Coroutine[Any, Any, None]],
    options: argparse.Namespace,
    interrupts: InterruptSignals,
) -> bool:
    """Search; tell whether a signal has ended that in the middle of a run.

    A run of a long mission takes minutes, and nobody waits for it.
    """
    import asyncio

    try:
        asyncio.run(_carry_out(base, search, options, _leaving(interrupts)))
    except asyncio.CancelledError:
        return True
    return False


def _leaving(interrupts: InterruptSignals) -> Callable[[], None]:
    """Return what cancels a search once there was a signal."""
    import asyncio

    def leave() -> None:
        if interrupts.count:
            raise asyncio.CancelledError

    return leave


async def _carry_out(
    base: BaseScenario,
    search: Callable[[ScenarioRunner], Coroutine[Any, Any, None]],
    options: argparse.Namespace,
    leave: Callable[[], None],
) -> None:
    """Search with the workers that the options name.

    Args:
        leave: Called often; raises where the search is to end.
    """
    if is_alone(options):
        from functools import partial

        from bt_mission.scenarios.run import run_scenario
        from bt_mission.scenarios.runner import silence_logs
        from bt_mission.sweeps.runner import SerialRunner
        from bt_mission.sweeps.work import ScenarioWorker

        silence_logs()
        with ScenarioWorker(base.bundle, partial(run_scenario, before_step=leave)) as worker:
            await search(SerialRunner(worker))
        return
    async with pool_for(options, base.bundle, on_wait=leave) as pool:
        leave()
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
    if folder.exists() and not folder.is_dir():
        raise BtMissionError(f"{folder}: is a file; name a folder with -o")
    if folder.is_dir() and any(folder.iterdir()):
        raise BtMissionError(f"{folder}: holds something already; name another folder with -o")
    return folder
