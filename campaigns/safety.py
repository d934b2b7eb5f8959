"""How safely the base stops: the figures of docs/explanation/safety.md, which this command writes.

All but the killed processes runs on the virtual clock, seeded, and is the same on every run.
Run it as: python campaigns/safety.py [--poses N] [--only drives|movers|stops|kills|alarms ...]
"""

from __future__ import annotations

import math
import statistics
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from safety_alarms import BUSY, Attached, alarms
from safety_kills import Kill, kill
from safety_movers import DURATION_S, Outing, outing
from safety_movers import SPEEDS as MOVER_SPEEDS
from safety_movers import WORLDS as MOVING_WORLDS
from safety_stops import GOALS, by_lost_scan, by_service
from safety_trials import SPEEDS, WORLDS, Drive, Stop, drives

from benchmarks.measuring import arguments, figure

PAGE = Path(__file__).resolve().parent.parent / "docs" / "explanation" / "safety.md"
ROWS = Path(__file__).with_name("safety_rows.txt")
"""Every row of the tables that the page sums up."""
WAYS = {"arbiter": True, "nothing": False}
"""What stands between servers and base."""
STANDS_S = 0.5
"""After a process was killed."""
LOAD = 8.0
"""Load of the machine from which false alarms count apart."""

Cells = Sequence[object]


class Page:
    """The tables: on the terminal, and between the marks of their names in a file."""

    def __init__(self, *, is_written: bool) -> None:
        self._is_written = is_written

    def write(self, mark: str, head: str, rows: Iterable[Cells], path: Path = PAGE) -> None:
        """Write a table; its head is that of Markdown, without the outer bars."""
        lines = [f"| {head} |", "|" + "---|" * len(head.split("|"))]
        text = "\n".join([*lines, *(f"| {' | '.join(map(str, row))} |" for row in rows)])
        print(f"{mark}\n{text}\n", flush=True)
        if not self._is_written:
            return
        page = path.read_text(encoding="utf-8")
        begin, end = f"<!-- {mark} -->\n", f"\n<!-- end of {mark} -->"
        before, _, rest = page.partition(begin)
        _, has_end, after = rest.partition(end)
        if not has_end:
            raise SystemExit(f"{path} has no place for '{mark}'")
        path.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")


def in_processes(count: int, work: Callable[..., Any], todo: Iterable[Cells]) -> list[Any]:
    """Return the results of a work, of so many at a time."""
    with get_context("spawn").Pool(count) as pool:
        return pool.starmap(work, todo, chunksize=1)


# ---- drives --------------------------------------------------------------------------------------


def in_one_world(world: str, poses: int, appears: bool) -> list[Drive]:  # noqa: FBT001 - starmap
    """All drives of a world, as a process of its own makes them."""
    return list(drives(world, count=poses, appears=appears))


DRIVES = "drives | collisions | least | 5 % | median | 95 % | failed"


def drive_cells(chosen: list[Drive]) -> Cells:
    """Return the cells of some drives."""
    left = sorted(drive.surplus for drive in chosen)
    end = len(left) // 20
    shown = (left[0], left[end], statistics.median(left), left[-1 - end])
    failed = sum(drive.status != "succeeded" for drive in chosen)
    collisions = sum(drive.collisions for drive in chosen)
    distances = (f"{1000 * m:+.0f} mm" if math.isfinite(m) else "free" for m in shown)
    return (len(chosen), collisions, *distances, failed)


def drive_rows(chosen: list[Drive]) -> Iterator[Cells]:
    """Yield a row for each world and speed, and one for all drives."""
    for world, speed in product(WORLDS, SPEEDS):
        here = [drive for drive in chosen if (drive.world, drive.speed) == (world, speed)]
        yield (world, f"{speed:g}", *drive_cells(here))
    yield ("**all**", "", *drive_cells(chosen))


