"""A node's clock can be wrong, and its timers follow it, while time goes on for everybody else."""

from __future__ import annotations

from typing import Any

import pytest

S = 1_000_000_000
MS = 1_000_000


@pytest.fixture
def fired(rig: Any) -> dict[str, list[int]]:
    """When timers of 0.5 s fire on two nodes, ms of right time; the clock of the first is wrong."""
    log: dict[str, list[int]] = {}

    def watch(name: str) -> None:
        log[name] = []
        rig.node(name).create_timer(0.5, lambda: log[name].append((rig.clock.now_ns - S) // MS))

    watch("wrong")
    watch("right")
    return log


def run(rig: Any, until_s: float) -> None:
    """Until a time since the start."""
    rig.steps_until(S + round(until_s * S))


def test_a_clock_set_ahead_has_the_timer_fire_once(rig: Any, fired: dict[str, list[int]]) -> None:
    """At once, and then as before."""
    run(rig, 0.7)
    wrong = rig.nodes[0]
    rig.clock.clocks.set_ahead(wrong, 100 * S, rig.clock.now_ns)
    assert rig.now(wrong) == rig.clock.now_ns + 100 * S
    run(rig, 1.6)
    assert fired == {"wrong": [500, 500, 1000, 1500], "right": [500, 1000, 1500]}


def test_a_clock_set_back_does_not_stop_the_timer(rig: Any, fired: dict[str, list[int]]) -> None:
    """The next period starts anew."""
    run(rig, 2.2)
    rig.clock.clocks.set_ahead(rig.nodes[0], -2 * S, rig.clock.now_ns)
    run(rig, 3.2)
    assert fired == {name: [500, 1000, 1500, 2000, 2500, 3000] for name in fired}


def test_a_clock_that_stands_still_goes_on_from_there(
    rig: Any, fired: dict[str, list[int]]
) -> None:
    """Its timers lose the time in which it stood."""
    run(rig, 1.2)
    clocks, executor = rig.clock.clocks, rig.clock
    executor.call_at(S + 1200 * MS, lambda: clocks.stop(rig.nodes[0], executor.now_ns))
    executor.call_at(S + 1900 * MS, lambda: clocks.go_on(rig.nodes[0], executor.now_ns))
    run(rig, 3.0)
    assert fired == {
        "wrong": [500, 1000, 2200, 2700],
        "right": [500, 1000, 1500, 2000, 2500, 3000],
    }
