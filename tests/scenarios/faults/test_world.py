"""Obstacles that appear, move and vanish, and what a mission answers."""

from __future__ import annotations

import math
from typing import Any

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError

DRIVE = """
mission: drives
world: empty_arena
tree:
  explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
  timeout: 20
  name: drive
"""
WAITS = "mission: waits\nworld: empty_arena\ntree: {wait: 3}\n"


def test_it_stops_before_a_box_that_appears(stage: Any) -> None:
    """The box stands where it was said: a metre ahead of the axle, at its nearest 0.9 m."""
    run = stage.run(DRIVE)
    run.at(1.0, stage.spawn_box(ahead=1.0))
    run.until(lambda s: s.leaf("drive").succeeded)
    assert run.t == 2.9
    assert run.now.nearest == "box"
    assert run.now.clearance == pytest.approx(0.514, abs=0.01)
    assert run.now.x == pytest.approx(0.475, abs=0.01)
    assert run.check("always clearance > 0.5")


def test_clearance_before_and_after(stage: Any) -> None:
    """At every moment, as the world was then: worked out when it is asked for."""
    run = stage.run(WAITS)
    box = stage.spawn_box(ahead=0.5, lasting=1.0)
    run.at(1.0, box)
    run.until_done()
    before, there, after = run.moments[10], run.moments[25], run.moments[50]
    assert (before.nearest, there.nearest, after.nearest) == ("west wall", "box", "west wall")
    assert there.clearance == pytest.approx(0.5 - 0.1 - 0.07, abs=0.02)
    assert before.clearance == pytest.approx(after.clearance, abs=1e-3)


def test_a_box_moves_and_vanishes(stage: Any) -> None:
    """By what made it, or by its name; the robot stands where it is."""
    run = stage.run(WAITS)
    box = stage.spawn_box(ahead=1.0, left=0.5, name="crate")
    run.at(0.2, box)
    run.at(0.5, stage.move_box(box, at=(1.0, -0.5), speed=0.5))
    run.at(1.5, stage.move_box("crate", ahead=0.6, speed=1.0))
    run.at(2.8, stage.remove_box("crate"))
    places = []
    run.when(lambda s: s.t > 1.2, lambda r: places.append(next(iter(props(r))).position))
    run.until(lambda s: s.t > 2.7)
    places.append(next(iter(props(run))).position)
    run.until_done()
    assert places == [
        (pytest.approx(1.0), pytest.approx(0.125, abs=0.01)),
        (pytest.approx(0.6), pytest.approx(0.0, abs=0.01)),
    ]
    assert (len(props(run)), run.faults[0].ended_ns) == (0, 3_800_000_000)


def test_what_moves_into_a_robot_pushes_it(stage: Any) -> None:
    """Which is a collision of its name."""
    run = stage.run(WAITS)
    run.record("collisions")
    run.do(stage.spawn_cylinder(ahead=0.6, radius=0.1, height=0.3))
    run.at(0.2, stage.move_box("cylinder", ahead=-1.0, speed=0.5))
    run.until_done()
    assert run.topic("collisions").messages[0].obstacle == "cylinder"
    assert run.now.x < -0.2
    assert run.check("eventually clearance < 0.001")


def test_names_are_their_own(stage: Any) -> None:
    """A second of a name has a number; what is ahead is so as the robot stands then."""
    run = stage.run("mission: m\nworld: empty_arena\ntree: {turn: {angle: 90}, timeout: 9}\n")
    run.until_done()
    run.do(stage.spawn_box(ahead=1.0, left=0.3), stage.spawn_box(at=(1.0, 0.0), yaw=45))
    first, second = props(run)
    assert (first.name, second.name) == ("box", "box 2")
    assert first.position == (pytest.approx(-0.3, abs=0.02), pytest.approx(1.0, abs=0.02))
    assert second.obstacle.yaw == pytest.approx(0.785, abs=0.001)


def test_what_cannot_be(stage: Any) -> None:
    """Is refused: no place, a place that is taken, no obstacle of that name, too many of them."""
    run = stage.run(WAITS)
    box = stage.spawn_box(at=(-1.5, 1.0))
    for fault, reason in (
        (stage.spawn_box(ahead=0.1), r"spawn_box: prop 'box' does not fit at .*in the robot"),
        (stage.spawn_box(at=(50, 0)), r"spawn_box: prop 'box': \(50, 0\) is not on the floor"),
        (stage.move_box("box", ahead=1), "unknown spawned obstacle 'box'"),
        (stage.move_box("box"), "move_box: give a place"),
        (stage.remove_box(box), "has no obstacle in the world now"),
    ):
        with pytest.raises(ScenarioError, match=reason):
            run.do(fault)
    run.do(box, *(stage.spawn_box(at=(x, 1.0)) for x in (-0.5, 0.5, 1.5)))
    with pytest.raises(ScenarioError, match="make it with props=5 or more"):
        run.do(stage.spawn_box(at=(0, -1.0)))
    run.until_done()
    run = stage.run(WAITS, props=0)
    with pytest.raises(ScenarioError, match="make it with props=1 or more"):
        run.do(stage.spawn_box(ahead=1.0))
    run.step()


def test_spare_obstacles_change_no_run(stage: Any) -> None:
    """Until one appears, it is the run without them."""
    hashes = set()
    for props_ in (0, 4):
        run = stage.run(DRIVE, props=props_)
        run.advance(3.0)
        run.close()
        hashes.add(run.stage.trace.sha256)
    assert len(hashes) == 1


def props(run: Any) -> Any:
    """The obstacles in the world that were spawned."""
    return run.stage.sim.physics.props


def test_the_nearest_free_place(stage: Any) -> None:
    """Where there is no room, an obstacle stands beside what is there; where there is, as said."""
    run = stage.run(WAITS)
    for at in ((1.0, 0.0), (0.0, 0.0), (1.99, 0.0), (1.0, 0.0)):
        run.do(stage.spawn_box(at=at, nearest_free=True))
    run.until(lambda s: s.t >= 0.1)
    free, robot, wall, box = (prop.position for prop in props(run))
    assert free == (1.0, 0.0)
    assert 0.15 < math.hypot(*robot) < 0.5
    assert 1.7 < wall[0] < 1.9
    assert 0.19 < math.dist(free, box) < 0.35
    run.until_done()
    assert run.check("never collisions > 0")


def test_beyond_the_floor(stage: Any) -> None:
    """The nearest place of the floor counts, for what appears and for what moves."""
    run = stage.run(WAITS)
    run.do(stage.spawn_box(at=(9.0, 0.0), nearest_free=True))
    run.at(0.5, stage.move_box(at=(0.8, 50.0), speed=2.0, nearest_free=True))
    run.until(lambda s: s.t >= 0.1)
    (box,) = props(run)
    assert 1.7 < box.position[0] < 1.9
    run.until_done()
    assert 1.5 < box.position[1] < 2.3
