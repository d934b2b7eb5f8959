"""What is reckoned from a run: stops, leaves, what failed and why."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bt_mission.recording.model import FAILURE, RecordedRun, Series, Track

STILL_M_S = 0.01
STILL_RAD_S = 0.02
STOP_S = 1.5
"""A robot that stands still for so long has stopped."""


@dataclass(frozen=True)
class Stop:
    """The robot stood still."""

    start_ns: int
    seconds: float
    x: float
    y: float


@dataclass(frozen=True)
class LeafFigures:
    """What came of a leaf of the tree: how often it ended how, and how long it ran in all."""

    node: int
    ends: Counter[str]
    seconds: float


def duration_s(run: RecordedRun) -> float:
    """Length of the run, s; never nothing."""
    return max(since_start_s(run, run.end_ns), 0.05)


def mission_s(run: RecordedRun) -> float:
    """How long the mission took, s: what `run` has printed, where it was not killed before."""
    return float(run.summary.get("virtual_s", since_start_s(run, run.end_ns)))


def since_start_s(run: RecordedRun, time_ns: int) -> float:
    """Time since the start of the run, s."""
    return (time_ns - run.start_ns) / 1e9


def inner_nodes(run: RecordedRun) -> set[int]:
    """The nodes that have children."""
    return {node.parent for number, node in enumerate(run.tree) if node.parent != number}


def stops(track: Track) -> list[Stop]:
    """Where the robot stood, other than before it first moved."""
    if len(track) < 2:
        return []
    is_still = (np.abs(track.speed) < STILL_M_S) & (np.abs(track.turn) < STILL_RAD_S)
    moved = np.flatnonzero(~is_still)
    if not len(moved):
        return []
    edges = np.flatnonzero(np.diff(is_still.astype(int)))
    bounds = [0, *(edges + 1).tolist(), len(track)]
    found = []
    for begin, end in pairwise(bounds):
        if not is_still[begin] or begin < moved[0]:
            continue
        last = min(end, len(track) - 1)
        length_s = float(track.times[last] - track.times[begin]) / 1e9
        if length_s >= STOP_S:
            found.append(
                Stop(
                    int(track.times[begin]), length_s, float(track.x[begin]), float(track.y[begin])
                )
            )
    return found


def clearance(run: RecordedRun) -> Series:
    """Distance from the robot's hull to the nearest thing that its lidar saw, m, over time."""
    seen = [scan for scan in run.scans if np.isfinite(scan.clearance)]
    return Series(
        np.array([scan.time_ns for scan in seen], np.int64),
        np.array([scan.clearance for scan in seen], np.float64),
    )


def leaves(run: RecordedRun) -> list[LeafFigures]:
    """The leaves that have run, in the order of the tree."""
    inner = inner_nodes(run)
    return [
        LeafFigures(
            number,
            Counter(span.status for span in spans),
            sum(span.end_ns - span.start_ns for span in spans) / 1e9,
        )
        for number, spans in enumerate(run.spans)
        if spans and number not in inner
    ]


def way_to_failure(run: RecordedRun) -> list[int]:
    """The nodes from the root down to the leaf whose failure came last, if the mission failed."""
    if not run.spans or not run.spans[0] or run.spans[0][-1].status != FAILURE:
        return []
    way = [0]
    while True:
        end_ns = run.spans[way[-1]][-1].end_ns
        failed = [
            (run.spans[child][-1].end_ns, child)
            for child, node in enumerate(run.tree)
            if node.parent == way[-1]
            and child != way[-1]
            and run.spans[child]
            and run.spans[child][-1].status == FAILURE
            and run.spans[child][-1].end_ns <= end_ns
        ]
        if not failed:
            return way
        way.append(max(failed)[1])


def distance_m(run: RecordedRun) -> float | None:
    """How far it drove: as the simulation knows, else as far as it is known at all."""
    known = run.summary.get("distance_travelled_m")
    if known is not None:
        return float(known)
    return float(run.track.distance[-1]) if len(run.track) else None
