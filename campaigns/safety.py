"""How safely the base stops: the figures of docs/explanation/safety.md, which this command writes.

All but the killed processes runs on the virtual clock, seeded, and is the same on every run.
Run it as: python campaigns/safety.py [--poses N] [--only drives|movers|stops|kills|alarms]
"""

from __future__ import annotations

import argparse
import math
import statistics
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import chain, product
from multiprocessing import get_context
from pathlib import Path

from safety_alarms import BUSY, Attached, alarms
from safety_kills import Kill, kill
from safety_movers import DURATION_S, Outing, outing
from safety_movers import SPEEDS as MOVER_SPEEDS
from safety_movers import WORLDS as MOVING_WORLDS
from safety_stops import GOALS, by_lost_scan, by_service
from safety_trials import SPEEDS, WORLDS, Drive, Stop, drives

from benchmarks.measuring import figure

PAGE = Path(__file__).resolve().parent.parent / "docs" / "explanation" / "safety.md"
ROWS = Path(__file__).with_name("safety_rows.txt")
"""Every row of the tables that the page sums up."""
WAYS = {"arbiter": True, "nothing": False}
"""What stands between servers and base."""
KILLED = ("servers", "executive")
STANDS_S = 0.5
"""After a process was killed."""
LOAD = 8.0
"""Load of the machine from which false alarms count apart."""


def in_one_world(world: str, poses: int, appears: bool) -> list[Drive]:  # noqa: FBT001 - starmap
    """All drives of a world, as a process of its own makes them."""
    return list(drives(world, count=poses, appears=appears))


DRIVES = "drives | collisions | least | 5 % | median | 95 % | failed |"
LINE = "|---" * 7 + "|"


def drive_table(drives: list[Drive]) -> Iterator[str]:
    """Yield a row for each world and speed, and one for all drives."""
    yield f"| world | m/s | {DRIVES}"
    yield f"|---|---{LINE}"
    for world, speed in product(WORLDS, SPEEDS):
        chosen = [d for d in drives if (d.world, d.speed) == (world, speed)]
        yield f"| {world} | {speed:g} | {_drive_row(chosen)}"
    yield f"| **all** | | {_drive_row(drives)}"


def _drive_row(drives: list[Drive]) -> str:
    left = sorted(drive.surplus for drive in drives)
    return (
        f"{len(drives)} | {sum(drive.collisions for drive in drives)} | {_mm(left[0])} "
        f"| {_mm(left[len(left) // 20])} | {_mm(statistics.median(left))} "
        f"| {_mm(left[-1 - len(left) // 20])} "
        f"| {sum(drive.status != 'succeeded' for drive in drives)} |"
    )


def drive_summary(walls: list[Drive], appearing: list[Drive]) -> Iterator[str]:
    """Yield a row for walls, and one for obstacles that appear."""
    yield f"| obstacle | {DRIVES}"
    yield f"|---{LINE}"
    yield f"| wall, box or cylinder | {_drive_row(walls)}"
    yield f"| box that appears | {_drive_row(appearing)}"


def stop_table(stops: Iterable[Stop], limit_s: float) -> Iterator[str]:
    """Yield a row for each action."""
    yield f"| action | stands after | within {limit_s:g} s | ends | reason |"
    yield "|---|---|---|---|---|"
    for stop in stops:
        figure("stands after a stop or a lost scan", stop.stood_after_s, "s")
        held = "yes" if stop.stood_after_s <= limit_s else "**no**"
        yield (
            f"| `{stop.action}` | {stop.stood_after_s:.3f} s | {held} | {stop.status} "
            f"| {stop.reason} |"
        )


def stop_summary(stops: dict[str, tuple[float, list[Stop]]]) -> Iterator[str]:
    """Yield a row for each event, with its limit and its stops."""
    yield "| event | actions | base stands after | limit | met |"
    yield "|---|---|---|---|---|"
    for event, (limit_s, of_event) in stops.items():
        times = [stop.stood_after_s for stop in of_event]
        met = sum(time <= limit_s for time in times)
        yield (
            f"| {event} | {len(times)} | {min(times):.3f} to {max(times):.3f} s | {limit_s:g} s "
            f"| {met} of {len(times)} |"
        )


