"""What the report of a sweep costs: rows made from real ones, the page, the table, CSV.

Rows of a results folder are drawn again and again, with other ids, numbers, seeds, times and
margins. Peak memory is that of the process.

Run it as: python benchmarks/sweep_report.py RESULTS [--rows 100000] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import sqlite3
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from random import Random

from measuring import figure
from sweeps import plan_of

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.scenarios.runner import ScenarioProcess
from bt_mission.sweeps.columns import SweepColumns
from bt_mission.sweeps.repeat import ORIGIN_KEY
from bt_mission.sweeps.report.page import write_sweep_page
from bt_mission.sweeps.row import RequirementMargin, ScenarioRow
from bt_mission.sweeps.store import ResultStore, write_csv
from bt_mission.sweeps.work import ScenarioWorker


def main() -> None:
    """Make the rows and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "results", type=Path, nargs="?", help="default: three scenarios of explore.yaml"
    )
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--keep", type=Path, help="leave the results and the page here")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary) / "results"
        fill(options.results or swept(Path(temporary) / "swept"), folder, options.rows)
        measure(folder)


def swept(folder: Path) -> Path:
    """Carry three scenarios out in this process; gives the results."""
    plan = plan_of(Path("missions/explore.yaml"), 3, legs=1)
    with (
        ScenarioWorker(plan.base.bundle, ScenarioProcess().run) as worker,
        ResultStore.create(folder, plan.about) as store,
    ):
        for one in plan.scenarios():
            store.add(worker.carry_out(one))
    return folder


def fill(source: Path, folder: Path, count: int) -> None:
    """Write so many rows like those of other results."""
    with ResultStore.read(source) as store:
        rows, about, origin = list(store.rows()), store.about, store.value(ORIGIN_KEY)
    watch = Stopwatch()
    with ResultStore.create(folder, replace(about, scenarios=count)) as store:
        if origin is not None:
            store.set_value(ORIGIN_KEY, origin)
        # Each row a transaction is how a sweep writes; here the disk must not be what is measured.
        store._connection.execute("PRAGMA synchronous=OFF")  # noqa: SLF001
        for row in like(rows, count):
            store.add(row)
    print(f"{count:,} rows written in {watch.elapsed_s:.1f} s")


def like(rows: list[ScenarioRow], count: int) -> Iterator[ScenarioRow]:
    """Draw rows."""
    random = Random(1)
    for number in range(count):
        row = random.choice(rows)
        yield replace(
            row,
            id=f"{random.getrandbits(64):016x}",
            number=number,
            seed=number,
            virtual_s=row.virtual_s * random.uniform(0.9, 1.1),
            parameters={
                name: value * random.uniform(0.95, 1.05) if isinstance(value, float) else value
                for name, value in row.parameters.items()
            },
            requirements={
                name: replace(one, margin=_near(one, random))
                for name, one in row.requirements.items()
            },
        )


def _near(one: RequirementMargin, random: Random) -> float | None:
    return None if one.margin is None else one.margin * random.uniform(0.8, 1.2)


def measure(folder: Path) -> None:
    """Time each output."""
    with ResultStore.read(folder) as store:
        watch, begun = Stopwatch(), os.times()
        columns = SweepColumns(store.rows())
        print(f"rows read and added up: {watch.elapsed_s:.1f} s")
        watch = Stopwatch()
        path = write_sweep_page(store, columns=columns)
        size = path.stat().st_size / 1e6
        ended = os.times()
        processor_s = ended.user + ended.system - begun.user - begun.system
        figure("rows and page, CPU", processor_s, "s")
        figure("size of the page", size, "MB")
        print(f"page from them: {watch.elapsed_s:.1f} s, {size:.2f} MB")
        print(f"processor time of both: {processor_s:.1f} s")
        watch = Stopwatch()
        with (folder / "rows.csv").open("w", newline="") as file:
            write_csv(store.rows, file)
        print(f"CSV: {watch.elapsed_s:.1f} s, {Path(file.name).stat().st_size / 1e6:.0f} MB")
        with (folder / "rows.csv").open(newline="") as file:
            assert sum(1 for _ in csv.reader(file)) == len(columns) + 1
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    figure("peak memory", peak, "MB")
    print(f"peak memory: {peak:.0f} MB; SQLite {sqlite3.sqlite_version}")


if __name__ == "__main__":
    main()
