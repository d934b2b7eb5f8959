"""Props: they appear, move and vanish; who sees and who touches them; what is refused."""

import math

import mujoco
import numpy as np
import pytest

from sim.physics.physics import compile_model
from sim.physics.prop_bodies import PropError, bodies_of
from sim.physics.prop_bodies import shape as prop_shape
from sim.physics.spawn import RobotSpawn
from sim.sensors.camera import RaycastCamera
from sim.sensors.imu import Imu
from sim.simulation import Simulation
from sim.world.loader import load_world
from tests.support.simulated import alone, two, wait
from tests.support.thorough import sample

PILLAR = {"name": "pillar", "x": 2.0, "y": 0.0, "radius": 0.15}


def readings(simulation, count=40):
    """Everything that a drive through the world shows, down to the last bit."""
    seen = []
    for index in range(count):
        simulation.command(0.25, math.sin(index / 7))
        wait(simulation, 0.1)
        odometry = simulation.read_odometry()
        seen.append(
            (simulation.pose, odometry.x, odometry.yaw, simulation.sensor(Imu).measure(index))
        )
        seen.append(simulation.scan(index).tobytes())
    return seen


@pytest.mark.parametrize("world", sample(["dqn_stage4", "empty_arena"], 3))
def test_without_one_placed_a_run_is_as_without_any(waffle, world):
    """Poses, odometry, inertial readings and scans are the same bit for bit; it hits walls, too."""
    runs = [alone(load_world(world), waffle, seed=3, props=props) for props in (0, 4, 1, 7)]
    first, *others = [readings(run, 150) for run in runs]
    assert runs[0].collisions > 0
    assert all(other == first for other in others)


def test_without_one_placed_a_fleet_runs_as_without_any(make_world, waffle):
    """Two robots that drive into each other."""
    seen = []
    for props in (0, 3):
        fleet = Simulation(make_world(), two(waffle, yaw=180), seed=1, props=props)
        for _ in range(100):
            for robot in fleet.robots:
                robot.command(0.2, 0.0)
            fleet.physics.advance_to(fleet.physics.time_ns + 50_000_000)
        assert sum(robot.collisions for robot in fleet.robots) == 2
        seen.append([(robot.pose, robot.scan(0).tobytes()) for robot in fleet.robots])
    assert seen[0] == seen[1]