def measure_drives(page: Page, options: Namespace) -> None:
    """Drive at walls, and at obstacles that appear."""
    walls, appearing = (
        list(
            chain.from_iterable(
                in_processes(
                    options.processes,
                    in_one_world,
                    [(world, options.poses, appears) for world in WORLDS],
                )
            )
        )
        for appears in (False, True)
    )
    every = walls + appearing
    figure("collisions of drives", sum(drive.collisions for drive in every))
    left_mm = [1000 * drive.surplus for drive in every if math.isfinite(drive.surplus)]
    figure("left of the stopping distance", left_mm, "mm")
    page.write("walls", f"world | m/s | {DRIVES}", drive_rows(walls), ROWS)
    page.write("appearing obstacle", f"world | m/s | {DRIVES}", drive_rows(appearing), ROWS)
    summary = {"wall, box or cylinder": walls, "box that appears": appearing}
    rows = [(name, *drive_cells(some)) for name, some in summary.items()]
    page.write("stopping distance", f"obstacle | {DRIVES}", rows)


# ---- obstacles that move -------------------------------------------------------------------------

STILL = "could be avoided | collisions with what stands still"
MET = (
    "runs | driven | contacts | drove into it | was hit driving | turning | standing "
    f"| it ran into the robot | seen | {STILL}"
)


def outing_cells(chosen: list[Outing]) -> list[object]:
    """Return the cells of some outings."""
    met = [encounter for trip in chosen for encounter in trip.met]
    moved = [encounter for encounter in met if encounter.is_mover]
    doing = Counter(encounter.doing for encounter in moved)
    return [
        len(chosen),
        f"{sum(trip.driven_m for trip in chosen):,.0f} m",
        len(moved),
        *(doing[what] for what in ("driving into", "driving", "turning", "standing")),
        sum(encounter.was_run_into for encounter in moved),
        sum(encounter.was_seen for encounter in moved),
        sum(encounter.could_avoid for encounter in moved),
        len(met) - len(moved),
    ]


def measure_movers(page: Page, options: Namespace) -> None:
    """Explore among obstacles that move, without and with giving way."""
    seeds = range(1, options.outings + 1)
    # The worlds as they are twice as often as those made faster.
    todo = [
        (world, seed, options.seconds, speed, gives_way)
        for world, speed, gives_way in product(MOVING_WORLDS, MOVER_SPEEDS, (False, True))
        for seed in (seeds if speed == MOVER_SPEEDS[0] else seeds[::2])
    ]
    outings: list[Outing] = in_processes(options.processes, outing, todo)
    rows, summary = [], []
    for world, speed, gives_way in product(MOVING_WORLDS, MOVER_SPEEDS, (False, True)):
        key = (world, speed, gives_way)
        chosen = [trip for trip in outings if (trip.world, trip.mover_speed, trip.gives_way) == key]
        cells = outing_cells(chosen)
        if gives_way:
            figure(f"{world}, {speed:g} m/s: contacts with movers", int(str(cells[2])))
            figure(f"{world}, {speed:g} m/s: driven into a mover", int(str(cells[3])))
        rows.append((world, f"{speed:g} m/s", "yes" if gives_way else "no", *cells))
    for speed, gives_way in product(MOVER_SPEEDS, (False, True)):
        chosen = [o for o in outings if (o.mover_speed, o.gives_way) == (speed, gives_way)]
        cells = outing_cells(chosen)
        summary.append((f"{speed:g} m/s", "yes" if gives_way else "no", *cells[:4], *cells[-2:]))
    page.write("moving obstacles", f"world | what moves | gives way | {MET}", rows, ROWS)
    head = f"obstacles | gives way | runs | driven | contacts | drove into it | {STILL}"
    page.write("moving obstacles", head, summary)


# ---- stops ---------------------------------------------------------------------------------------


