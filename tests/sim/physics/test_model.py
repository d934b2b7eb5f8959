"""The compiled model: masses, names, and who touches whom."""

import mujoco
import numpy as np
import pytest

from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.model import load_robot
from sim.physics import physics
from sim.physics.names import (
    BASE,
    FLOOR,
    FLOOR_CONTACTS,
    MARKS,
    OBSTACLE_PREFIX,
    ROBOT,
    SOLID,
    WHEELS,
)
from sim.physics.physics import compile_model
from sim.physics.spawn import RobotSpawn
from sim.world.world import Spawn
from tests.support.simulated import two

FIELDS = ("body_mass", "body_pos", "geom_size", "geom_friction", "qpos0", "actuator_gainprm")


@pytest.mark.parametrize("name", ["waffle", "burger"])
def test_masses_are_those_of_the_robot(make_world, name):
    """Body and two wheels, balanced on their axle; nothing from the looks."""
    robot = load_robot(name)
    assert isinstance(robot.drive, DifferentialDrive)
    model = compile_model(make_world(), [RobotSpawn(robot)])
    assert model.body_subtreemass[model.body(BASE).id] == (
        pytest.approx(robot.base_mass + 2 * robot.drive.wheel_mass)
    )
    for wheel in WHEELS:
        assert model.body(wheel).ipos == pytest.approx((0, 0, 0))
        assert model.body(wheel).inertia == pytest.approx(robot.drive.wheel_inertia)


def test_it_stands_on_four_points(make_world, waffle):
    """Two wheels and two casters carry it, and nothing else touches."""
    model = compile_model(make_world(), [RobotSpawn(waffle)])
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=100)
    touching = sorted(model.geom(geom).name for pair in data.contact.geom for geom in pair)
    assert touching == ["caster 0", "caster 1", *["floor"] * 4, "wheel_left", "wheel_right"]
    assert data.xquat[model.body(BASE).id] == pytest.approx((1, 0, 0, 0), abs=1e-4)


def test_what_touches_and_is_not_on_the_floor_is_a_robot(make_world, waffle):
    """So a sensor that counts the floor's contacts tells when there are others."""
    moving = {"through": [[1.0, 0.0]], "speed": 0.1}
    world = make_world(
        walls=[{"name": "w", "from": [-1, 0.3], "to": [1, 0.3], "thickness": 0.1}],
        cylinders=[{"name": "c", "x": 0.4, "y": 0, "radius": 0.1}],
        boxes=[{"name": "b", "x": 0, "y": 0, "size": [0.2, 0.2, 0.2], "motion": moving}],
    )
    model = compile_model(world, two(waffle), 2)
    data, floor = mujoco.MjData(model), model.geom(FLOOR).id
    sensor = int(model.sensor(FLOOR_CONTACTS).adr[0])
    robots = [model.body(f"{name}/{BASE}").id for name in ("one", "two")]
    is_robot = np.isin(model.body_rootid[model.geom_bodyid], robots)
    random, on_floor, others = np.random.default_rng(1), 0, 0
    for _ in range(300):
        for name in ("one", "two"):
            place = model.joint(f"{name}/{BASE}").qposadr[0]
            data.qpos[place : place + 2] = random.uniform(-0.4, 0.4, 2)
            data.qpos[place + 2] = random.uniform(-0.01, 0.04)
        mujoco.mj_forward(model, data)
        touching = data.contact.geom
        of_floor = (touching == floor).any(axis=1)
        assert data.sensordata[sensor] == of_floor.sum()
        assert is_robot[touching[~of_floor]].any(axis=1).all()
        on_floor, others = on_floor + of_floor.sum(), others + (~of_floor).sum()
    assert min(on_floor, others) > 500


def test_every_obstacle_is_a_geom_of_its_name_and_a_zone_is_a_mark(make_world, waffle):
    """Half sizes, standing on the floor; nothing touches a zone."""
    world = make_world(
        walls=[{"name": "w", "from": [1, 2], "to": [3, 2], "thickness": 0.2, "height": 0.4}],
        cylinders=[{"name": "c", "x": -1, "y": 0, "radius": 0.3, "height": 0.6}],
        zones=[{"name": "A", "x": 0, "y": 0, "radius": 0.4}],
    )
    model = compile_model(world, [RobotSpawn(waffle)])
    wall, pillar = (model.geom(OBSTACLE_PREFIX + name) for name in ("w", "c"))
    assert wall.size == pytest.approx((1, 0.1, 0.2))
    assert wall.pos == pytest.approx((2, 2, 0.2))
    assert pillar.size[:2] == pytest.approx((0.3, 0.3))
    assert pillar.pos == pytest.approx((-1, 0, 0.3))
    (mark,) = [geom for geom in range(model.ngeom) if model.geom_group[geom] == MARKS]
    assert model.geom_contype[mark] == model.geom_conaffinity[mark] == 0
    assert model.geom_size[mark][0] == 0.4


def test_only_the_robots_own_geoms_are_hidden_from_its_lidar(make_world, waffle):
    """Groups tell them apart."""
    model = compile_model(make_world(walls=[{"from": [1, 1], "to": [2, 1]}]), [RobotSpawn(waffle)])
    for geom in range(model.ngeom):
        own = model.body_rootid[model.geom_bodyid[geom]] == model.body(BASE).id
        assert (model.geom_group[geom] == SOLID) != own
        if model.geom_contype[geom] or model.geom_conaffinity[geom]:
            assert (model.geom_group[geom] == ROBOT) == own


def test_what_was_compiled_before_is_a_model_of_its_own(make_world, waffle):
    """The same to the bit; what is changed in one does not show in another."""
    first, again = (compile_model(make_world(), [RobotSpawn(waffle)]) for _ in range(2))
    assert first is not again
    for name in FIELDS:
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()
    first.geom_friction[:] = 9.0
    third = compile_model(make_world(), [RobotSpawn(waffle)])
    assert third.geom_friction.tobytes() == again.geom_friction.tobytes()


def test_worlds_that_differ_are_compiled_alone_and_only_so_many_are_kept(make_world, waffle):
    """However little: -0.0 is elsewhere than 0.0, to the bit. A search goes through thousands."""
    places = [0.0, -0.0, 0.25, *(0.01 * number for number in range(1, 12))]
    robots = [RobotSpawn(waffle, spawn=Spawn(x=x)) for x in places]
    models = [compile_model(make_world(), [robot]) for robot in robots]
    assert [str(float(model.body(BASE).pos[0])) for model in models] == [str(x) for x in places]
    assert len(physics._compiled) <= physics._MOST_KEPT
