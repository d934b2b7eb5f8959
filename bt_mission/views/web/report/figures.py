"""The figures of a recorded run: stops, ends of leaves, distance, figures against time."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bt_mission.base.stamps import NS
from bt_mission.recording.model import Floats, RecordedRequirement, RecordedRun, Times, Track

STILL_M_S = 0.01
STILL_RAD_S = 0.02
STOP_S = 1.5
"""A robot that stands for this time has stopped."""

MOST_POINTS = 1200
"""Of a chart."""


@dataclass(frozen=True)
class Chart:
    """A figure against time, with its unit.

    Attributes:
        least: Where the axis begins, unless a value is below it.
    """

    name: str
    unit: str
    times: Times
    values: Floats
    least: float | None = None

    def data(self, start_ns: int) -> dict[str, Any]:
        """Return it, ready for JSON; times are s since the start."""
        times, values = thinned(self.times, self.values)
        return {
            "name": self.name,
            "unit": self.unit,
            "least": self.least,
            "t": ((times - start_ns) / NS).round(3).tolist(),
            "v": values.round(4).tolist(),
        }


def since_start_s(run: RecordedRun, time_ns: int) -> float:
    """Return the time since the start of the run, s."""
    return (time_ns - run.start_ns) / NS


def mission_s(run: RecordedRun) -> float:
    """Return how long the mission took, s, as `run` has printed it where it was not killed."""
    return float(run.summary.get("virtual_s", since_start_s(run, run.end_ns)))


def distance_m(run: RecordedRun) -> float | None:
    """Return how far the robot drove, by the simulation where that is known, else by its track."""
    known = run.summary.get("distance_travelled_m")
    if known is not None:
        return float(known)
    return float(run.track.distance[-1]) if len(run.track) else None


def charts(run: RecordedRun) -> list[Chart]:
    """Return what is known of the robot against time."""
    track, seen = run.track, [measured for measured in run.scans if np.isfinite(measured.clearance)]
    times = np.array([scan.time_ns for scan in seen], np.int64)
    clearances = np.array([scan.clearance for scan in seen], np.float64)
    known = [
        Chart("speed", "m/s", track.times, track.speed, 0.0),
        Chart("distance", "m", track.times, track.distance, 0.0),
        Chart("clearance", "m", times, clearances, 0.0),
        Chart("battery", "%", run.battery.times, run.battery.values),
    ]
    return [chart for chart in known if len(chart.times)]


def margin_chart(run: RecordedRun, requirement: RecordedRequirement) -> Chart | None:
    """Return the margin of a requirement against time; None without a margin."""
    has_margin = np.isfinite(requirement.margins)
    if not has_margin.any():
        return None
    times = run.start_ns + np.round(requirement.times[has_margin] * NS).astype(np.int64)
    name = "margin at each instant" if requirement.is_of_instants else "margin so far"
    return Chart(name, requirement.result.unit, times, requirement.margins[has_margin], 0.0)


def thinned(times: Times, values: Floats, most: int = MOST_POINTS) -> tuple[Times, Floats]:
    """Return at most `most` points, of each stretch the least and the greatest value."""
    finite = np.isfinite(values)
    times, values = times[finite], values[finite]
    count = len(times)
    if count <= most:
        return times, values
    keep: set[int] = {0, count - 1}
    for part in np.array_split(np.arange(count), most // 2):
        keep.add(int(part[np.argmin(values[part])]))
        keep.add(int(part[np.argmax(values[part])]))
    chosen = np.array(sorted(keep))
    return times[chosen], values[chosen]


def stops(track: Track) -> list[tuple[int, float, float, float]]:
    """Return where the robot stood after it first moved: from when, ns, how long, s, x and y."""
    if len(track) < 2:
        return []
    is_still = (np.abs(track.speed) < STILL_M_S) & (np.abs(track.turn) < STILL_RAD_S)
    moved = np.flatnonzero(~is_still)
    if not len(moved):
        return []
    edges = np.flatnonzero(np.diff(is_still.astype(int)))
    places = []
    for begin, end in pairwise([0, *(edges + 1).tolist(), len(track)]):
        last = min(end, len(track) - 1)
        length_s = float(track.times[last] - track.times[begin]) / NS
        if is_still[begin] and begin >= moved[0] and length_s >= STOP_S:
            at = float(track.x[begin]), float(track.y[begin])
            places.append((int(track.times[begin]), length_s, *at))
    return places


def leaves(run: RecordedRun) -> list[tuple[int, Counter[str], float]]:
    """Return for each leaf that ran its index, the number of each end, and its running time, s."""
    inner = {node.parent for index, node in enumerate(run.tree) if node.parent != index}
    return [
        (
            index,
            Counter(span.status for span in spans),
            sum(span.end_ns - span.start_ns for span in spans) / NS,
        )
        for index, spans in enumerate(run.spans)
        if spans and index not in inner
    ]