def test_lidar_and_camera_see_it_at_once(simulate, waffle):
    """At 1 m, of which 0.1 m is its half, plus the 64 mm that the lidar stands back; then it goes.

    The camera's picture, drawn ray by ray, has its colour in the middle.
    """
    simulation = simulate(props=1)
    camera = RaycastCamera(simulation.physics.model, waffle.camera)
    picture = np.empty((waffle.camera.height, waffle.camera.width, 3), dtype=np.uint8)

    def look():
        camera.draw(simulation.physics.data, picture)
        return simulation.scan(0), picture.copy()

    scan_before, picture_before = look()
    box = simulation.physics.props.place("box", 1.0, 0.0, size=(0.2, 0.6, 0.6), colour="red")
    scan, seen = look()
    assert scan[0] == pytest.approx(0.9 + 0.064, abs=0.03)
    assert scan_before[0] == np.inf
    red, green, blue = seen[waffle.camera.height // 2, waffle.camera.width // 2].tolist()
    assert red > 3 * max(green, blue)
    box.remove()
    scan, seen = look()
    assert np.array_equal(scan, scan_before)
    assert np.array_equal(seen, picture_before)


SHAPES = [
    ({"size": (0.3, 0.1, 0.4), "yaw_deg": 30}, "boxes", {"size": [0.3, 0.1, 0.4], "yaw": 30}),
    ({"radius": 0.15, "height": 0.3}, "cylinders", {"radius": 0.15, "height": 0.3}),
]


@pytest.mark.parametrize(("shape", "section", "fields"), SHAPES, ids=["box", "cylinder"])
def test_it_is_like_an_obstacle_of_the_world(simulate, drive, shape, section, fields):
    """The same scan all round, and the robot runs into it at the same time as hard."""
    placed = simulate(props=1)
    placed.physics.props.place("it", 0.5, 0.1, **shape)
    built = simulate(**{section: [{"name": "it", "x": 0.5, "y": 0.1, **fields}]})
    assert np.array_equal(placed.scan(0), built.scan(0))
    for simulation in (placed, built):
        drive(simulation, 3.0, linear=0.2)
    (collision,), (other,) = placed.take_collisions(), built.take_collisions()
    assert (collision.obstacle, collision.time_ns) == ("it", other.time_ns)
    assert collision.force == pytest.approx(other.force, rel=0.05)


@pytest.mark.parametrize(("shape", "section", "fields"), SHAPES, ids=["box", "cylinder"])
def test_what_mujoco_keeps_of_its_shape_is_as_if_compiled(
    waffle, make_world, shape, section, fields
):
    """Against an obstacle of a world that moves: type, size, bounds, direction and bits."""
    motion = {"around": [0, 0], "period": 60}
    fields = {"name": "it", "x": 1, "y": 0.5, "colour": "red", "motion": motion, **fields}
    built = compile_model(make_world(**{section: [fields]}), [RobotSpawn(waffle)])
    model = compile_model(make_world(), [RobotSpawn(waffle)], 2)
    names, bodies = bodies_of(model)
    yaw, size, radius, height = map(shape.get, ("yaw_deg", "size", "radius", "height"))
    bodies.show(1, prop_shape("it", (1.0, 0.5, yaw or 0.0), size, radius, height or 0.5, "red"))
    made, geom = built.geom("obstacle/it").id, bodies.geoms[1]
    assert (names[geom], names[bodies.geoms[0]]) == ("it", "")
    for field in (
        *("geom_type", "geom_size", "geom_rbound", "geom_aabb", "geom_quat", "geom_rgba"),
        *("geom_group", "geom_contype", "geom_conaffinity", "geom_condim", "geom_friction"),
    ):
        expected, got = getattr(built, field)[made], getattr(model, field)[geom]
        assert got == pytest.approx(expected, abs=1e-7), field
    first, other = built.geom_bodyid[made], model.geom_bodyid[geom]
    for field in ("body_contype", "body_conaffinity", "body_mass", "body_inertia"):
        assert getattr(model, field)[other] == pytest.approx(getattr(built, field)[first]), field
    assert model.body_pos[other, 2] == pytest.approx(built.body_pos[first, 2])
    bounds = [m.bvh_aabb[m.body_bvhadr[body]] for m, body in ((built, first), (model, other))]
    assert bounds[1] == pytest.approx(bounds[0], abs=1e-7)


def test_what_the_solver_and_the_renderer_take_from_the_model_is_that_of_one_without(
    waffle, make_world
):
    """Their mean inertia times the number of axes, to the last bit, and the world's extent."""
    world = make_world(cylinders=[PILLAR | {"motion": {"around": [0, 0], "period": 80}}])
    without = compile_model(world, [RobotSpawn(waffle)])
    for props in (1, 2, 3, 5, 8, 40):
        model = compile_model(world, [RobotSpawn(waffle)], props)
        assert model.nv == without.nv + 2 * props
        assert model.stat.meaninertia * model.nv == pytest.approx(
            without.stat.meaninertia * without.nv, rel=1e-15
        )
        assert model.stat.extent == without.stat.extent
        assert np.array_equal(model.stat.center, without.stat.center)
        assert mujoco.mj_isSparse(model) == mujoco.mj_isSparse(without)


def test_it_goes_where_it_is_sent_and_stands(simulate):
    """2 m at 0.5 m/s take 4 s."""
    simulation = simulate(props=1)
    box = simulation.physics.props.place("box", 1.0, -1.0, radius=0.1)
    box.move_to(1.0, 1.0, speed=0.5)
    wait(simulation, 1.0)
    assert box.position == pytest.approx((1.0, -0.5))
    assert box.velocity == pytest.approx((0, 0.5))
    assert simulation.physics.data.body("prop/0").xpos[:2] == pytest.approx((1.0, -0.5), abs=1e-6)
    wait(simulation, 4.0)
    assert box.position == (1.0, 1.0)
    assert box.velocity == (0.0, 0.0)
    assert simulation.physics.data.body("prop/0").xpos[:2].tolist() == [1.0, 1.0]


def test_it_follows_points_and_can_be_sent_elsewhere_on_the_way(simulate):
    """Each way begins where it is."""
    simulation = simulate(props=1)
    box = simulation.physics.props.place("box", 0.0, 2.0, radius=0.1)
    box.follow([(1.0, 2.0), (1.0, 3.0)], speed=1.0)
    wait(simulation, 1.5)
    assert box.position == pytest.approx((1.0, 2.5))
    box.move_at(-1.0, 0.0)
    wait(simulation, 1.0)
    assert box.position == pytest.approx((0.0, 2.5))
    box.stop()
    wait(simulation, 1.0)
    assert box.position == pytest.approx((0.0, 2.5))


def test_it_pushes_a_robot_at_its_own_speed(simulate):
    """Which contacts know: it is touched once, and moves on with it at 0.1 m/s."""
    simulation = simulate(props=1)
    box = simulation.physics.props.place("box", 0.5, 0.0, size=(0.2, 0.4, 0.3))
    box.move_at(-0.1, 0.0)
    wait(simulation, 5.0)
    (collision,) = simulation.take_collisions()
    assert collision.obstacle == "box"
    # 0.4 m to its face, less 0.069 m of hull, at 0.1 m/s.
    assert collision.time_ns / 1e9 == pytest.approx(1 + 3.31, abs=0.03)
    assert simulation.velocity[0] == pytest.approx(-0.1, abs=0.01)
    assert box.position[0] == pytest.approx(0.0)


def test_one_that_stands_is_not_pushed_away(simulate, drive):
    """A robot drives against it for 5 s."""
    simulation = simulate(props=1)
    simulation.physics.props.place("box", 0.4, 0.0, size=(0.1, 0.4, 0.3))
    drive(simulation, 5.0, linear=0.2)
    assert simulation.collisions == 1
    assert simulation.pose[0] == pytest.approx(0.35 - 0.069, abs=0.002)
    assert simulation.physics.data.body("prop/0").xpos[0] == 0.4


def test_a_body_serves_again(simulate, drive):
    """A box is removed, and a cylinder with a name of its own takes its body."""
    simulation = simulate(props=1)
    simulation.physics.props.place("box", 3.0, 0.0, size=(0.1, 0.4, 0.3)).remove()
    simulation.physics.props.place("pillar", 0.4, 0.0, radius=0.1)
    drive(simulation, 2.5, linear=0.2)
    assert [collision.obstacle for collision in simulation.take_collisions()] == ["pillar"]


def test_a_reset_removes_all_and_repeats_the_start(simulate, drive):
    """Bit for bit, as without any."""
    simulation, other = simulate(props=2), simulate()
    box = simulation.physics.props.place("box", 0.4, 0.0, radius=0.1)
    drive(simulation, 2.5, linear=0.2)
    simulation.physics.reset()
    assert not simulation.physics.props
    assert not box.is_placed
    box.remove()
    assert readings(simulation, 10) == readings(other, 10)


def test_they_are_listed_and_found_by_name(simulate):
    """In the order in which they were placed; a face that lies in another's is no touch."""
    props = simulate(props=3).physics.props
    first, second = (
        props.place(name, x, 0.0, size=(0.2, 0.2, 0.2)) for name, x in (("one", 2.0), ("two", 2.2))
    )
    assert list(props) == [first, second]
    assert props["two"] is second
    assert (len(props), props.count) == (2, 3)


@pytest.mark.parametrize(
    ("props", "expected"),
    [
        (-1, "expected 0 to 64 props in a simulation, got -1"),
        (65, "expected 0 to 64 props in a simulation, got 65"),
        (0, r"no free prop for 'one': this simulation has 0; make it with props=1 or more"),
        (1, r"this simulation has 1, all in the world: one; remove one, or make it with props=2"),
    ],
)
def test_a_number_of_them_that_cannot_be_and_more_than_there_are_are_refused(
    simulate, props, expected
):
    """The error gives how many there are, which, and how to have more."""

    def fill():
        placed = simulate(props=props).physics.props
        for x, name in enumerate(("one", "two"), start=1):
            placed.place(name, x, 0, radius=0.1)

    with pytest.raises(PropError, match=expected):
        fill()


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((0.1, 0.0), r"it would be in the robot; place it elsewhere, or say even_into"),
        ((2.1, 0.1), r"it would be in 'pillar'; place it elsewhere$"),
        ((-2.1, 0.1), r"it would be in 'other'; place it elsewhere$"),
        ((11.0, 0.0), r"\(11, 0\) is not on the floor of 20 m x 20 m"),
        ((math.nan, 0.0), r"\(nan, 0\) is not on the floor"),
    ],
)
def test_where_there_is_no_room_it_is_refused(simulate, place, expected):
    """It is said what is there; nothing has changed."""
    simulation = simulate(props=2, cylinders=[PILLAR])
    simulation.physics.props.place("other", -2.0, 0.0, radius=0.1)
    before = simulation.scan(0)
    with pytest.raises(PropError, match=expected):
        simulation.physics.props.place("box", *place, size=(0.2, 0.2, 0.2))
    assert np.array_equal(simulation.scan(0), before)
    assert len(simulation.physics.props) == 1


