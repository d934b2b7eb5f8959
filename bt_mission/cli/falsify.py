"""``bt-mission falsify``: search for a scenario that breaks a mission."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli.argument_types import count, seed, whole
from bt_mission.cli.check import permissions_of
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import (
    add_fault_option,
    add_mission_file,
    add_python_option,
    add_require_option,
    add_set_option,
    mission_file,
)
from bt_mission.cli.run import announce, leaving_at_once
from bt_mission.cli.workers import (
    add_worker_options,
    is_alone,
    pool_for,
    refuse_worker_options,
)
from bt_mission.core.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.search.result import FoundFiles
    from bt_mission.search.search import SearchState
    from bt_mission.search.session import SearchSession
    from bt_mission.sweeps.base import BaseScenario

AIMS = ("violated", "failed", "orphaned", "collision", "anything")
STRATEGIES = ("random", "optuna", "cma")
DEFAULT_STRATEGY = "random"

EPILOG = """\
examples:
  bt-mission falsify explore                    is there a run that violates a requirement?
  bt-mission falsify explore --find collision   ... in which the robot touches something?
  bt-mission falsify mine.yaml --require safe.yaml --within ranges.yaml --budget 200

a file of ranges, in which everything may be left out (docs/reference/search.md):
  seeds: 0..999
  worlds: [dqn_stage1, dqn_stage4]
  inputs: {speed: 0.1..0.26}
  start: anywhere
  obstacles: {most: 1, ahead: 0.8..2}
  faults: {most: 2, kinds: [network, lidar_dead], times: 0..20}

exit codes: 0 nothing was found, 1 something was, 2 bad input, 130 interrupted: what was found so
far is written
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "falsify",
        help="search for a scenario that breaks a mission",
        description="Runs a mission with other seeds, obstacles that appear, and faults at their "
        "times, until a requirement is violated, the mission fails, a goal is orphaned or the "
        "robot touches something. What is found is made small: fewest faults, roundest numbers, "
        "shortest run, each step checked by running it. The result is a folder with a scenario, a "
        "test that fails until the mission is mended, a recording and its report.",
        epilog=EPILOG,
    )
    add_mission_file(parser)
    _add_search_options(parser)
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
        help="where the result is written (default: found/NAME)",
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
        help="so many runs at most (default: 1000), besides those that make a find small",
    )
    parser.add_argument(
        "--find",
        choices=AIMS,
        help="what to search for (default: a violated requirement; in a mission without any, "
        "anything)",
    )
    parser.add_argument(
        "--within", type=Path, metavar="RANGES.yaml", help="what may vary, and by how much"
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
        help="so many runs at most to make a find small, 0 to leave it (default: 150)",
    )


def falsify(options: argparse.Namespace) -> int:
    """Search; gives the exit code."""
    with leaving_at_once():
        return _falsify(options)


def _falsify(options: argparse.Namespace) -> int:
    if not is_alone(options):
        refuse_worker_options(options)
    import asyncio

    announce(f"loading {options.file}, starting the simulation")
    from bt_mission.core.dds.middleware import prepare_middleware
    from bt_mission.core.interrupts import InterruptSignals
    from bt_mission.search.ranges import read_ranges
    from bt_mission.search.session import SearchOptions, SearchSession, aim_of, load_search

    ranges = read_ranges(options.within)
    base = load_search(mission_file(options), _changes(options), ranges, options.find)
    folder = _folder(options, base)
    prepare_middleware()
    wanted = SearchOptions(
        aim_of(base, options.find),
        options.budget,
        options.strategy,
        options.search_seed,
        options.simplify,
    )
    with InterruptSignals(most=1) as interrupts:
        progress = Progress(options.budget)
        session = SearchSession(
            base,
            ranges,
            wanted,
            lambda state: progress.show(state) and not interrupts.count,
        )
        asyncio.run(_carry_out(session, options))
        progress.end()
    return _tell(session, folder, options)


async def _carry_out(session: SearchSession, options: argparse.Namespace) -> None:
    if is_alone(options):
        from rclpy.logging import LoggingSeverity, set_logger_level

        from bt_mission.sweeps.runner import SerialRunner
        from bt_mission.sweeps.work import ScenarioWorker

        # What thousands of broken runs warn of would bury the progress; the recording has it.
        set_logger_level("", LoggingSeverity.FATAL)
        with ScenarioWorker(session.base.bundle) as worker:
            await session.run(SerialRunner(worker))
        return
    async with pool_for(options, session.base.bundle) as pool:
        await session.run(pool)


def _changes(options: argparse.Namespace) -> Any:
    from bt_mission.sweeps.base import BaseChanges, requirements_in_files

    return BaseChanges(
        set=dict(options.set),
        requirements=requirements_in_files(options.require),
        faults=options.fault,
        world=options.world,
        robot=options.robot,
        permissions=permissions_of(options),
    )


