"""Moving obstacles in the physics: where they are, what they do to a robot, who sees them."""

import numpy as np
import pytest

from sim.world.occupancy import FREE, rasterise

S = 1_000_000_000
COMING = {
    "name": "coming",
    "x": 1.0,
    "y": 0.0,
    "radius": 0.15,
    "motion": {"through": [[-1.0, 0.0]], "speed": 0.1},
}
ROUND = {
    "name": "round",
    "x": 1.0,
    "y": 1.0,
    "radius": 0.15,
    "motion": {"around": [0.0, 0.0], "period": 80},
}


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
    simulation.physics.advance_to(simulation.physics.time_ns + 20 * S)
    at, velocity = place(simulation, "round")
    assert at == pytest.approx([-1, 1], abs=1e-6)
    assert velocity == pytest.approx([-0.0785, -0.0785], abs=1e-4)


def test_it_pushes_the_robot_at_its_own_speed(simulate):
    """A robot that stands in the way is touched once, and pushed on at 0.1 m/s."""
    simulation = simulate(cylinders=[COMING])
    simulation.physics.advance_to(simulation.physics.time_ns + 7 * S)
    assert simulation.collisions == 0
    simulation.physics.advance_to(simulation.physics.time_ns + 5 * S)
    (collision,) = simulation.take_collisions()
    assert collision.obstacle == "coming"
    # 1 m, less 0.15 m of radius and 0.069 m of hull, at 0.1 m/s.
    assert collision.time_ns / S == pytest.approx(1 + 7.81, abs=0.03)
    assert simulation.velocity[0] == pytest.approx(-0.1, abs=0.01)


def test_nothing_holds_it_up(simulate, drive):
    """Whatever drives against it, it is where its motion has it."""
    simulation, free = simulate(cylinders=[COMING]), simulate(cylinders=[COMING], spawn={"y": 3})
    drive(simulation, 6.0, linear=0.2)
    free.physics.advance_to(simulation.physics.time_ns)
    assert simulation.collisions == 1
    assert place(simulation, "coming") == place(free, "coming")


def test_the_lidar_sees_it_move(simulate):
    """0.5 m nearer after 5 s."""
    simulation = simulate(cylinders=[COMING])
    before = simulation.scan(0)[0]
    simulation.physics.advance_to(simulation.physics.time_ns + 5 * S)
    assert before - simulation.scan(0)[0] == pytest.approx(0.5, abs=1e-4)


def test_it_is_not_on_the_map(make_world):
    """The map is of what stands still."""
    assert (rasterise(make_world(cylinders=[COMING, ROUND])).cells == FREE).all()


def test_a_box_moves_too_and_keeps_its_direction(simulate):
    """Boxes and cylinders can be given a motion."""
    box = {
        "name": "cart",
        "x": 2,
        "y": 0,
        "size": [0.4, 0.2, 0.3],
        "yaw": 30,
        "motion": {"through": [[2, 1]], "speed": 0.5},
    }
    simulation = simulate(boxes=[box])
    before = simulation.physics.data.geom("obstacle/cart").xmat.copy()
    simulation.physics.advance_to(simulation.physics.time_ns + 1 * S)
    assert simulation.physics.data.geom("obstacle/cart").xpos[:2] == pytest.approx((2, 0.5))
    assert np.array_equal(simulation.physics.data.geom("obstacle/cart").xmat, before)


def test_two_runs_are_alike(simulate, drive):
    """Bit for bit, collisions with the moving obstacle among them."""
    runs = [simulate(cylinders=[COMING, ROUND]) for _ in range(2)]
    for run in runs:
        drive(run, 6.0, 0.2, 0.1)
    assert runs[0].pose == runs[1].pose
    assert runs[0].take_collisions() == runs[1].take_collisions()
