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
    WORLD,
    announce,
    confirm,
    mission_file,
    nature_option,
)
from bt_mission.cli.outputs import files_of, refuse_overwritten
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.sweep_report import tell_results, write_page
from bt_mission.cli.workers import (
    WORKER_OPTIONS,
    base_changes,
    pool_for,
    require_dask,
    run_interruptible,
)
from bt_mission.core.errors import BtMissionError
from bt_mission.core.text import counted

if TYPE_CHECKING:
    from bt_mission.sweeps.plan import SweepPlan
    from bt_mission.sweeps.row import ScenarioRow
    from bt_mission.sweeps.store import ResultStore
    from bt_mission.sweeps.summary import OutcomeCount, SweepTally

MOST_UNASKED = 100_000
MOST_REASONS = 4
NO_WORKERS = "no worker is left: it waits for others; Ctrl-C ends it, and --resume goes on"

EPILOG = """\
examples:
  bt-mission sweep explore --seeds 1000
  bt-mission sweep explore --seeds 50 --vary speed=0.1,0.2,0.26 --vary world=dqn_stage1,dqn_stage4
  bt-mission sweep explore --sample 500 --vary speed=0.05..0.26 --vary stopping_distance=0.3..0.8
  bt-mission sweep explore --sample 500 --within ranges.yaml
  bt-mission sweep explore --seeds 100 --fault-plan sensors.yaml -o sensors
  bt-mission sweep explore --seeds 1000 --resume          go on where it was stopped
  bt-mission sweep explore --seeds 1000 --fail-below 0.95 for CI: are 95 % certain?
  bt-mission sweep explore --seeds 100000 --scheduler tcp://10.0.0.1:8786
  bt-mission sweep-report explore_sweep                   the table and the page, at any time

parameters of --vary: inputs of the mission, world, robot, start.x, start.y (m), start.yaw (degrees)

exit codes: 0 all was carried out, however the missions ended; 1 the success rate is not surely at
--fail-below or above, a scenario could not run, or the workers are gone; 2 bad input; 130
interrupted
"""


def sweep(options: argparse.Namespace) -> int:
    """Carry the sweep out; gives the exit code."""
    require_dask()
    announce(f"loading {options.file}")
    from bt_mission.core.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.sweeps.repeat import origin_of
    from bt_mission.sweeps.store import ResultStore
    from bt_mission.sweeps.summary import SweepTally
    from bt_mission.sweeps.sweep import refuse_impossible

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
            signal = run_interruptible(_carry_out(options, plan, store, tally))
            if signal:
                why_stopped, code = f"stopped by {signal}", INTERRUPTED
        except BtMissionError as error:  # the workers are gone, or the disk is full
            why_stopped, code = str(error), MISSION_FAILED
        _tell(options, store, plan.count, tally, why_stopped)
        return code or _judge(options, tally.count)


def plan_of(options: argparse.Namespace) -> SweepPlan:
    """Read all that the options say.

    Raises:
        InputError: With what is wrong.
    """
    from bt_mission.sweeps.base import load_base
    from bt_mission.sweeps.plan import SweepPlan
    from bt_mission.sweeps.ranges import (
        parse_parameter,
        read_ranges,
        refuse_repeated,
        with_fault_plans,
    )

    path, file = mission_file(options), read_ranges(options.within)
    file.refuse_others("sweep")
    file.check_worlds(path)
    ranges = file.ranges
    varied = [parse_parameter(one) for one in options.vary]
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
        ". Go on?",
        otherwise=": say --yes if so many are meant",
        refused="nothing was carried out",
    )


