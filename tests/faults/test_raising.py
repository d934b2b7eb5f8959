"""Exceptions in leaves and callbacks, and what a mission answers."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.faults.errors import ScenarioError


@pytest.mark.parametrize(
    ("leaf", "method", "on", "ended"),
    [
        ("turn", "update", 1, 1.0),
        ("turn", "update", 3, 1.1),
        ("0.0", "terminate", 1, 1.95),
        ("turn", "initialise", 1, None),
    ],
)
def test_an_exception_in_a_leaf(
    stage: Any, turn: Any, leaf: str, method: str, on: int, ended: float | None
) -> None:
    """Ends the mission with the cause; the goal is cancelled, the end confirmed."""
    run = turn(timeout=5)
    fault = stage.faults.raise_in_leaf(leaf, ValueError("oh"), method=method, on=on)
    if ended is None:
        run.do(fault)
    else:
        run.at(1.0, fault)
    run.until_done()
    assert run.failed
    assert run.reason.startswith("ValueError: oh (servers.py:")
    assert [goal.status for goal in run.goals] == (
        [] if ended is None else ["succeeded" if ended == 1.95 else "canceled"]
    )
    if ended is not None:
        assert run.t == pytest.approx(ended + 0.05, abs=0.051)
        assert run.now.commanded[1] == 0 or run.t < 2
    assert run.close() == ()


def test_a_leaf_is_sound_after_the_fault(stage: Any, turn: Any) -> None:
    """It raises once, or not at all when the fault has ended before."""
    run = turn(timeout=5)
    run.do(stage.faults.raise_in_leaf("turn", on=50, lasting=1.0))
    run.until_done()
    assert run.succeeded
    assert run.find("turn").call_hooks == ()


def test_an_exception_in_a_callback(stage: Any, turn: Any) -> None:
    """Of a topic or a service of a node: the mission fails with the cause, the robot is stopped."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.raise_in_callback("bt_mission_servers", "scan", on=2))
    run.until_done()
    assert (run.failed, run.t) == (True, 1.1)
    assert run.reason.startswith("a callback failed: RuntimeError: made by a fault (")
    assert [goal.status for goal in run.goals] == ["canceled"]
    run = stage.run("mission: m\ntree: {service: {name: /stop, type: std_srvs/srv/Trigger}}\n")
    run.do(stage.faults.raise_in_callback("/bt_mission_servers", "stop", OSError("disk")))
    run.until_done()
    assert run.reason.startswith("a callback failed: OSError: disk")


def test_what_is_not_there(stage: Any, turn: Any) -> None:
    """What is stands in the error."""
    run = turn(timeout=5)
    faults = stage.faults
    for fault, reason in (
        (
            faults.raise_in_leaf("tern"),
            "unknown node 'tern'",
        ),
        (faults.raise_in_leaf("turns"), "unknown leaf 'turns'"),
        (faults.raise_in_callback("sim", "scan"), "unknown node '/sim'"),
        (
            faults.raise_in_callback("bt_mission_sim", "scan"),
            "unknown topic or service of /bt_mission_sim '/scan'",
        ),
    ):
        with pytest.raises(ScenarioError, match=reason):
            run.do(fault)
