"""Obstacles that stand or move: collisions with them, one for each onset, and where they are."""

import numpy as np
import pytest

from tests.support.simulated import wait

WALL = {"name": "the wall", "from": [0.4, -1], "to": [0.4, 1], "thickness": 0.02}
PILLARS = [
    {"name": "left", "x": 0.4, "y": 0.12, "radius": 0.05},
    {"name": "right", "x": 0.4, "y": -0.12, "radius": 0.05},
]
BESIDE = {"name": "beside", "x": 0.03, "y": 0.183, "radius": 0.02}
COMING = {
    "name": "coming",
    "x": 1.0,
    "y": 0.0,
    "radius": 0.15,
    "motion": {"through": [[-1.0, 0.0]], "speed": 0.1},
}
ROUND = COMING | {"name": "round", "y": 1.0, "motion": {"around": [0.0, 0.0], "period": 80}}


def test_driving_into_a_wall_is_one_collision(simulate, drive):
    """However long it pushes: time, place and force. It is handed over once, and stays counted."""
    simulation = simulate(walls=[WALL])
    drive(simulation, 5.0, linear=0.2)
    (collision,) = simulation.take_collisions()
    assert collision.obstacle == "the wall"
    # 0.39 m to the face, less 0.069 m of hull, at 0.2 m/s with 0.02 m lost to the ramp.
    assert collision.time_ns / 1e9 == pytest.approx(1 + 0.321 / 0.2 + 0.11, abs=0.03)
    assert collision.point[0] == pytest.approx(0.39, abs=0.005)
    assert abs(collision.point[1]) <= 0.154
    assert collision.force > 0
    assert simulation.take_collisions() == []
    assert simulation.collisions == 1


@pytest.mark.parametrize(
    ("fields", "moves", "obstacles"),
    [
        ({"walls": [WALL]}, [(2.5, 0.2), (1.0, -0.2)] * 2, ["the wall"] * 2),
        ({"cylinders": PILLARS}, [(3.0, 0.2)], ["left", "right"]),
        ({"cylinders": [BESIDE]}, [(1.0, 0.0, -1.0)], ["beside"]),
        ({}, [(5.0, 0.2, 1.0)], []),
    ],
    ids=["coming back", "two obstacles", "the rim of a wheel", "the floor is none"],
)
def test_each_onset_counts(simulate, drive, fields, moves, obstacles):
    """Coming back is one after more than a quarter of a second."""
    simulation = simulate(**fields)
    for move in moves:
        drive(simulation, *move)
    assert sorted(each.obstacle for each in simulation.take_collisions()) == obstacles
    assert simulation.collisions == len(obstacles)


# ---- obstacles that move -----------------------------------------------------------------


def place(simulation, name):
    """Where a moving obstacle stands in the physics, and how fast it moves."""
    body = simulation.physics.data.body(f"mover/{name}")
    joint = simulation.physics.model.joint(f"mover/{name}/x")
    v = int(joint.dofadr[0])
    return body.xpos[:2].tolist(), simulation.physics.data.qvel[v : v + 2].tolist()


def test_it_is_where_time_says(simulate):
    """After 20 s on a circle of 80 s, a quarter of it: to a micrometre."""
    simulation = simulate(cylinders=[ROUND])
    assert place(simulation, "round")[0] == pytest.approx([1, 1])
    wait(simulation, 20.0)
    at, velocity = place(simulation, "round")
    assert at == pytest.approx([-1, 1], abs=1e-6)
    assert velocity == pytest.approx([-0.0785, -0.0785], abs=1e-4)


def test_it_pushes_the_robot_at_its_own_speed(simulate):
    """The lidar sees it come; a robot in the way is touched once, and pushed on at 0.1 m/s."""
    simulation = simulate(cylinders=[COMING])
    before = simulation.scan(0)[0]
    wait(simulation, 5.0)
    assert before - simulation.scan(0)[0] == pytest.approx(0.5, abs=1e-4)
    wait(simulation, 2.0)
    assert simulation.collisions == 0
    wait(simulation, 5.0)
    (collision,) = simulation.take_collisions()
    assert collision.obstacle == "coming"
    # 1 m, less 0.15 m of radius and 0.069 m of hull, at 0.1 m/s.
    assert collision.time_ns / 1e9 == pytest.approx(1 + 7.81, abs=0.03)
    assert simulation.velocity[0] == pytest.approx(-0.1, abs=0.01)


def test_nothing_holds_it_up(simulate, drive):
    """Whatever drives against it, it is where its motion has it."""
    simulation, free = simulate(cylinders=[COMING]), simulate(cylinders=[COMING], spawn={"y": 3})
    drive(simulation, 6.0, linear=0.2)
    free.physics.advance_to(simulation.physics.time_ns)
    assert simulation.collisions == 1
    assert place(simulation, "coming") == place(free, "coming")


def test_a_box_moves_too_and_keeps_its_direction(simulate):
    """Boxes and cylinders can be given a motion."""
    motion = {"through": [[2, 1]], "speed": 0.5}
    box = {"name": "cart", "x": 2, "y": 0, "size": [0.4, 0.2, 0.3], "yaw": 30, "motion": motion}
    simulation = simulate(boxes=[box])
    cart = simulation.physics.data.geom("obstacle/cart")
    before = cart.xmat.copy()
    wait(simulation, 1.0)
    assert cart.xpos[:2] == pytest.approx((2, 0.5))
    assert np.array_equal(cart.xmat, before)
