import math

import numpy as np
import pytest

from action_servers.core.geometry import (
    between,
    composed,
    distance,
    into_frame,
    out_of_frame,
    relative,
    wrapped,
)
from action_servers.core.maneuver import Pose2D


def test_wrapped_angles_lie_within_half_a_turn():
    """Half a turn and a bit to the left is a bit less than half a turn to the right."""
    assert wrapped(math.pi + 0.1) == pytest.approx(-math.pi + 0.1)
    assert wrapped(-5 * math.tau + 0.2) == pytest.approx(0.2)


def test_a_point_ahead_of_a_robot_that_faces_up_lies_above_it():
    """In the robot's frame x is forward and y left."""
    facing_up = Pose2D(1.0, 2.0, math.pi / 2)
    assert out_of_frame(facing_up, np.array([[0.5, 0.0]])) == pytest.approx(np.array([[1.0, 2.5]]))
    assert into_frame(facing_up, np.array([[1.0, 2.5]])) == pytest.approx(np.array([[0.5, 0.0]]))


def test_relative_undoes_composed():
    """A pose seen from another, put back, is the pose."""
    outer, inner = Pose2D(1.0, -2.0, 2.5), Pose2D(0.3, 0.4, 1.5)
    back = relative(outer, composed(outer, inner))
    assert (back.x, back.y, back.yaw) == pytest.approx((0.3, 0.4, 1.5))
    assert distance(outer, composed(outer, inner)) == pytest.approx(0.5)


def test_between_turns_the_short_way_round():
    """From 170 to -170 degrees it goes over 180, not over 0."""
    middle = between(Pose2D(0.0, 0.0, math.radians(170)), Pose2D(1.0, 2.0, math.radians(-170)), 0.5)
    assert (middle.x, middle.y) == (0.5, 1.0)
    assert abs(middle.yaw) == pytest.approx(math.pi)
