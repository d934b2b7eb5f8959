"""``bt-mission sweep``: many scenarios of one mission, on all processors or on a cluster."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import counted
from bt_mission.cli.argument_types import (
    above_zero,
    count,
    input_file,
    seeds,
    share,
    unchecked_output_file,
    whole,
)
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import (
    FAULT,
    JSON,
    MISSION,
    NO_PYTHON,
    PLAIN,
    REQUIRE,
    ROBOT,
    SET,
    SIMULATOR,
    WORLD,
    announce,
    confirm,
    mission_file,
    nature_option,
)
from bt_mission.cli.outputs import files_of, refuse_overwritten
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.workers import (
    WORKER_OPTIONS,
    base_changes,
    pool_for,
    require_dask,
    run_interruptible,
)
from bt_mission.commands.sweep.report_command import tell_results, write_page

if TYPE_CHECKING:
    from bt_mission.commands.sweep.plan import SweepPlan
    from bt_mission.commands.sweep.store import ResultStore
    from bt_mission.commands.sweep.summary import OutcomeCount, SweepTally
    from bt_mission.scenarios.concrete.row import ScenarioRow

MOST_UNASKED = 100_000
MOST_REASONS = 4
NO_WORKERS = (
    "all workers are gone; waiting for new ones; Ctrl-C stops the sweep, and --resume continues it"
)

EPILOG = """\
examples:
  bt-mission sweep explore --seeds 1000
  bt-mission sweep explore --seeds 50 --vary speed=0.1,0.2,0.26 --vary world=dqn_stage1,dqn_stage4
  bt-mission sweep explore --sample 500 --vary speed=0.05..0.26 --vary stopping_distance=0.3..0.8
  bt-mission sweep explore --sample 500 --within ranges.yaml
  bt-mission sweep explore --seeds 100 --fault-plan sensors.yaml -o sensors
  bt-mission sweep explore --seeds 1000 --resume          continue a stopped sweep
  bt-mission sweep explore --seeds 1000 --fail-below 0.95 for CI, at 95 % confidence
  bt-mission sweep explore --seeds 100000 --scheduler tcp://10.0.0.1:8786
  bt-mission sweep-report explore_sweep                   show the results at any time

parameters for --vary: inputs of the mission, world, robot, start.x and start.y (m), start.yaw
(degrees)

