"""Recordings that earlier versions have made stay readable, with the same content.

``tests/data/recordings`` holds three: a mission that succeeded, one that failed, and one whose
process was killed. Beside each is what the version that made it had to say of it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bt_mission.cli import main
from bt_mission.recording.reader import read_run
from tests.support.project import ROOT

FOLDER = ROOT / "tests/data/recordings"
NAMES = ("success", "failure", "killed")
TIMES = (0.0, 0.5, 1.0, 2.0, 2.6)
"""Of the screens, s since the start of the mission."""


def plain(value: Any) -> Any:
    """A value of a message as JSON has it."""
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(one) for one in value]
    return value.item() if isinstance(value, np.generic) else value


def content(path: Path) -> dict[str, Any]:
    """All that a report is made of, without what is in it a thousand times."""
    run = read_run(path)
    return {
        "mission": [run.mission, run.node, run.status, run.reason, run.missing, run.why_cut],
        "facts": dict(run.facts),
        "summary": plain(run.summary),
        "times": [run.start_ns, run.end_ns],
        "tree": [[one.name, one.kind, one.path, one.parent] for one in run.tree],
        "spans": [
            [[one.start_ns, one.end_ns, one.status, one.message] for one in spans]
            for spans in run.spans
        ],
        "goals": [
            [
                *(goal.id, goal.action, goal.type_name, goal.owner, goal.status),
                *(goal.sent_ns, goal.accepted_ns, goal.rejected_ns, goal.handed_over_ns),
                *(goal.cancel_ns, goal.ended_ns, goal.given_up_ns, goal.end_ns),
                *(plain(goal.values), plain(goal.result), len(goal.feedback)),
                plain(goal.feedback[-1:]),
            ]
            for goal in run.goals
        ],
        "log": [[one.time_ns, one.level, one.name, one.text] for one in run.log],
        "tracks": [
            [len(track), round(float(track.distance[-1]), 9), plain(track.at(run.end_ns))]
            for track in (run.truth, run.measured)
        ],
        "scans": [
            len(run.scans),
            sum(len(one.points) for one in run.scans),
            round(min(one.clearance for one in run.scans), 9),
        ],
        "grid": None if run.grid is None else plain(run.grid.cells.shape),
        "battery": [len(run.battery), plain(run.battery.values[-1:])],
        "collisions": len(run.collisions),
        "pictures": [[one.name, one.media_type] for one in run.pictures],
        "files": dict(run.files),
        "hull": plain(run.hull),
    }


@pytest.mark.parametrize("name", NAMES)
def test_it_holds_what_it_held(name: str) -> None:
    """Facts, tree, statuses, goals, log, poses, scans."""
    known = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    assert json.loads(json.dumps(content(FOLDER / f"{name}.mcap"))) == known


@pytest.mark.parametrize("name", NAMES)
def test_it_is_replayed_as_it_was(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The lines of its trace, and the tree at any instant."""
    monkeypatch.chdir(FOLDER)
    file = f"{name}.mcap"
    screens = ""
    for arguments in (["--plain"], *(["--once", "--at", str(time_s)] for time_s in TIMES)):
        assert main(["replay", file, *arguments]) == 0
        screens += f"$ bt-mission replay {file} {' '.join(arguments)}\n{capsys.readouterr().out}"
    assert screens == (FOLDER / f"{name}.txt").read_text(encoding="utf-8")
