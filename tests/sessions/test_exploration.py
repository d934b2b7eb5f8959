"""Exploring a world whose map is not known, by each of the strategies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from action_servers.core.grid import OCCUPIED_FROM
from sim.world.loader import load_world
from sim.world.occupancy import FREE, rasterise
from tests.support.thorough import sample

STRATEGIES = ("fixed", "random", "levy", "informed")


EXPLORE_THEN_GO = """
mission: explore then go
world: dqn_stage4
map: unknown
tree:
  sequence:
    - explore_frontiers: {min_frontier: 0.4}
      timeout: 300
      outputs: {area_mapped: area, frontiers_visited: visited}
    - navigate_to_pose: {pose: [1.7, -1.7, 90]}
      timeout: 120
    - log: "$area $visited"
"""


@pytest.mark.thorough
@pytest.mark.parametrize("strategy", sample(STRATEGIES, every=2))
def test_each_strategy_maps_another_world_without_collision(stage: Any, strategy: str) -> None:
    """In half a minute half of an arena of low walls, and never a touch."""
    run = stage.run(f"explore_{strategy}", world="explore_arena", seed=4, inputs={"duration": "30"})
    run.until_done()
    assert (run.status, run.stage.runs[0].collisions) == ("success", 0)
    assert run.report.goals_left_behind == 0
    assert run.t == pytest.approx(30.0, abs=0.5)
    assert run.stage.mapper.measure.area > 7.0


def test_the_world_publishes_no_map_where_the_mapper_does(stage: Any) -> None:
    """One publisher of the topic, whichever it is."""
    for name, has_mapper in (("explore_fixed", True), ("square", False)):
        run = stage.run(name)
        assert (run.stage.mapper is not None) is has_mapper
        assert run.stage.node.count_publishers("map") == 1
        run.step()
        run.close()


@pytest.mark.thorough
def test_a_run_with_a_mapper_repeats(stage: Any) -> None:
    """The same seed gives the same map, cell for cell."""
    maps = []
    for _ in range(2):
        run = stage.run("explore_random", inputs={"duration": "15"})
        run.until_done()
        maps.append(run.stage.mapper.grid)
    assert np.array_equal(maps[0].cells, maps[1].cells)
    assert maps[0].stamp == maps[1].stamp


@pytest.mark.thorough
def test_what_was_explored_can_be_navigated(stage: Any) -> None:
    """Frontiers until none is left, then to a place behind two walls, by the map just made."""
    run = stage.run(EXPLORE_THEN_GO)
    run.until_done()
    assert (run.status, run.reason) == ("success", "")
    assert run.stage.runs[0].collisions == 0
    x, y, _ = run.pose
    assert math.hypot(x - 1.7, y + 1.7) < 0.15
    area, visited = (float(part) for part in run.log[-1].split())
    assert area > 20.0
    assert visited >= 1


@pytest.mark.thorough
def test_frontiers_leave_no_floor_unknown(stage: Any) -> None:
    """Nearly all the floor there is; and nothing that is wall is taken for floor."""
    run = stage.run("explore_frontiers", world="dqn_stage4")
    run.until_done()
    assert run.status == "success"
    grid = run.stage.mapper.grid
    truth = rasterise(load_world("dqn_stage4"))
    rows, columns = np.nonzero(truth.cells == FREE)
    x = truth.origin[0] + (columns + 0.5) * truth.resolution
    y = truth.origin[1] + (rows + 0.5) * truth.resolution
    inside = (np.abs(x) < 2.3) & (np.abs(y) < 2.3)
    row = np.floor((y[inside] - grid.origin_y) / grid.resolution).astype(int)
    column = np.floor((x[inside] - grid.origin_x) / grid.resolution).astype(int)
    seen = grid.cells[row, column]
    assert (seen == FREE).mean() > 0.9
    assert (seen >= OCCUPIED_FROM).mean() < 0.05