def measure_stops(page: Page, _: Namespace) -> None:
    """Stop every action by the service, and by a lost scan."""
    summary = []
    for mark, event, limit_s, stop in (
        ("stop service", "`stop` is called", 0.3, by_service),
        ("lost scan", "the lidar sends nothing", 1.0, by_lost_scan),
    ):
        stops: list[Stop] = list(map(stop, GOALS))
        times = figure("stands after a stop or a lost scan", (s.stood_after_s for s in stops), "s")
        held = ["yes" if time <= limit_s else "**no**" for time in times]
        rows = [
            (f"`{stop.action}`", f"{stop.stood_after_s:.3f} s", is_held, stop.status, stop.reason)
            for stop, is_held in zip(stops, held, strict=True)
        ]
        head = f"action | stands after | within {limit_s:g} s | ends | reason"
        page.write(mark, head, rows, ROWS)
        spread = f"{min(times):.3f} to {max(times):.3f} s"
        met = f"{held.count('yes')} of {len(times)}"
        summary.append((event, len(times), spread, f"{limit_s:g} s", met))
    page.write("stops", "event | actions | base stands after | limit | met", summary)


# ---- processes -----------------------------------------------------------------------------------


def measure_kills(page: Page, options: Namespace) -> None:
    """Kill servers and executive while the robot drives."""
    rows = []
    for killed, way in product(options.killed, options.behind):
        kills: list[Kill] = [kill(killed, with_arbiter=WAYS[way]) for _ in range(options.kills)]
        loads = [each.load for each in kills]
        stood_s = figure(f"stands after killed {killed}", (k.stood_after_s for k in kills), "s")
        rows.append(
            (
                killed,
                way,
                len(kills),
                f"{min(loads):.0f} to {max(loads):.0f}",
                seconds(stood_s),
                seconds(each.after_command_s for each in kills),
                f"at most {max(each.way_m for each in kills):.2f} m",
            )
        )
    page.write(
        "killed processes",
        "killed | between servers and base | times | load | stands after "
        "| after the last command sent | distance",
        rows,
    )


def seconds(values: Iterable[float]) -> str:
    """Write median and most, and how many are above the figure, s."""
    ordered = sorted(values)
    late = sum(value > STANDS_S + 1e-6 for value in ordered)
    above = f", **{late} above {STANDS_S:g} s**" if late else ""
    return f"{statistics.median(ordered):.2f} s, at most {ordered[-1]:.2f} s{above}"


def measure_alarms(page: Page, options: Namespace) -> None:
    """Run attached missions on a busy machine."""
    counted = alarms(options.alarms, options.busy, options.graphs, options.results)
    rows = [
        alarm_cells("any", counted),
        alarm_cells(f"{LOAD:g} and more", [each for each in counted if each.load >= LOAD]),
    ]
    head = "load | attached missions | succeeded | failed otherwise | base held | taken for dead"
    page.write("false alarms", head, rows)
    figure("given up on a busy machine", sum(each.is_given_up for each in counted))
    print(*(each.reason for each in counted if each.reason and not each.is_given_up), sep="\n")


def alarm_cells(name: str, chosen: list[Attached]) -> Cells:
    """Return the cells of some missions."""
    loads = [each.load for each in chosen] or [math.nan]
    given_up = sum(each.is_given_up for each in chosen)
    succeeded = sum(not each.reason for each in chosen)
    return (
        f"{name} (median {statistics.median(loads):.0f}, most {max(loads):.0f})",
        f"{len(chosen):,}",
        f"{succeeded:,}",
        len(chosen) - succeeded - given_up,
        f"{sum(each.held for each in chosen)} times",
        given_up,
    )


def main() -> None:
    """Measure, and write the page."""
    options = arguments(
        __doc__,
        only={
            "drives": measure_drives,
            "movers": measure_movers,
            "stops": measure_stops,
            "kills": measure_kills,
            "alarms": measure_alarms,
        },
        poses=(100, "poses in each world"),
        processes=(2, "worlds at a time"),
        kills=(3, "times that each process is killed"),
        killed=(["servers", "executive"], "processes"),
        outings=(20, "seeds in each moving world"),
        seconds=(DURATION_S, "virtual, of an outing"),
        behind=(list(WAYS), "what stands between servers and base"),
        busy=(BUSY, "processes that compute beside them"),
        alarms=(25, "missions on a busy machine"),
        graphs=(1, "of these missions, at a time"),
        results=(Path("alarms.jsonl"), "of these"),
        no_page=(False, "print, and leave the page as it is"),
    )
    for part in options.only:
        part(Page(is_written=not options.no_page), options)


if __name__ == "__main__":
    main()
