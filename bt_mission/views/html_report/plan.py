"""The plan: the world as the map has it, the robot's way, and what happened where."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from bt_mission.core.text import escape_markup, seconds
from bt_mission.recording.model import Floats, RecordedGrid, RecordedRun, Track
from bt_mission.views.html_report.figures import stops
from bt_mission.views.html_report.markup import element, hint, legend, number, rows, void

MARGIN = 0.3
"""m around everything that is drawn."""
SCANS = 60
"""Scans whose points are drawn, spread over the run."""
SEVERITY = ("succeeded", "canceled", "", "unknown", "rejected", "aborted")
"""How goals end, the worst last."""
STEP = 0.02
"""m between two points of the way that is drawn."""


def plan(run: RecordedRun) -> str:
    """The drawing, with y up as maps have it; nothing where nothing is known."""
    box = _box(run)
    if box is None:
        return hint("The recording has no map and no pose of the robot.")
    x, y, width, height = box
    unit = max(width, height) / 85
    parts = [
        _grid(run.grid) if run.grid is not None else "",
        _scans(run),
        _way(run.measured, "measured") if len(run.truth) else "",
        _way(run.track, "way"),
        *_stops(run, unit),
        _robot(run, run.start_ns, "start"),
        _robot(run, run.end_ns, "end"),
        *_collisions(run, unit),
        *_ends(run, unit),
        element("path", "", class_="seen", d=""),
        element("g", _shape(run), class_="ghost", visibility="hidden"),
    ]
    drawing = element(
        "svg",
        element("g", rows(parts), transform=f"translate(0 {number(2 * y + height)}) scale(1 -1)"),
        class_="plan",
        viewBox=f"{number(x)} {number(y)} {number(width)} {number(height)}",
        role="img",
        aria_label="The way of the robot over the map",
        style=f"aspect-ratio:{number(width / height, 3)}",
    )
    return drawing + _legend(run) + hint(f"{number(width, 1)} m wide.")


def _box(run: RecordedRun) -> tuple[float, float, float, float] | None:
    """What is shown: the way and the known part of the map around it."""
    xs, ys = [run.track.x], [run.track.y]
    if run.grid is not None:
        rows_, columns = np.nonzero(run.grid.cells >= 0)
        if len(rows_):
            size = run.grid.resolution
            for some, origin, out in ((columns, run.grid.x, xs), (rows_, run.grid.y, ys)):
                out.append(np.array([some.min(), some.max() + 1]) * size + origin)
    x, y = np.concatenate(xs), np.concatenate(ys)
    if not len(x):
        return None
    left, low = x.min() - MARGIN, y.min() - MARGIN
    return (float(left), float(low), float(x.max() + MARGIN - left), float(y.max() + MARGIN - low))


def _grid(grid: RecordedGrid) -> str:
    """Walls and what is unknown, each row's neighbours as one box."""
    parts = []
    for name, cells in (("free", grid.cells >= 0), ("walls", grid.cells >= 50)):
        steps = np.diff(np.pad(cells.astype(np.int8), ((0, 0), (1, 1))), axis=1)
        begins, ends = np.nonzero(steps == 1), np.nonzero(steps == -1)
        path = "".join(
            f"M{begin} {row}h{end - begin}v1h{begin - end}z"
            for row, begin, end in zip(*begins, ends[1], strict=True)
        )
        parts.append(void("path", class_=name, d=path))
    place = f"translate({number(grid.x)} {number(grid.y)}) scale({number(grid.resolution, 5)})"
    return element("g", rows(parts), transform=place)


def scans_on_map(run: RecordedRun, most: int) -> Iterator[tuple[int, Floats]]:
    """The time of each of so many scans, spread over the run, and its points on the map, m."""
    for index in spread(len(run.scans), most):
        scan = run.scans[index]
        if (pose := run.track.at(scan.time_ns)) is not None:
            cos, sin = math.cos(pose[2]), math.sin(pose[2])
            turn = np.array([[cos, sin], [-sin, cos]])
            yield scan.time_ns, scan.points @ turn + np.array(pose[:2])


def spread(count: int, most: int) -> Any:
    """At most so many of the first numbers, spread evenly."""
    return np.unique(np.linspace(0, max(0, count - 1), min(count, most)).astype(int))


def _scans(run: RecordedRun) -> str:
    if not run.scans:
        return ""
    seen: set[tuple[float, float]] = set()
    for _, points in scans_on_map(run, SCANS):
        seen.update(map(tuple, np.round(points, 2)[::2].tolist()))
    dots = "".join(f"M{number(x, 2)} {number(y, 2)}h0" for x, y in sorted(seen))
    return void("path", class_="scans", d=dots)


def _way(track: Track, name: str) -> str:
    if not len(track):
        return ""
    places = np.floor(track.distance / STEP)
    keep = np.flatnonzero(np.diff(places, prepend=-1) > 0)
    keep = np.unique(np.append(keep, len(track) - 1))
    points = " ".join(
        f"{number(x, 3)},{number(y, 3)}" for x, y in zip(track.x[keep], track.y[keep], strict=True)
    )
    return void("polyline", class_=name, points=points)