def outing_table(outings: list[Outing]) -> Iterator[str]:
    """Yield a row for each world."""
    yield (
        "| world | what moves | gives way | runs | driven | contacts | drove into it "
        "| was hit driving | turning | standing | it ran into the robot | seen | could be avoided "
        "| collisions with what stands still |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    rows = product(MOVING_WORLDS, MOVER_SPEEDS, (False, True))
    for world, speed, gives_way in rows:
        row = world, speed, gives_way
        chosen = [trip for trip in outings if (trip.world, trip.mover_speed, trip.gives_way) == row]
        if not chosen:
            continue
        met = [encounter for outing in chosen for encounter in outing.met]
        moved = [encounter for encounter in met if encounter.is_mover]
        doing = Counter(encounter.doing for encounter in moved)
        if gives_way:
            figure(f"{world}, {speed:g} m/s: contacts with movers", len(moved))
            figure(f"{world}, {speed:g} m/s: driven into a mover", doing["driving into"])
        yield (
            f"| {world} | {speed:g} m/s | {'yes' if gives_way else 'no'} | {len(chosen)} "
            f"| {sum(trip.driven_m for trip in chosen):.0f} m | **{len(moved)}** "
            f"| {doing['driving into']} | {doing['driving']} | {doing['turning']} "
            f"| {doing['standing']} | {sum(encounter.was_run_into for encounter in moved)} "
            f"| {sum(encounter.was_seen for encounter in moved)} "
            f"| {sum(encounter.could_avoid for encounter in moved)} | {len(met) - len(moved)} |"
        )


def outing_summary(outings: list[Outing]) -> Iterator[str]:
    """Yield a row for each speed of the obstacles, without and with giving way."""
    yield (
        "| obstacles | gives way | runs | driven | contacts | drove into it | could be avoided "
        "| collisions with what stands still |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for speed, gives_way in product(MOVER_SPEEDS, (False, True)):
        chosen = [o for o in outings if (o.mover_speed, o.gives_way) == (speed, gives_way)]
        met = [encounter for outing in chosen for encounter in outing.met]
        moved = [encounter for encounter in met if encounter.is_mover]
        yield (
            f"| {speed:g} m/s | {'yes' if gives_way else 'no'} | {len(chosen)} "
            f"| {sum(outing.driven_m for outing in chosen):,.0f} m | {len(moved)} "
            f"| {sum(encounter.doing == 'driving into' for encounter in moved)} "
            f"| {sum(encounter.could_avoid for encounter in moved)} | {len(met) - len(moved)} |"
        )


def kill_table(all_kills: Iterable[Kill]) -> Iterator[str]:
    """Yield a row for each process that was killed, and for each way to the base."""
    yield (
        "| killed | between servers and base | times | load | stands after "
        "| after the last command sent | distance |"
    )
    yield "|---|---|---|---|---|---|---|"
    ways = {with_arbiter: name for name, with_arbiter in WAYS.items()}
    for (killed, with_arbiter), kills in _grouped(all_kills).items():
        loads = [kill.load for kill in kills]
        figure(f"stands after killed {killed}", (kill.stood_after_s for kill in kills), "s")
        yield (
            f"| {killed} | {ways[with_arbiter]} | {len(kills)} "
            f"| {min(loads):.0f} to {max(loads):.0f} | {_s(kill.stood_after_s for kill in kills)} "
            f"| {_s(kill.after_command_s for kill in kills)} "
            f"| at most {max(kill.way_m for kill in kills):.2f} m |"
        )


def _grouped(kills: Iterable[Kill]) -> dict[tuple[str, bool], list[Kill]]:
    groups: dict[tuple[str, bool], list[Kill]] = {}
    for trial in kills:
        groups.setdefault((trial.killed, trial.with_arbiter), []).append(trial)
    return groups


def _s(seconds: Iterable[float]) -> str:
    """Write median and most, and how many are above the figure, s."""
    ordered = sorted(seconds)
    late = sum(value > STANDS_S + 1e-6 for value in ordered)
    above = f", **{late} above {STANDS_S:g} s**" if late else ""
    return f"{statistics.median(ordered):.2f} s, at most {ordered[-1]:.2f} s{above}"


def alarm_table(runs: list[Attached]) -> Iterator[str]:
    """Yield a row for all missions, and one for those on a machine as busy as was asked for."""
    yield (
        "| load | attached missions | succeeded | failed otherwise | base held | taken for dead |"
    )
    yield "|---|---|---|---|---|---|"
    for name, least in (("any", 0.0), (f"{LOAD:g} and more", LOAD)):
        chosen = [attached for attached in runs if attached.load >= least]
        loads = [attached.load for attached in chosen] or [math.nan]
        given_up = sum(attached.is_given_up for attached in chosen)
        succeeded = sum(not attached.reason for attached in chosen)
        yield (
            f"| {name} (median {statistics.median(loads):.0f}, most {max(loads):.0f}) "
            f"| {len(chosen):,} | {succeeded:,} | {len(chosen) - succeeded - given_up} "
            f"| {sum(attached.held for attached in chosen)} times | {given_up} |"
        )


def write(mark: str, lines: Iterable[str], path: Path = PAGE, *, on_page: bool) -> None:
    """Put lines onto the terminal and between the marks of that name in the file."""
    text = "\n".join(lines)
    print(f"{mark}\n{text}\n", flush=True)
    if not on_page:
        return
    page = path.read_text(encoding="utf-8")
    begin, end = f"<!-- {mark} -->\n", f"\n<!-- end of {mark} -->"
    head, _, rest = page.partition(begin)
    _, has_end, tail = rest.partition(end)
    if not has_end:
        raise SystemExit(f"{path} has no place for '{mark}'")
    path.write_text(f"{head}{begin}{text}{end}{tail}", encoding="utf-8")


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=100, help="poses in each world")
    parser.add_argument("--processes", type=int, default=2, help="worlds at a time")
    parser.add_argument("--kills", type=int, default=3, help="times that each process is killed")
    parser.add_argument("--killed", choices=KILLED, nargs="+", default=KILLED, help="processes")
    parser.add_argument("--outings", type=int, default=20, help="seeds in each moving world")
    parser.add_argument("--seconds", type=int, default=DURATION_S, help="virtual, of an outing")
    parser.add_argument("--behind", choices=WAYS, nargs="+", default=list(WAYS), help="the servers")
    parser.add_argument("--busy", type=int, default=BUSY, help="processes that compute beside them")
    parser.add_argument("--alarms", type=int, default=25, help="missions on a busy machine")
    parser.add_argument("--graphs", type=int, default=1, help="of these missions, at a time")
    parser.add_argument("--results", type=Path, default=Path("alarms.jsonl"), help="of these")
    parser.add_argument("--only", choices=["drives", "movers", "stops", "kills", "alarms"])
    parser.add_argument("--no-page", action="store_true", help="print, and leave the page as it is")
    options = parser.parse_args()
    publish = partial(write, on_page=not options.no_page)
    if options.only in (None, "drives"):
        runs = [(world, options.poses, appears) for appears in (False, True) for world in WORLDS]
        with get_context("spawn").Pool(options.processes) as pool:
            results = pool.starmap(in_one_world, runs, chunksize=1)
        drives_of_all = list(chain(*results))
        figure("collisions of drives", sum(drive.collisions for drive in drives_of_all))
        left_mm = [1000 * drive.surplus for drive in drives_of_all if math.isfinite(drive.surplus)]
        figure("left of the stopping distance", left_mm, "mm")
        walls, appearing = (list(chain(*results[part])) for part in (slice(3), slice(3, 6)))
        publish("walls", drive_table(walls), ROWS)
        publish("appearing obstacle", drive_table(appearing), ROWS)
        publish("stopping distance", drive_summary(walls, appearing))
    if options.only in (None, "movers"):
        seeds = range(1, options.outings + 1)
        # The worlds as they are twice as often as those made faster.
        todo = [
            (world, seed, options.seconds, speed, gives_way)
            for world, speed, gives_way in product(MOVING_WORLDS, MOVER_SPEEDS, (False, True))
            for seed in (seeds if speed == MOVER_SPEEDS[0] else seeds[::2])
        ]
        with get_context("spawn").Pool(options.processes) as pool:
            outings = pool.starmap(outing, todo, chunksize=1)
        publish("moving obstacles", outing_table(outings), ROWS)
        publish("moving obstacles", outing_summary(outings))
    if options.only in (None, "stops"):
        called, blind = list(map(by_service, GOALS)), list(map(by_lost_scan, GOALS))
        publish("stop service", stop_table(called, 0.3), ROWS)
        publish("lost scan", stop_table(blind, 1.0), ROWS)
        stops = {"`stop` is called": (0.3, called), "the lidar sends nothing": (1.0, blind)}
        publish("stops", stop_summary(stops))
    if options.only in (None, "kills"):
        publish(
            "killed processes",
            kill_table(
                kill(what, with_arbiter=with_arbiter)
                for what in options.killed
                for with_arbiter in (WAYS[way] for way in options.behind)
                for _ in range(options.kills)
            ),
        )
    if options.only in (None, "alarms"):
        counted = alarms(options.alarms, options.busy, options.graphs, options.results)
        publish("false alarms", alarm_table(counted))
        figure("given up on a busy machine", sum(attached.is_given_up for attached in counted))
        print(
            "\n".join(
                attached.reason
                for attached in counted
                if attached.reason and not attached.is_given_up
            )
        )


def _mm(metres: float) -> str:
    return f"{1000 * metres:+.0f} mm" if math.isfinite(metres) else "free"


if __name__ == "__main__":
    main()