def _folder(options: argparse.Namespace, base: BaseScenario) -> Path:
    """Return where the result goes.

    Raises:
        BtMissionError: Where something else is there already.
    """
    stem = base.path.name.removesuffix(".yaml").removesuffix(".scenario")
    folder: Path = options.output or Path("found") / stem
    if folder.exists() and not folder.is_dir():
        raise BtMissionError(f"{folder}: is a file; name a folder with -o")
    if folder.is_dir() and any(folder.iterdir()):
        raise BtMissionError(f"{folder}: holds something already; name another folder with -o")
    return folder


class Progress:
    """The line on standard error that says how far a search is.

    Args:
        budget: Runs at most.
    """

    def __init__(self, budget: int) -> None:
        from bt_mission.core.wall_clock import Stopwatch

        self._budget = budget
        self._watch = Stopwatch()
        self._is_terminal = sys.stderr.isatty()
        self._next_s = 0.0

    def show(self, state: SearchState) -> bool:
        """Show it, at most a few times a second; on what is no terminal, every ten seconds."""
        elapsed_s = self._watch.elapsed_s
        if elapsed_s >= self._next_s:
            self._next_s = elapsed_s + (0.2 if self._is_terminal else 10.0)
            end = "" if self._is_terminal else "\n"
            start = "\r\033[K" if self._is_terminal else ""
            print(f"{start}{self._line(state, elapsed_s)}", end=end, file=sys.stderr, flush=True)
        return True

    def end(self) -> None:
        """Leave the line."""
        if self._is_terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def _line(self, state: SearchState, elapsed_s: float) -> str:
        runs = state.runs + state.simplifying_runs
        rate = f"{runs / elapsed_s:.1f} runs a second" if elapsed_s > 1 else ""
        if state.found:
            size = len(state.found.candidate.faults)
            faults = "1 fault" if size == 1 else f"{size} faults"
            what = f"found; made smaller in {state.simplifying_runs} runs, now {faults}"
        else:
            margin = "" if state.smallest is None else smallest(state.smallest)
            what = f"{state.runs} of {self._budget} runs{margin and ', '}{margin}"
        return ", ".join(filter(None, (what, rate)))


def smallest(found: tuple[float, str]) -> str:
    """Return the smallest margin in words."""
    share, name = found
    return f"smallest margin {share:.0%} of the usual one ('{name}')"


def _tell(session: SearchSession, folder: Path, options: argparse.Namespace) -> int:
    """Write what was found, and say it; gives the exit code."""
    from bt_mission.search.result import write_found

    state = session.state
    files = write_found(session.base, state.found, folder) if state.found else None
    if options.json:
        print(json.dumps(_as_dict(session, files, options)))
    else:
        print("\n".join(_lines(session, files)))
    if state.is_interrupted:
        return INTERRUPTED
    return MISSION_FAILED if state.found else SUCCESS


def _as_dict(
    session: SearchSession, files: FoundFiles | None, options: argparse.Namespace
) -> dict[str, Any]:
    state = session.state
    told: dict[str, Any] = {
        "mission": session.base.mission.name,
        "searched_for": session.aim,
        "strategy": options.strategy,
        "search_seed": options.search_seed,
        "budget": options.budget,
        "runs": state.runs,
        "errors": state.errors,
        "interrupted": state.is_interrupted,
        "smallest_margin": None
        if state.smallest is None
        else {"share": state.smallest[0], "requirement": state.smallest[1]},
        "found": None,
    }
    if files is not None and state.found is not None:
        told["found"] = {
            "kind": state.found.failure.kind,
            "what": state.found.failure.what,
            "sentence": files.sentence,
            "faults": [one.text for one in state.found.candidate.faults],
            "simplifying_runs": state.simplifying_runs,
            "repeats": files.repeats,
            "trace_sha256": state.found.row.trace_sha256,
            "folder": str(files.folder),
            "scenario": str(files.scenario),
            "test": str(files.test),
            "recording": str(files.recording),
            "report": str(files.report),
        }
    return told


def _lines(session: SearchSession, files: FoundFiles | None) -> list[str]:
    state = session.state
    told: list[str] = []
    errors = f"; {state.errors} could not run: {state.first_error}" if state.errors else ""
    if files is None:
        what = "interrupted" if state.is_interrupted else f"nothing found ({SOUGHT[session.aim]})"
        runs = "1 run" if state.runs == 1 else f"{state.runs} runs"
        told.append(f"{session.base.mission.name}: {what} in {runs}{errors}")
        if state.smallest is not None:
            told.append(f"  {smallest(state.smallest)}")
        return told
    told.append(f"{session.base.mission.name}: {files.sentence}")
    if state.runs == 1:
        told.append("  it breaks as it is, with nothing varied: there is nothing to search for")
    else:
        told.append(f"  found in {state.runs} runs, made small in {state.simplifying_runs}{errors}")
    if not files.repeats:
        told.append("  the run of the file has another trace than the one of the search")
    told += [
        f"  {files.scenario}: bt-mission run repeats it",
        f"  {files.test}: fails until the mission is mended",
        f"  {files.recording}, {files.report}: the run",
    ]
    return told


SOUGHT = {
    "violated": "no violated requirement",
    "failed": "no mission that fails",
    "orphaned": "no orphaned goal",
    "collision": "no collision",
    "anything": "no violated requirement, failed mission, orphaned goal or collision",
}