exit codes: 0 all scenarios ran, with any outcome; 1 success rate below --fail-below or too
uncertain, a scenario that could not run, or no workers; 2 bad input; 130 interrupted
"""


def sweep(options: argparse.Namespace) -> int:
    """Run the sweep; return the exit code."""
    require_dask()
    announce(f"loading {options.file}")
    from bt_mission.base.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.commands.sweep.repeat import origin_of
    from bt_mission.commands.sweep.store import ResultStore
    from bt_mission.commands.sweep.summary import SweepTally
    from bt_mission.commands.sweep.sweep import refuse_impossible

    plan = plan_of(options)
    refuse_overwritten(options, files_of(plan.base.mission))
    refuse_impossible(plan)
    _ask(options, plan)
    folder = options.output or Path(f"{plan.base.path.name.partition('.')[0]}_sweep")
    opened = ResultStore.resume if options.resume else ResultStore.create
    with opened(folder, plan.about) as store:
        line = shlex.join(["bt-mission", *options.words])
        origin_of(plan, line, str(options.file)).save(store)
        tally = SweepTally()
        for row in store.rows():
            if not (options.retry_errors and row.is_error):
                tally.add(row)
        why_stopped, code = "", SUCCESS
        try:
            with InterruptSignals(most=1) as interrupts:
                if run_interruptible(_carry_out(options, plan, store, tally), interrupts):
                    why_stopped, code = f"stopped by {interrupts.signal}", INTERRUPTED
        except BtMissionError as error:  # the workers are gone, or the disk is full
            why_stopped, code = error.headline, MISSION_FAILED
        is_told = _tell(options, store, plan.count, tally, why_stopped)
        return code or _judge(options, tally.count) or (SUCCESS if is_told else MISSION_FAILED)


def plan_of(options: argparse.Namespace) -> SweepPlan:
    """Read all that the options say.

    Raises:
        InputError: With what is wrong.
    """
    from bt_mission.commands.sweep.plan import SweepPlan
    from bt_mission.scenarios.concrete.base_scenario import load_base
    from bt_mission.scenarios.concrete.ranges import (
        parse_parameter,
        read_ranges,
        refuse_repeated,
        with_fault_plans,
    )

    path, file = mission_file(options), read_ranges(options.within)
    file.refuse_others("sweep")
    file.check_worlds(path)
    ranges = file.ranges
    varied = [parse_parameter(parameter) for parameter in options.vary]
    parameters = (*file.parameters, *file.start, *varied)
    refuse_repeated(parameters)
    limit = ranges.limit if options.limit is None else options.limit
    base = load_base(path, replace(base_changes(options), limit=limit), parameters)
    file.check_mission(base.mission)
    seeds = ranges.seeds if "seeds" in ranges.model_fields_set else None
    return SweepPlan(
        base,
        parameters,
        seeds if options.seeds is None else options.seeds,
        options.sample,
        options.sample_seed,
        with_fault_plans(ranges.plans, options.fault_plan),
    )


def _ask(options: argparse.Namespace, plan: SweepPlan) -> None:
    """Ask before a sweep that may be larger than was meant."""
    if plan.count <= MOST_UNASKED or options.yes:
        return
    confirm(
        f"{plan.count:,} scenarios",
        ". Continue?",
        otherwise=": confirm with --yes",
        refused="no scenario was run",
    )


async def _carry_out(
    options: argparse.Namespace, plan: SweepPlan, store: ResultStore, tally: SweepTally
) -> None:
    from bt_mission.commands.sweep.sweep import left, record, sweep, to_record
    from bt_mission.views.terminal.progress import ProgressDisplay, Remarks

    worst: Sequence[Any] = ()
    recorded = 0

    def is_done() -> bool:
        return next(left(plan, store, retry_errors=options.retry_errors), None) is None

    if is_done() and not to_record(store, plan, options.record_worst):
        return
    announce("starting the workers" if options.scheduler is None else "joining the workers")

    def show() -> None:
        progress.show(tally.count.scenarios)

    async with pool_for(options, plan.base.bundle, show) as pool:
        if pool.dashboard:
            print(f"Dask dashboard, if enabled: {pool.dashboard}", file=sys.stderr, flush=True)

        def remarks() -> Remarks:
            notes = [f"{recorded} of the worst {len(worst)} recorded"] if worst else []
            notes.append(counted(pool.workers, "worker") if pool.workers else NO_WORKERS)
            return notes, _tally_lines(tally)

        shown = ProgressDisplay(
            plan.base.mission.name,
            plan.count,
            remarks,
            sys.stderr,
            done=tally.count.scenarios,
            plain=options.plain,
            quiet=options.json and not sys.stderr.isatty(),
        )
        with shown as progress:

            def on_row(row: ScenarioRow) -> None:
                tally.add(row)
                show()

            def on_recorded() -> None:
                nonlocal recorded
                recorded += 1
                show()

            await sweep(plan, store, pool, on_row, retry_errors=options.retry_errors)
            worst = to_record(store, plan, options.record_worst)
            await record(store, pool, worst, on_recorded)
        if missing := len(worst) - recorded:
            print(f"{missing} of the worst {len(worst)} could not be recorded", file=sys.stderr)


def _tally_lines(tally: SweepTally) -> list[str]:
    """Return the counts, and a line for each of the most frequent reasons of failures."""
    if not tally.count.scenarios:
        return []
    failures = tally.failures
    lines = [
        f"  {tally.count}",
        *(f"  {failure.count:,} x {failure.reason}" for failure in failures[:MOST_REASONS]),
    ]
    if len(failures) > MOST_REASONS:
        rest = sum(failure.count for failure in failures[MOST_REASONS:])
        lines.append(f"  {rest:,} x for {len(failures) - MOST_REASONS} other reasons")
    return lines


def _tell(
    options: argparse.Namespace,
    store: ResultStore,
    total: int,
    tally: SweepTally,
    why_stopped: str,
) -> bool:
    """Print the results and make the page; return False if it could not be written."""
    if why_stopped:
        left = total - tally.count.scenarios
        print(
            f"{why_stopped}\n{left:,} scenarios remain; the same command with --resume continues",
            file=sys.stderr,
        )
    if not options.json:
        if tally.count.scenarios:
            tell_results(store, options.report)
        return True
    about = {"of": total, "results": str(store.folder), "stopped": why_stopped}
    try:
        about["report"] = str(write_page(store, options.report, None))
    except BtMissionError as error:
        about["report_lacks"] = error.headline
    from bt_mission.commands.sweep.columns import SweepColumns
    from bt_mission.commands.sweep.report.explanation import results_as_dict

    print(json.dumps({**results_as_dict(SweepColumns(store.rows())), **about}))
    return "report" in about


def _judge(options: argparse.Namespace, count: OutcomeCount) -> int:
    if count.errors:
        print(f"{counted(count.errors, 'scenario')} could not run", file=sys.stderr)
        return MISSION_FAILED
    low, _ = count.interval or (0.0, 0.0)
    if options.fail_below is not None and low < options.fail_below:
        print(
            f"the success rate is below {options.fail_below:g} or too uncertain: its interval "
            f"begins at {low:.4f}",
            file=sys.stderr,
        )
        return MISSION_FAILED
    return SUCCESS


COMMANDS = {
    "sweep": Command(
        sweep,
        "Runs a mission with every combination of seeds and values, each in its own simulation, "
        "on all processors of this machine or on a Dask cluster. Every result is saved at once; "
        "--resume continues a sweep that was stopped or killed.",
        (
            MISSION,
            Option(
                "--seeds N",
                "run each combination with the seeds 0 to N-1, A..B, or a list such as 3,5,8 "
                "(default: the seed of the mission)",
                seeds,
            ),
            Option(
                "--vary NAME=VALUES",
                "a parameter and its values, such as speed=0.1,0.2; with --sample also an "
                "interval, such as speed=0.1..0.26; may be repeated",
                repeats=True,
                completes="inputs",
            ),
            Option(
                "--within RANGES.yaml",
                "a file with parameters, seeds, fault plans and the time limit; options take "
                "precedence",
                input_file,
                takes=("ranges",),
                page="ranges",
            ),
            Option(
                "--sample N",
                "draw N points of the parameter space (Latin hypercube) instead of every "
                "combination; without --seeds each has its own seed",
                count,
            ),
            Option("--sample-seed N", "seed of these draws (default: 0)", whole, 0),
            Option(
                "--fault-plan FILE",
                "a file with fault plans; each point is run with each plan; may be repeated",
                input_file,
                repeats=True,
                takes=("ranges",),
            ),
            FAULT,
            SET,
            WORLD,
            ROBOT,
            SIMULATOR,
            nature_option("usual"),
            REQUIRE,
            NO_PYTHON,
            Option(
                "--limit S",
                "interrupt a mission after this many virtual seconds (default: 600)",
                above_zero,
            ),
            Option(
                "-o --output FOLDER",
                "folder for the results (default: MISSION_sweep)",
                Path,
            ),
            Option("--resume", "continue the sweep whose results are in the folder"),
            Option(
                "--retry-errors", "run scenarios again that could not run", needs=each("resume")
            ),
            *WORKER_OPTIONS,
            Option(
                "--fail-below SHARE",
                "exit with 1 unless the success rate is at least this share at 95 %% confidence",
                share,
            ),
            Option(
                "--report FILE",
                "file of the HTML page (default: sweep.html in the folder of the results)",
                unchecked_output_file,
            ),
            Option(
                "--record-worst N",
                "repeat the N worst runs, each with a recording and a report (default: 20, or "
                "fewer: the failed runs or a tenth of all; 0: none)",
                whole,
            ),
            Option("--yes", f"do not ask before running more than {MOST_UNASKED:,} scenarios"),
            JSON,
            PLAIN,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
