"""Spare bodies: what MuJoCo keeps of a shape is set as its compiler would have set it."""

import math

import mujoco
import numpy as np
import pytest

from sim.physics.names import NOWHERE
from sim.physics.physics import compile_model
from sim.physics.prop_bodies import bodies_of
from sim.physics.spawn import RobotSpawn
from sim.world.shapes import Obstacle

BOX = Obstacle.box("it", 1.0, 0.5, yaw=math.radians(30), size=(0.3, 0.1, 0.4), colour="red")
PILLAR = Obstacle.cylinder("it", 1.0, 0.5, radius=0.15, height=0.3, colour="red")


@pytest.fixture
def compiled(waffle, make_world):
    """Makes models of a world of these fields."""
    return lambda props=0, **fields: compile_model(
        make_world(**fields), [RobotSpawn(waffle)], props
    )


@pytest.mark.parametrize(
    ("obstacle", "section", "fields"),
    [
        (BOX, "boxes", {"size": [0.3, 0.1, 0.4], "yaw": 30}),
        (PILLAR, "cylinders", {"radius": 0.15, "height": 0.3}),
    ],
)
def test_a_shape_is_as_if_compiled(compiled, obstacle, section, fields):
    """Against an obstacle of a world that moves: type, size, bounds, direction and bits."""
    motion = {"around": [0, 0], "period": 60}
    fields = {"name": "it", "x": 1, "y": 0.5, "colour": "red", "motion": motion, **fields}
    built, model = compiled(**{section: [fields]}), compiled(props=2)
    names, bodies = bodies_of(model)
    bodies.show(1, obstacle)
    made, geom = built.geom("obstacle/it").id, bodies.geoms[1]
    assert names[geom] == "it"
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


def test_hidden_ones_are_nowhere(compiled):
    """In no group that is seen, with no bit to touch by, without a name; as before it was shown."""
    model = compiled(props=2)
    names, bodies = bodies_of(model)
    before = {
        field: getattr(model, field).copy()
        for field in ("geom_group", "geom_contype", "body_contype", "geom_size", "body_pos")
    }
    bodies.show(0, BOX)
    bodies.hide(0)
    for field, values in before.items():
        assert np.array_equal(getattr(model, field), values), field
    for geom in bodies.geoms:
        assert model.geom_group[geom] == NOWHERE
        assert not model.geom_contype[geom] | model.body_contype[model.geom_bodyid[geom]]
        assert not names[geom]
    assert bodies.shown == [None, None]


def test_what_the_solver_and_the_renderer_are_told_is_that_of_a_model_without(compiled):
    """Their mean inertia times the number of axes, to the last bit, and the world's extent."""
    cylinder = {"x": 1, "y": 1, "radius": 0.1, "motion": {"around": [0, 0], "period": 80}}
    without = compiled(cylinders=[cylinder])
    for props in (1, 2, 3, 5, 8, 40):
        model = compiled(props=props, cylinders=[cylinder])
        assert model.nv == without.nv + 2 * props
        assert model.stat.meaninertia * model.nv == pytest.approx(
            without.stat.meaninertia * without.nv, rel=1e-15
        )
        assert model.stat.extent == without.stat.extent
        assert np.array_equal(model.stat.center, without.stat.center)
        assert mujoco.mj_isSparse(model) == mujoco.mj_isSparse(without)
