"""Exploring a world whose map is not known, by each of the strategies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

STRATEGIES = ("fixed", "random", "levy", "informed")


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_each_strategy_maps_another_world_without_collision(on_stage: Any, strategy: str) -> None:
    """In half a minute half of a world of nine columns, and never a touch."""
    run = on_stage(f"explore_{strategy}", world="turtlebot3_world", seed=4, set={"duration": "30"})
    run.until_done()
    assert (run.status, run.stage.collisions) == ("success", 0)
    assert run.stage.executive.goals_left_behind == ()
    assert run.seconds == pytest.approx(30.0, abs=0.5)
    assert run.stage.mapper.measure.area > 12.0


def test_the_world_publishes_no_map_where_the_mapper_does(on_stage: Any) -> None:
    """One publisher of the topic, whichever it is."""
    for name, has_mapper in (("explore_fixed", True), ("square", False)):
        run = on_stage(name)
        assert (run.stage.mapper is not None) is has_mapper
        assert run.stage.node.count_publishers("map") == 1


def test_a_run_with_a_mapper_repeats(on_stage: Any) -> None:
    """The same seed gives the same map, cell for cell."""
    maps = []
    for _ in range(2):
        run = on_stage("explore_random", set={"duration": "15"})
        run.until_done()
        maps.append(run.stage.mapper.grid)
    assert np.array_equal(maps[0].cells, maps[1].cells)
    assert maps[0].stamp == maps[1].stamp