def test_in_a_fleet_the_robot_in_the_way_is_named(make_world, waffle):
    """And any of them counts."""
    fleet = Simulation(make_world(), two(waffle), seed=1, props=1)
    with pytest.raises(PropError, match="it would be in 'two'"):
        fleet.physics.props.place("box", 1.0, 0.0, radius=0.1)
    with pytest.raises(PropError, match="the name 'one' is taken"):
        fleet.physics.props.place("one", 0.0, 0.0, radius=0.1)


def test_even_into_the_robot(simulate):
    """It is then pushed out of it, in a collision."""
    simulation = simulate(props=1)
    simulation.physics.props.place("box", 0.15, 0.0, size=(0.2, 0.4, 0.2), even_into_the_robot=True)
    wait(simulation, 2.0)
    assert [collision.obstacle for collision in simulation.take_collisions()] == ["box"]
    assert 0.05 - 0.069 - 0.05 < simulation.pose[0] < 0.05 - 0.069
    assert simulation.velocity == pytest.approx((0, 0), abs=1e-3)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ({}, "expected size=.* or radius=.*; got neither"),
        ({"size": (1, 1, 1), "radius": 1}, "got both"),
        ({"size": (1, 0, 1)}, r"expected edges from 0.001 m to 100 m, got \(1, 0, 1\)"),
        ({"size": (1, 1)}, r"expected size=\(length, width, height\), got \(1, 1\)"),
        ({"radius": math.nan}, r"expected radius and height from .*, got \(nan, 0.5\)"),
        ({"radius": 0.1, "height": -1}, r"got \(0.1, -1\)"),
        ({"radius": 0.1, "colour": "gren"}, "no such colour 'gren' .*did you mean 'green'"),
        ({"radius": 0.1, "yaw_deg": math.inf}, "expected a yaw from -360 to 360 deg, got inf"),
    ],
)
def test_a_shape_that_cannot_be_is_refused(simulate, shape, expected):
    """With what was expected and what was got."""
    simulation = simulate(props=1)
    with pytest.raises(PropError, match=f"prop 'it': .*{expected}"):
        simulation.physics.props.place("it", 1.0, 0.0, **shape)
    assert not simulation.physics.props


