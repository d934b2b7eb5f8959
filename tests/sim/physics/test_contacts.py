"""Collisions: one for each onset, with the obstacle's name."""

import pytest

WALL = {"name": "the wall", "from": [0.4, -1], "to": [0.4, 1], "thickness": 0.02}


def test_driving_into_a_wall_is_one_collision(simulate, drive):
    """However long it pushes; time, name, place and force are told."""
    simulation = simulate(walls=[WALL])
    drive(simulation, 5.0, linear=0.2)
    (collision,) = simulation.take_collisions()
    assert simulation.collisions == 1
    assert collision.obstacle == "the wall"
    # 0.39 m to the face, less 0.069 m of hull, at 0.2 m/s with 0.02 m lost to the ramp.
    assert collision.time_ns / 1e9 == pytest.approx(1 + 0.321 / 0.2 + 0.11, abs=0.03)
    assert collision.point[0] == pytest.approx(0.39, abs=0.005)
    assert abs(collision.point[1]) <= 0.154
    assert collision.force > 0


def test_collisions_are_handed_over_once(simulate, drive):
    """The count stays, the list is taken."""
    simulation = simulate(walls=[WALL])
    drive(simulation, 3.0, linear=0.2)
    assert len(simulation.take_collisions()) == 1
    assert simulation.take_collisions() == []
    assert simulation.collisions == 1


def test_coming_back_is_another_collision(simulate, drive):
    """Away for more than a quarter of a second, then into the wall again."""
    simulation = simulate(walls=[WALL])
    for _ in range(2):
        drive(simulation, 2.5, linear=0.2)
        drive(simulation, 1.0, linear=-0.2)
    assert [collision.obstacle for collision in simulation.take_collisions()] == ["the wall"] * 2


def test_two_obstacles_are_two_collisions(simulate, drive):
    """Each is named."""
    pillars = [
        {"name": "left", "x": 0.4, "y": 0.12, "radius": 0.05},
        {"name": "right", "x": 0.4, "y": -0.12, "radius": 0.05},
    ]
    simulation = simulate(cylinders=pillars)
    drive(simulation, 3.0, linear=0.2)
    assert sorted(c.obstacle for c in simulation.take_collisions()) == ["left", "right"]


def test_a_wheel_that_touches_counts_too(simulate, drive):
    """Turning with a pillar beside the wheel: the wheel's rim hits it."""
    beside = {"name": "beside", "x": 0.03, "y": 0.183, "radius": 0.02}
    simulation = simulate(cylinders=[beside])
    drive(simulation, 1.0, angular=-1.0)
    assert [collision.obstacle for collision in simulation.take_collisions()] == ["beside"]


def test_the_floor_is_no_obstacle(simulate, drive):
    """Driving in the open counts nothing."""
    simulation = simulate()
    drive(simulation, 5.0, 0.2, 1.0)
    assert simulation.collisions == 0
    assert simulation.take_collisions() == []