def _stops(run: RecordedRun, unit: float) -> list[str]:
    return [
        element(
            "circle",
            element("title", f"stood for {seconds(stop.seconds)}"),
            class_="stop",
            cx=stop.x,
            cy=stop.y,
            r=unit * min(2.5, 0.6 + 0.12 * stop.seconds),
        )
        for stop in stops(run.track)
    ]


def _collisions(run: RecordedRun, unit: float) -> list[str]:
    size = number(1.4 * unit)
    return [
        element(
            "path",
            element("title", escape_markup(f"collision with {hit.obstacle}")),
            class_="collision",
            d=f"M-{size} -{size}L{size} {size}M-{size} {size}L{size} -{size}",
            transform=f"translate({number(hit.x)} {number(hit.y)})",
        )
        for hit in run.collisions
    ]


def _ends(run: RecordedRun, unit: float) -> list[str]:
    """Where goals ended: a dot for each place, and the numbers of the goals beside it."""
    places: list[tuple[float, float, list[int]]] = []
    for index, goal in enumerate(run.goals):
        pose = None if goal.end_ns is None else run.track.at(goal.end_ns)
        if pose is None:
            continue
        for x, y, numbers in places:
            if math.hypot(pose[0] - x, pose[1] - y) < 2 * unit:
                numbers.append(index)
                break
        else:
            places.append((pose[0], pose[1], [index]))
    taken: list[_Box] = []
    return [_end(run, place, unit, taken) for place in places]


_Box = tuple[float, float, float, float]
"""Left, low, right and high, m."""


def _end(
    run: RecordedRun, place: tuple[float, float, list[int]], unit: float, taken: list[_Box]
) -> str:
    x, y, numbers = place
    lines = [
        f"goal {index + 1} of '{run.goals[index].owner}' to {run.goals[index].action}: "
        f"{run.goals[index].status or 'no end is known'}"
        for index in numbers
    ]
    shown = ", ".join(str(index + 1) for index in numbers[-4:])
    label = ("\N{HORIZONTAL ELLIPSIS} " if len(numbers) > 4 else "") + shown
    worst = max((run.goals[index].status for index in numbers), key=SEVERITY.index)
    width, height = unit * (1.05 * len(label) + 1.5), 2.5 * unit
    left, low = _free_place(x, y, width, height, unit, taken)
    # The drawing is upside down; what is read is turned back.
    flag = element(
        "g",
        void("rect", width=width, height=height, rx=height / 2)
        + element("text", label, x=width / 2, y=1.85 * unit, font_size=1.8 * unit),
        transform=f"translate({number(left - x)} {number(low + height - y)}) scale(1 -1)",
    )
    return element(
        "g",
        element("title", escape_markup("\n".join(lines))) + void("circle", r=0.7 * unit) + flag,
        class_=f"goal {worst or 'unknown'}",
        transform=f"translate({number(x)} {number(y)})",
    )


def _free_place(
    x: float, y: float, width: float, height: float, unit: float, taken: list[_Box]
) -> tuple[float, float]:
    """The left lower corner of a label beside a point, where it covers no other if it can."""
    gap = 0.8 * unit
    corners = [
        (x + side, y + level) for level in (gap, -gap - height) for side in (gap, -gap - width)
    ]
    free = [
        (left, low)
        for left, low in corners
        if not any(
            left < right_ and left_ < left + width and low < high_ and low_ < low + height
            for left_, low_, right_, high_ in taken
        )
    ]
    left, low = (free or corners)[0]
    taken.append((left, low, left + width, low + height))
    return left, low


def _shape(run: RecordedRun) -> str:
    """The robot, ahead along x."""
    front, rear, half = run.hull or (0.1, -0.1, 0.1)
    return void(
        "path",
        d=f"M{number(rear)} {number(-half)}H{number(front * 0.4)}L{number(front)} 0"
        f"L{number(front * 0.4)} {number(half)}H{number(rear)}Z",
    )


def _robot(run: RecordedRun, time_ns: int, name: str) -> str:
    pose = run.track.at(time_ns)
    if pose is None:
        return ""
    place = (
        f"translate({number(pose[0])} {number(pose[1])}) rotate({number(math.degrees(pose[2]))})"
    )
    return element(
        "g", element("title", name) + _shape(run), class_=f"robot {name}", transform=place
    )


def _legend(run: RecordedRun) -> str:
    parts = [("way", "way" if len(run.truth) else "way, as the odometry has it")]
    if len(run.truth):
        parts.append(("measured", "as the odometry has it"))
    parts += [("stopped", "stood still"), ("ended", "a goal ended here (numbers: see Goals)")]
    if run.scans:
        parts.append(("scanned", "seen by the lidar"))
    return legend("key", parts)