@pytest.mark.parametrize("name", ["", "x" * 61, "pillar", "other"])
def test_a_name_that_cannot_be_is_refused(simulate, name):
    """Too short, too long, or taken."""
    props = simulate(props=2, cylinders=[PILLAR]).physics.props
    props.place("other", -2.0, 0.0, radius=0.1)
    with pytest.raises(PropError, match="name"):
        props.place(name, 1.0, 0.0, radius=0.1)


def test_a_way_that_cannot_be_gone_is_refused(simulate):
    """Too fast, backwards in time, off the floor, or after it has gone; its way is as before."""
    simulation = simulate(props=1)
    box = simulation.physics.props.place("box", 1.0, 0.0, radius=0.1)
    for way, expected in (
        (lambda: box.move_to(2, 0, speed=2.1), "a speed above 0 m/s and up to 2 m/s, got 2.1 m/s"),
        (lambda: box.move_to(2, 0, speed=math.nan), "got nan m/s"),
        (lambda: box.move_to(2, 11, speed=1), "prop 'box': .2, 11. is not on the floor"),
        (lambda: box.move_at(2, 2), r"at most 2 m/s, got \(2, 2\) m/s"),
        (lambda: box.move_at(math.nan, 0), r"got \(nan, 0\) m/s"),
    ):
        with pytest.raises(PropError, match=expected):
            way()
    assert box.velocity == (0, 0)
    box.remove()
    with pytest.raises(PropError, match="'box' is not in the world any more; place a new one"):
        box.stop()