async def _carry_out(
    options: argparse.Namespace, plan: SweepPlan, store: ResultStore, tally: SweepTally
) -> None:
    from bt_mission.sweeps.sweep import left, record, sweep, to_record
    from bt_mission.views.terminal.progress import Progress, Remarks

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
            print(
                f"Dask's dashboard, where it is on: {pool.dashboard}", file=sys.stderr, flush=True
            )

        def remarks() -> Remarks:
            notes = [f"{recorded} of the worst {len(worst)} recorded"] if worst else []
            notes.append(counted(pool.workers, "worker") if pool.workers else NO_WORKERS)
            return notes, _tally_lines(tally)

        shown = Progress(
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


def _tally_lines(tally: SweepTally) -> list[str]:
    """Return the counts, and a line for each of the most frequent reasons of failures."""
    if not tally.count.scenarios:
        return []
    failures = tally.failures
    lines = [
        f"  {tally.count}",
        *(f"  {one.count:,} x {one.reason}" for one in failures[:MOST_REASONS]),
    ]
    if len(failures) > MOST_REASONS:
        rest = sum(one.count for one in failures[MOST_REASONS:])
        lines.append(f"  {rest:,} x for {len(failures) - MOST_REASONS} other reasons")
    return lines


def _tell(
    options: argparse.Namespace,
    store: ResultStore,
    total: int,
    tally: SweepTally,
    why_stopped: str,
) -> None:
    if why_stopped:
        left = total - tally.count.scenarios
        print(
            f"{why_stopped}\n{left:,} scenarios are left; the same command with --resume goes on",
            file=sys.stderr,
        )
    if not options.json:
        if tally.count.scenarios:
            tell_results(store, options.report)
        return
    about = {"of": total, "results": str(store.folder), "stopped": why_stopped}
    try:
        about["report"] = str(write_page(store, options.report, None))
    except BtMissionError as error:
        about["report_lacks"] = str(error)
    from bt_mission.sweeps.columns import SweepColumns
    from bt_mission.sweeps.report.explanation import results_as_dict

    print(json.dumps({**results_as_dict(SweepColumns(store.rows())), **about}))


def _judge(options: argparse.Namespace, count: OutcomeCount) -> int:
    if count.errors:
        print(f"{counted(count.errors, 'scenario')} could not run", file=sys.stderr)
        return MISSION_FAILED
    low, _ = count.interval or (0.0, 0.0)
    if options.fail_below is not None and low < options.fail_below:
        print(
            f"the success rate is not surely {options.fail_below:g} or above: its interval begins "
            f"at {low:.4f}",
            file=sys.stderr,
        )
        return MISSION_FAILED
    return SUCCESS


COMMANDS = {
    "sweep": Command(
        sweep,
        "Runs every combination of seeds and values, each in its own simulation, as many at a "
        "time as this machine has processors, or on a cluster of Dask. Each result is kept as it "
        "comes: --resume continues a sweep that was stopped or killed.",
        (
            MISSION,
            Option(
                "--seeds N",
                "run each with the seeds 0 to N-1; or A..B, or a list such as 3,5,8 (default: the "
                "mission's own)",
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
                "what may vary, in a file: parameters, seeds, plans of faults, the limit; "
                "options come before it",
                input_file,
                page="ranges",
            ),
            Option(
                "--sample N",
                "draw N points of the parameters' space (a Latin hypercube) instead of taking "
                "every combination; without --seeds each has a seed of its own",
                count,
            ),
            Option("--sample-seed N", "the draws follow from it", whole, 0),
            Option(
                "--fault-plan FILE",
                "a file of ranges with plans of faults alone; each point is run with each plan; "
                "may be repeated",
                input_file,
                repeats=True,
            ),
            FAULT,
            SET,
            WORLD,
            ROBOT,
            nature_option("usual"),
            REQUIRE,
            NO_PYTHON,
            Option(
                "--limit S",
                "interrupt a mission after this many seconds of its time (default: 600)",
                above_zero,
            ),
            Option(
                "-o --output FOLDER",
                "where the results go (default: the name of the mission with _sweep)",
                Path,
            ),
            Option("--resume", "continue with the results that are in that folder"),
            Option("--retry-errors", "run again what could not run", needs=each("resume")),
            *WORKER_OPTIONS,
            Option(
                "--fail-below SHARE",
                "exit with 1 unless the success rate is surely (95 %%) at this share or above",
                share,
            ),
            Option(
                "--report FILE",
                "where the page goes (default: sweep.html among the results)",
                unchecked_output_file,
            ),
            Option(
                "--record-worst N",
                "run N of the worst once more, recorded, with a page each (default: 20, or "
                "as many as have failed or are a tenth of all where that is less; 0 is none)",
                whole,
            ),
            Option("--yes", f"do not ask before a sweep of more than {MOST_UNASKED:,} scenarios"),
            JSON,
            PLAIN,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
