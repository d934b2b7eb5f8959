"""Runs, as they are known from their recordings alone."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from py_trees.common import Status

from bt_mission.executive.events.events import NodeChanged
from bt_mission.recording.model import RecordedRun, Span, Track
from bt_mission.recording.reader import read_run, spans_of
from bt_mission.recording.reading import RecordingError
from bt_mission.robots.model import load_robot

S = 1_000_000_000
BLOCKED = """\
mission: blocked
world: dqn_stage1
seed: 1
tree:
  sequence:
    - fallback:
        - turn: {angle: 90, angular_velocity: 99}
          timeout: 30
          name: too fast
        - turn: {angle: 90}
          timeout: 30
          cancel_when: current_angle > 20
          on_cancel: success
          name: cut short
    - parallel:
        - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
          timeout: 60
          name: drive
        - sequence:
            - wait: 3
            - check: 1 > 2
              name: no more
"""


@pytest.fixture
def recorded(record: Callable[..., Any]) -> tuple[RecordedRun, Any]:
    """A run in which goals end in four ways, and its stage."""
    run = record(text=BLOCKED)
    return read_run(run.path), run


def test_what_it_was_and_came_to(recorded: tuple[RecordedRun, Any]) -> None:
    """Also what it was run with."""
    run, made = recorded
    assert (run.mission, run.node, run.status) == ("blocked", "/bt_mission", "failure")
    assert run.reason == made.stage.executive.reason
    assert run.summary["trace_sha256"] == made.trace
    assert (run.facts["seed"], run.facts["world"]) == ("1", "dqn_stage1")
    assert (run.why_cut, run.missing) == ("", "")
    assert run.files == {"<text>": BLOCKED}
    assert (run.start_ns, run.end_ns) == (S, made.stage.now_ns)
    assert run.versions["mujoco"].startswith("4.")


def statuses_at(run: RecordedRun, time_ns: int) -> list[str]:
    """The status of each node at a time; empty for one that has not run yet."""
    statuses = []
    for spans in run.spans:
        begun = [span for span in spans if span.start_ns <= time_ns]
        has_ended = begun and begun[-1].end_ns <= time_ns
        statuses.append((begun[-1].status if has_ended else "running") if begun else "")
    return statuses


def test_the_tree_and_its_statuses(recorded: tuple[RecordedRun, Any]) -> None:
    """At the end, and at every instant in between."""
    run, made = recorded
    nodes = made.stage.executive.nodes
    assert [node.name for node in run.tree] == [node.name for node in nodes]
    names = {"INVALID": "halted", "RUNNING": "running", "SUCCESS": "success", "FAILURE": "failure"}
    for status, node in zip(statuses_at(run, run.end_ns), nodes, strict=True):
        # A node that its parent resets after it has ended says no more.
        assert node.status is Status.INVALID or status == names[node.status.value]
    by_name = {node.name: number for number, node in enumerate(run.tree)}
    assert statuses_at(run, S) == [""] * len(nodes)
    later = statuses_at(run, 3 * S)
    assert later[by_name["cut short"]] == "success"
    assert later[by_name["drive"]] == "running"
    drive = run.spans[by_name["drive"]]
    assert [span.status for span in drive] == ["halted"]
    assert drive[0].end_ns - drive[0].start_ns == pytest.approx(3 * S, abs=0.1 * S)
    for spans in run.spans:
        for before, after in itertools.pairwise(spans):
            assert before.end_ns <= after.start_ns


def test_goals_and_their_lives(recorded: tuple[RecordedRun, Any]) -> None:
    """In the order in which they were sent."""
    run, _ = recorded
    rejected, cut, halted = run.goals
    assert [goal.owner for goal in run.goals] == ["too fast", "cut short", "drive"]
    assert [goal.status for goal in run.goals] == ["rejected", "canceled", "canceled"]
    assert [goal.action for goal in run.goals] == ["/turn", "/turn", "/explore_forward"]
    assert halted.type_name == "bt_mission_interfaces/action/ExploreForward"
    assert rejected.sent_ns == rejected.rejected_ns == S + S // 20
    assert rejected.accepted_ns is None
    assert cut.values["angle"] == 90.0
    assert cut.sent_ns is not None
    assert len(cut.cancels) == 1
    assert cut.cancels[0].asked_ns > cut.sent_ns
    assert cut.end_ns == cut.cancels[0].asked_ns
    assert cut.result is not None
    assert 0 < cut.result["angle_turned"] < 90
    assert halted.released_ns is not None
    times = [time_ns for time_ns, _ in halted.feedback]
    assert times == sorted(times)
    assert halted.feedback[-1][1]["current_distance_travelled"] > 0.3
    assert [
        goal
        for goal in run.goals
        if (goal.sent_ns or 0) <= 2 * S < (run.end_ns if goal.end_ns is None else goal.end_ns)
    ] == [halted]
    assert None not in [goal.end_ns for goal in run.goals]


def test_where_it_was(recorded: tuple[RecordedRun, Any]) -> None:
    """Truly, and by its odometry, which starts where it stood."""
    run, made = recorded
    assert run.truth.at(run.end_ns) == pytest.approx(made.stage.sim.robots[0].pose, abs=1e-9)
    assert run.truth.distance[-1] == pytest.approx(
        made.stage.runs[0].distance_travelled_m, abs=0.01
    )
    ours, theirs = run.measured.at(run.end_ns), run.truth.at(run.end_ns)
    assert ours is not None
    assert ours[:2] == pytest.approx(theirs[:2], abs=0.05)  # type: ignore[index]
    assert run.track is run.truth
    empty = np.zeros(0)
    untrue = replace(run, truth=Track(empty.astype(np.int64), empty, empty, empty, empty, empty))
    assert untrue.track is run.measured
    hull = load_robot("waffle").hull
    assert run.hull == (hull.front, hull.rear, hull.half_width)
    assert len(run.battery) == len(run.truth)
    assert 99 < run.battery.values[-1] < 100


def test_what_it_saw(recorded: tuple[RecordedRun, Any]) -> None:
    """The points of a scan, put where the robot was, lie on the walls of the map."""
    run, _ = recorded
    assert run.grid is not None
    scan = [measured for measured in run.scans if measured.time_ns <= 4 * S][-1]
    pose = run.truth.at(4 * S)
    assert pose is not None
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cos * scan.points[:, 0] - sin * scan.points[:, 1]
    y = pose[1] + sin * scan.points[:, 0] + cos * scan.points[:, 1]
    columns = ((x - run.grid.x) / run.grid.resolution).astype(int)
    rows = ((y - run.grid.y) / run.grid.resolution).astype(int)
    near = [
        run.grid.cells[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].max()
        for row, column in zip(rows, columns, strict=True)
    ]
    assert np.mean(np.array(near) == 100) > 0.95
    assert 0.3 < scan.clearance < 3.5
    assert run.scans[0].time_ns > 0


def test_what_was_said(recorded: tuple[RecordedRun, Any]) -> None:
    """The end is an error when the mission failed."""
    run, _ = recorded
    assert run.log[-1].text == f"mission: failure: {run.reason}"
    assert run.log[-1].level == 40
    assert any("'too fast' rejected" in line.text and line.level == 30 for line in run.log)


def test_a_recording_of_something_else_is_refused(tmp_path: Path) -> None:
    """With the topics that are in it."""
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "other")
        for topic in "abcdefg":
            channel = writer.register_channel(f"/{topic}", "json", 0)
            writer.add_message(channel, 5, b"{}", 5)
        writer.finish()
    with pytest.raises(
        RecordingError, match=r"no run of a mission; .*\(topics here: /a, /b, .*\.\.\."
    ):
        read_run(path)


def test_a_node_runs_from_its_start_to_its_end() -> None:
    """Again and again; one that ends at once has run for no time, and one that runs to the end."""
    changes = [
        (1, NodeChanged(1, 0, Status.RUNNING, "")),
        (1, NodeChanged(1, 1, Status.SUCCESS, "at once")),
        (3, NodeChanged(3, 1, Status.RUNNING, "go")),
        (5, NodeChanged(5, 1, Status.INVALID, "")),
        (6, NodeChanged(6, 0, Status.FAILURE, "no")),
        (7, NodeChanged(7, 2, Status.RUNNING, "on")),
    ]
    assert spans_of(4, changes, 9) == (
        (Span(1, 6, "failure", "no"),),
        (Span(1, 1, "success", "at once"), Span(3, 5, "halted", "")),
        (Span(7, 9, "running", "on"),),
        (),
    )
