"""The picture that the robot's way is drawn on."""

import math
from typing import Any

import numpy as np
import pytest

from bt_mission.commands.video.ground import MOST_WAYPOINTS, SCAN, WAY, Ground


def pixel(x: Any, y: Any) -> tuple[Any, Any]:
    """A metre is 100 pixels; the middle of the map is that of the picture."""
    return 200 + 100 * x, 200 - 100 * y


@pytest.fixture
def ground() -> Ground:
    """A black floor."""
    return Ground(np.zeros((400, 400, 3), dtype=np.uint8), pixel)


def test_the_way_is_a_line(ground: Ground) -> None:
    """From where it began to where it has come."""
    ground.go(0.0, 0.0)
    assert not ground.picture.any()
    ground.go(1.0, 1.0)
    assert tuple(ground.picture[150, 250]) == WAY
    assert not ground.picture[250, 150].any()


def test_standing_draws_nothing(ground: Ground) -> None:
    """A way of less than a pixel waits until there is more."""
    ground.go(0.0, 0.0)
    for step in range(10):
        ground.go(0.001 * step, 0.0)
    assert not ground.picture.any()


def test_a_waypoint_is_marked_once(ground: Ground) -> None:
    """Named again, it is as it was; a place that is none is left out."""
    ground.mark(1.0, 0.0)
    once = ground.picture.copy()
    assert once[200 - 9, 300].any()
    ground.mark(1.0, 0.0)
    ground.mark(math.nan, 0.0)
    assert np.array_equal(ground.picture, once)


def test_waypoints_without_end_are_not_all_marked(ground: Ground) -> None:
    """They would cover the world."""
    for number in range(MOST_WAYPOINTS):
        ground.mark(0.0, number / 100)
    before = ground.picture.copy()
    ground.mark(1.5, 1.5)
    assert np.array_equal(ground.picture, before)


def test_zones_have_names(ground: Ground) -> None:
    """At their upper edge."""
    ground.name_zones([("A", 0.0, 0.0, 0.5)])
    assert ground.picture[152:172, 190:210].max() == 255
    assert not ground.picture[190:210, 190:210].any()


def test_a_scan_is_drawn_on_a_copy(ground: Ground) -> None:
    """Points outside of the picture are left out."""
    picture = ground.with_scan(np.array([[1.0, 1.0], [50.0, 0.0], [-50.0, -50.0]]))
    assert tuple(picture[100, 300]) == SCAN
    assert (picture == SCAN).all(axis=2).sum() == 4
    assert not ground.picture.any()
