"""A line through costs."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import pytest

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from sim.world.loader import load_world
from tests.support.project import ROOT


@pytest.fixture
def scaling(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The script."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "benchmarks"), *sys.path])
    return importlib.import_module("scaling")


def test_costs_on_a_line_are_linear(scaling):
    """What each costs, and what there is without any."""
    line = scaling.Line.through((10, 100, 1000), (120.0, 300.0, 2100.0))
    assert (line.fixed, line.each) == pytest.approx((100.0, 2.0))
    assert line.deviation == pytest.approx(0.0, abs=1e-9)
    assert line.verdict == "linear"


def test_costs_that_grow_with_the_square_are_not_linear(scaling):
    """The largest deviation is told as a share of the cost."""
    line = scaling.Line.through((1, 2, 4, 8, 16), (1.0, 4.0, 16.0, 64.0, 256.0))
    assert line.deviation > 0.5
    assert line.verdict == "**not linear**"


@pytest.mark.parametrize("count", [0, 10, 1000])
def test_a_world_has_as_many_boxes_as_wanted(scaling, count, tmp_path):
    """All away from the robot, which can turn."""
    world = load_world(scaling.world(count))
    assert len(world.boxes) == count
    assert all(max(abs(one.x), abs(one.y)) > 0.5 for one in world.boxes)
    assert load(scaling.TURNS).name == "turns"


@pytest.mark.parametrize(("what", "size"), [("robots", 3), ("rays", 90), ("nodes", 10)])
def test_a_stage_of_each_kind_runs(scaling, what, size, tmp_path):
    """With so many robots, rays or leaves."""
    with scaling.SWEEPS[what].make(size, tmp_path) as stage:
        assert isinstance(stage, Stage)
        for _ in range(3):
            stage.step()
        found = {
            "robots": len(stage.runs),
            "rays": stage.sim.robots[0].robot.lidar.rays,
            "nodes": len(stage.executive.nodes) - 1,
        }
        assert found[what] == size
