"""Distances from a point on the floor to a shape's footprint."""

import math

import pytest

from sim.world.shapes import Obstacle


def box(yaw: float = 0.0) -> Obstacle:
    """A wall of 2 m x 0.2 m at (1, 1)."""
    return Obstacle.box("wall", 1, 1, yaw=yaw, size=(2.0, 0.2, 0.5), colour="white")


def test_distance_to_a_box_is_measured_from_its_faces_and_corners():
    """In front of a face it is the normal distance, beyond a corner the way to the corner."""
    assert box().distance(1, 1.6) == pytest.approx(0.5)
    assert box().distance(2.3, 1.5) == pytest.approx(0.5)


def test_distance_is_negative_inside():
    """In the middle it is minus half of the thinner side."""
    assert box().distance(1, 1) == pytest.approx(-0.1)


def test_a_box_turns_about_its_centre():
    """A quarter turn puts its length along y."""
    assert box(math.pi / 2).distance(1, 2.5) == pytest.approx(0.5)
    assert box(math.pi / 2).distance(1.6, 1) == pytest.approx(0.5)


def test_distance_to_a_cylinder_is_measured_from_its_rim():
    """It is the distance to the axis less the radius."""
    pillar = Obstacle.cylinder("pillar", 0, 0, radius=0.15, height=0.5, colour="red")
    assert pillar.distance(3, 4) == pytest.approx(4.85)
    assert pillar.radius == 0.15
    assert pillar.height == 0.5
