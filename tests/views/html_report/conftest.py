"""A run for pages: made of nothing but the model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from py_trees.common import Status

from bt_mission.events.events import NodeChanged, NodeInfo
from bt_mission.recording.model import (
    Picture,
    RecordedCollision,
    RecordedGoal,
    RecordedGrid,
    RecordedLine,
    RecordedRun,
    RecordedScan,
    Series,
    Track,
)
from bt_mission.recording.reader import spans_of

S = 1_000_000_000
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c489"
    "0000000d49444154789c6360f8cf500f0003860180347d6b610000000049454e44ae426082"
)


def seconds(*values: float) -> Any:
    """Times since the start, in the run's own."""
    return S + (np.array(values) * S).astype(np.int64)


@pytest.fixture
def a_run() -> Callable[..., RecordedRun]:
    """A run of ten seconds that failed: ``a_run(status="success")`` changes what is named."""
    changes = [
        (S, NodeChanged(S, 0, Status.RUNNING, "")),
        (S, NodeChanged(S, 1, Status.RUNNING, "")),
        (3 * S, NodeChanged(3 * S, 1, Status.SUCCESS, "there")),
        (3 * S, NodeChanged(3 * S, 2, Status.RUNNING, "")),
        (3 * S, NodeChanged(3 * S, 3, Status.FAILURE, "1 > 2 does not hold")),
        (8 * S, NodeChanged(8 * S, 2, Status.INVALID, "")),
        (11 * S, NodeChanged(11 * S, 0, Status.FAILURE, "")),
    ]
    time = np.linspace(0, 10, 201)
    moves = np.clip(time - 1, 0, 4)
    track = Track(
        seconds(*time),
        moves * 0.2,
        moves * 0.0 + 0.5,
        moves * 0.0,
        np.where((time > 1) & (time < 5), 0.2, 0.0),
        moves * 0.0,
    )
    goal = RecordedGoal(
        "a" * 32,
        "/turn",
        "x/action/Turn",
        "turn <b>",
        sent_ns=S,
        accepted_ns=S,
        cancel_ns=2 * S,
        ended_ns=3 * S,
        status="canceled",
        values={"angle": 90.0, "pose": {"x": 0.0, "y": 2.5}},
        result={"error_code": 0, "error_msg": "<script>alert(1)</script>"},
        feedback=[(2 * S, {"left": 1.0})],
    )
    made = RecordedRun(
        path=Path("run.mcap"),
        mission="try <i>this</i>",
        node="/bt_mission",
        facts={"seed": "7", "world": "arena", "robot": "waffle", "inputs": '{"speed": 0.2}'},
        summary={"wall_s": 1.5, "collisions": 1},
        start_ns=S,
        end_ns=11 * S,
        status="failure",
        reason="'check' 1 > 2 does not hold",
        why_cut="",
        missing="",
        tree=(
            NodeInfo("root", "Sequence", "0", 0),
            NodeInfo("turn", "ActionLeaf", "0.0", 0),
            NodeInfo("drive", "ActionLeaf", "0.1", 0),
            NodeInfo("check", "Check", "0.2", 0),
            NodeInfo("never", "Wait", "0.3", 0),
        ),
        spans=spans_of(5, changes, 11 * S),
        truth=track,
        measured=replace(track, y=track.y + 0.02),
        scans=(RecordedScan(2 * S, np.array([[1.0, 0.0], [0.0, 1.0]]), 0.8),),
        grid=RecordedGrid(
            S, 0.1, -1.0, -1.0, np.pad(np.zeros((28, 28), np.int8), 1, constant_values=100)
        ),
        goals=(goal,),
        log=(RecordedLine(2 * S, 30, "bt_mission", "mind </pre> the gap"),),
        battery=Series(seconds(0, 10), np.array([100.0, 99.0])),
        collisions=(RecordedCollision(6 * S, "north wall", 0.8, 0.6, 3.0),),
        pictures=(Picture(4 * S, "sweep/image_01.png", "image/png", PNG),),
        files={"m.yaml": "mission: try\n# </script><b>\n"},
        versions={"python": "3.11"},
        hull=(0.07, -0.2, 0.15),
    )

    def change(**fields: Any) -> RecordedRun:
        return replace(made, **fields)

    return change
