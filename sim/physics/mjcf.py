"""A robot's own MuJoCo model: read, checked, and attached to the world.

Its text is looked through first (`sim.physics.mjcf_text`). The names of the robot's file are
compared with the compiled model. The wheels of a differential base roll; those of the other bases
stand still and touch nothing, and the base moves as `sim.physics.planar` says.

The extent of single geoms of a compiled MuJoCo model.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.robots.drives import DifferentialDrive
from bt_mission.robots.joints import JointLimits, ModelFile
from bt_mission.robots.model import RobotModel
from bt_mission.robots.parts import Point3
from sim.physics.mjcf_text import MjcfError, Path_, fail, look_through
from sim.physics.names import (
    BASE,
    FLOOR_BIT,
    GRIP,
    JOINT_GROUP,
    LOOKS,
    LOOSE_BIT,
    MODEL_PREFIX,
    OBSTACLE_BIT,
    ROBOT,
    SOLIMP,
    SOLREF,
    WHEELS,
)
from sim.physics.planar import MassFigures, add_planar_drive

Floats = npt.NDArray[np.float64]

_DIRECTIONS = 64


def radius_of(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, centre: Floats, axis: Floats
) -> float:
    """Return how far a geom reaches from an axis through `centre`, m: the radius of a wheel."""
    aside = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside)
    upwards = np.cross(axis, aside)
    at = data.geom_xpos[geom] - centre
    angles = np.arange(_DIRECTIONS) * math.tau / _DIRECTIONS
    return max(
        float(way @ at) + reach(model, data, geom, way)
        for way in np.outer(np.cos(angles), aside) + np.outer(np.sin(angles), upwards)
    )


def reach(model: mujoco.MjModel, data: mujoco.MjData, geom: int, direction: Floats) -> float:
    """Return how far a geom reaches from its middle in a direction of the world, m."""
    x, y, z = way = data.geom_xmat[geom].reshape(3, 3).T @ direction
    size = model.geom_size[geom]
    kind, kinds = int(model.geom_type[geom]), mujoco.mjtGeom
    if kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        return float((vertices @ way).max())
    if kind == kinds.mjGEOM_BOX:
        return float(size @ np.abs(way))
    if kind == kinds.mjGEOM_ELLIPSOID:
        return float(np.linalg.norm(size * way))
    if kind == kinds.mjGEOM_CYLINDER:
        return float(size[0] * math.hypot(x, y) + size[1] * abs(z))
    return float(size[0] + (size[1] * abs(z) if kind == kinds.mjGEOM_CAPSULE else 0.0))


_PLACE_M = 1e-3
"""How far the place of a sensor, a caster or a rolling wheel in both files may differ."""
_WHEEL_PLACE_M = 5e-3
"""How far the place of a wheel that does not roll may differ."""
_RADIUS_SHARE = 0.01
"""How far the radius of a rolling wheel may differ; odometry is wrong by this share."""
_STRAIGHT = 0.999
"""The cosine of the angle up to which the axis of a rolling wheel may differ."""
_MASS_SHARE = 0.01


def problems(robot: RobotModel) -> list[tuple[Path_, str]]:
    """Return all problems of the model of a robot, each with its key."""
    try:
        _read(robot)
    except MjcfError as error:
        return list(error.problems)
    return []


def add_model(
    spec: mujoco.MjSpec, robot: RobotModel, prefix: str, *, group: int, contype: int
) -> mujoco.MjsBody:
    """Attach the model of a robot to the world; return its base, which has the usual names.

    Raises:
        MjcfError: With all problems.
    """
    own, (child, mass, casters) = _of(robot), _read(robot)
    rolling = _rolling(robot)
    _take_settings(child, spec)
    at_first = set(spec.actuators)
    body = spec.worldbody.add_frame().attach_body(child.body(own.base), prefix + MODEL_PREFIX, "")
    mine = prefix + MODEL_PREFIX
    body.name = prefix + BASE
    for joint in body.joints:
        joint.name = prefix + BASE
    actuators = [actuator for actuator in spec.actuators if actuator not in at_first]
    renamed = {mine + own.base: prefix + BASE}
    renamed |= {mine + joint_name: prefix + name for name, joint_name in rolling}
    for equality in spec.equalities:
        equality.name1 = renamed.get(equality.name1, equality.name1)
        equality.name2 = renamed.get(equality.name2, equality.name2)
    _set_contacts(body, {mine + name for name in casters}, contype)
    for actuator in actuators:
        actuator.group = JOINT_GROUP
    for name, joint_name in rolling:
        joint = spec.joint(mine + joint_name)
        joint.name = prefix + name
        _set_wheel(joint.parent, prefix + name)
        motor = next((each for each in actuators if each.target == mine + joint_name), None)
        if motor is None:
            motor = _add_motor(spec, robot)
        motor.name = motor.target = prefix + name
        motor.group = group
    if not rolling:
        add_planar_drive(spec, body, robot, prefix, group, mass)
    if contype:
        _exclude_each_other(spec, body, prefix)
    return body


def _rolling(robot: RobotModel) -> list[tuple[str, str]]:
    """Return the wheels on which a differential base rolls: our names, and those of the joints."""
    is_rolling = isinstance(robot.drive, DifferentialDrive)
    return list(zip(WHEELS, _of(robot).wheels, strict=True)) if is_rolling else []


_SETTINGS = ("option", *(f"visual.{part}" for part in ("headlight", "map", "quality", "rgba")))
_SETTINGS += ("visual.global_", "visual.scale", "stat")


def _take_settings(child: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    """Give a model the physics and the looks of the world; MuJoCo warns where they differ."""
    for path in _SETTINGS:
        mine, others = attrgetter(path)(child), attrgetter(path)(spec)
        for name in dir(others):
            if not name.startswith("_"):
                setattr(mine, name, getattr(others, name))


def _add_motor(spec: mujoco.MjSpec, robot: RobotModel) -> mujoco.MjsActuator:
    """Add the motor of a wheel: a velocity servo that the grip of the wheel limits."""
    radius: float = robot.drive.wheel_radius
    motor = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_velocity(kv=(robot.base_mass / 2 * radius**2 + 1e-3) / _FOLLOWING_S)
    most = GRIP[0] * 9.81 * robot.base_mass / 2 * radius
    motor.forcelimited, motor.forcerange = True, [-most, most]
    return motor


_FOLLOWING_S = 0.015
"""The time in which a wheel follows its command."""


def _set_contacts(body: mujoco.MjsBody, casters: set[str], contype: int) -> None:
    for each in (body, *body.find_all(mujoco.mjtObj.mjOBJ_BODY)):
        for geom in each.geoms:
            touches = geom.contype or geom.conaffinity
            geom.group = ROBOT if touches else LOOKS
            if geom.name in casters:
                geom.contype, geom.conaffinity = 0, FLOOR_BIT
                geom.condim, geom.priority = 1, 1
                geom.solref, geom.solimp = SOLREF, [*SOLIMP]
            elif touches:
                geom.contype = contype
                geom.conaffinity = FLOOR_BIT | OBSTACLE_BIT | LOOSE_BIT | contype
        if all(geom.group == ROBOT for geom in each.geoms):
            for geom in list(each.geoms):
                _add_look(each, geom)


_SHAPE = ("type", "size", "pos", "quat", "alt", "fromto", "meshname", "rgba", "material")


def _add_look(body: mujoco.MjsBody, geom: mujoco.MjsGeom) -> None:
    """Add what people see of a geom that touches: views do not show these."""
    look = body.add_geom(contype=0, conaffinity=0, group=LOOKS, mass=0.0)
    for name in _SHAPE:
        setattr(look, name, getattr(geom, name))


def _set_wheel(wheel: mujoco.MjsBody, name: str) -> None:
    for geom in wheel.geoms:
        if geom.group == ROBOT:
            geom.name, geom.friction = name, GRIP
            geom.solref, geom.solimp = SOLREF, [*SOLIMP]


def _exclude_each_other(spec: mujoco.MjSpec, base: mujoco.MjsBody, prefix: str) -> None:
    """Let the parts of a robot not touch each other; those of different robots do."""
    bodies = [base, *base.find_all(mujoco.mjtObj.mjOBJ_BODY)]
    for index, body in enumerate(bodies):
        body.name = body.name or f"{prefix}{MODEL_PREFIX}body {index}"
    for index, body in enumerate(bodies):
        for other in bodies[:index]:
            spec.add_exclude(bodyname1=body.name, bodyname2=other.name)


# ---- reading -------------------------------------------------------------------------------------


def _of(robot: RobotModel) -> ModelFile:
    assert robot.model is not None
    return robot.model


def _read(robot: RobotModel) -> tuple[mujoco.MjSpec, MassFigures, list[str]]:
    """Read and check a model; return what is attached, its mass, and the names of its casters."""
    own = _of(robot)
    path = Path(own.file)
    look_through(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a model that MuJoCo warns of does not move as written
            child = mujoco.MjSpec.from_file(str(path))
            model, data, casters = _prepared(child, robot)
    except (
        *(ValueError, TypeError, UserWarning),
        *(mujoco.FatalError, mujoco.UnexpectedError),
    ) as error:
        raise fail(f"MuJoCo: {_in_a_line(str(error), path)}", "file") from error
    return child, _mass_of(model, data, own.base), casters


_USER = ("body", "jnt", "geom", "site", "cam", "tendon", "actuator", "sensor")
_SIZES = ("memory", "njmax", "nconmax", "nstack", *(f"nuser_{name}" for name in _USER))
"""Sizes of memory, which MuJoCo chooses."""


def _prepared(
    child: mujoco.MjSpec, robot: RobotModel
) -> tuple[mujoco.MjModel, mujoco.MjData, list[str]]:
    """Check a model and make it ready to be attached; return it alone, and its casters.

    Raises:
        MjcfError: With all problems.
    """
    own, rolling = _of(robot), _rolling(robot)
    for part in (*child.lights, *child.sensors, *child.keys, *child.excludes, *child.pairs):
        child.delete(part)
    for name in _SIZES:
        setattr(child, name, -1)
    model, data = _compiled(child)
    wrong = list(_misfits(robot, own, model, data))
    if wrong:
        raise MjcfError(wrong)
    casters = _named_casters(child, own, model, data)
    for part in (*child.cameras, *_foreign_motors(child, robot)):
        child.delete(part)
    turn = data.xmat[model.body(own.base).id].reshape(3, 3)
    for _, name in rolling:
        if turn[:, 1] @ data.xaxis[model.joint(name).id] < 0:
            child.joint(name).axis = -child.joint(name).axis  # it turns forward from now on
    if not rolling:
        _fix_wheels(child, own)
        model, data = _compiled(child)
    return model, data, casters


def _named_casters(
    child: mujoco.MjSpec, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData
) -> list[str]:
    """Return the names of the casters; one that is given by its place gets a name."""
    casters = []
    for index, caster in enumerate(own.casters):
        if isinstance(caster, str):
            casters.append(caster)
            continue
        for geom in _geoms_at(caster, own, model, data):
            child.geoms[geom].name = child.geoms[geom].name or f"caster {index} of geom {geom}"
            casters.append(child.geoms[geom].name)
    return casters


def _geoms_at(
    place: Point3, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData
) -> list[int]:
    """Return the geoms that touch anything and have their middle at a place of the base."""
    places = _in_base(model, data, own, data.geom_xpos)
    near = np.linalg.norm(places - np.array(place), axis=1) <= _PLACE_M
    return np.flatnonzero(near & _colliding(model)).tolist()


def _in_base(model: mujoco.MjModel, data: mujoco.MjData, own: ModelFile, places: Any) -> Any:
    """Return places of the world, one a row, in the frame of the base, m."""
    base = model.body(own.base).id
    return (places - data.xpos[base]) @ data.xmat[base].reshape(3, 3)


def _compiled(child: mujoco.MjSpec) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a model alone, and the places of its parts at its start."""
    model = child.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    return model, data


def _foreign_motors(child: mujoco.MjSpec, robot: RobotModel) -> list[mujoco.MjsActuator]:
    """Return the actuators of rolling wheels that are no velocity servos: ours replace them."""
    wheels = [joint for _, joint in _rolling(robot)]
    return [
        each for each in child.actuators if each.target in wheels and not _is_velocity_servo(each)
    ]


def _fix_wheels(child: mujoco.MjSpec, own: ModelFile) -> None:
    """Take the joints of wheels, of their rollers and of the steering out; nothing touches them."""
    joints = [child.joint(name) for name in own.steering or ()]
    for name in own.wheels:
        wheel = child.joint(name).parent
        for body in (wheel, *wheel.find_all(mujoco.mjtObj.mjOBJ_BODY)):
            joints += body.joints
            for geom in body.geoms:
                geom.contype = geom.conaffinity = 0
    names = {joint.name for joint in joints} - {""}
    for actuator in [each for each in child.actuators if each.target in names]:
        child.delete(actuator)
    for equality in [each for each in child.equalities if {each.name1, each.name2} & names]:
        child.delete(equality)
    for joint in joints:
        child.delete(joint)


def _mass_of(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> MassFigures:
    """Return the height of the centre of mass and the inertia about z, in the frame of the base."""
    base = model.body(name).id
    turn, origin = data.xmat[base].reshape(3, 3), data.xpos[base]
    own = [body for body in range(model.nbody) if model.body_rootid[body] == base]
    inertia = 0.0
    for body in own:
        x, y, _ = turn.T @ (data.xipos[body] - origin)
        axes = turn[:, 2] @ data.ximat[body].reshape(3, 3)
        inertia += float(
            axes**2 @ model.body_inertia[body] + model.body_mass[body] * (x * x + y * y)
        )
    return MassFigures(float((turn.T @ (data.subtree_com[base] - origin))[2]), inertia)


def _in_a_line(text: str, path: Path) -> str:
    """Return an error of MuJoCo on one line, with short names of files."""
    text = text.replace(f"{path.parent}/", "").strip()
    return " ".join(text.split())[:400] or "the model is not valid"


# ---- comparing the robot's file with the model -------------------------------------------------


def _misfits(
    robot: RobotModel, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData
) -> Iterator[tuple[Path_, str]]:
    base = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, own.base)
    unusable = _base_misfit(own, model, base)
    if unusable is not None:
        yield ("model", "base"), unusable
        return
    yield from _mass_misfit(robot, model, base)
    if model.nbody > MOST_BODIES:
        yield ("model", "file"), f"it has {model.nbody} bodies, the limit is {MOST_BODIES}"
    for joint in range(model.njnt):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL:
            name = model.joint(joint).name or "(no name)"
            yield ("model", "file"), f"the joint '{name}' is a ball joint, which is not supported"
    yield from _rolling_misfits(robot, own, model, data, base)
    yield from _place_misfits(robot, own, model, data, base)
    for path, name, limits in _moved(robot):
        for text in _joint_misfits(model, name, limits, base, own):
            yield path, text


def _rolling_misfits(
    robot: RobotModel, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData, base: int
) -> Iterator[tuple[Path_, str]]:
    """Yield what is wrong with wheels, steering and casters."""
    for name in own.steering or ():
        for text in _hinge_misfits(model, base, name):
            yield ("model", "steering"), text
    rolls = bool(_rolling(robot))
    for name, (x, y) in zip(own.wheels, robot.drive.places, strict=True):
        for text in _hinge_misfits(model, base, name):
            yield ("model", "wheels"), text
            break
        else:
            at = (x, y, robot.drive.wheel_radius - robot.base_height)
            if rolls:
                for text in _wheel_misfits(model, data, base, name):
                    yield ("model", "wheels"), text
                yield from _radius_misfit(robot, model, data, name)
            for text in _wheel_place(data, base, name, at, _PLACE_M if rolls else _WHEEL_PLACE_M):
                yield ("model", "wheels"), text
    joints = (*own.wheels, *(own.steering or ()))
    for name in dict.fromkeys(name for name in joints if joints.count(name) > 1):
        yield ("model", "wheels"), f"the joint '{name}' is named twice"
    yield from _caster_misfits(own, model, data)


def _caster_misfits(
    own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData
) -> Iterator[tuple[Path_, str]]:
    """Yield which casters are not there."""
    geoms = _names(model, "geom")
    for caster in own.casters:
        if isinstance(caster, str):
            if caster not in geoms:
                yield ("model", "casters"), _no_such("geom", caster, geoms)
        elif not _geoms_at(caster, own, model, data):
            yield ("model", "casters"), _nothing_at(caster, own, model, data)


def _moved(robot: RobotModel) -> Iterator[tuple[Path_, str, JointLimits]]:
    """Yield the joints of arm and gripper with their keys."""
    for name, limits in ({} if robot.arm is None else robot.arm.joints).items():
        yield ("arm", "joints", name), name, limits
    if robot.gripper is not None:
        for name in robot.gripper.joints:
            yield ("gripper", "joints"), name, robot.gripper


def _base_misfit(own: ModelFile, model: mujoco.MjModel, base: int) -> str | None:
    """Return why a body is not a base: one with the only free joint, and a geom; or None."""
    if base < 0:
        return _no_such("body", own.base, _names(model, "body"))
    free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != 1 or model.jnt_bodyid[free[0]] != base or model.body_jntnum[base] != 1:
        where = listed([model.body(int(model.jnt_bodyid[j])).name or "(no name)" for j in free])
        got = f"free joints of: {where}" if free else "no free joint"
        return f"expected one free joint, alone in the body '{own.base}', got {got}"
    if not (_colliding(model) & (model.body_weldid[model.geom_bodyid] == base)).any():
        return f"the body '{own.base}' has no geom that touches obstacles"
    return None


def _colliding(model: mujoco.MjModel) -> Any:
    """Return for each geom whether it touches anything."""
    return model.geom_contype.astype(bool) | model.geom_conaffinity.astype(bool)


MOST_BODIES = 100


def _mass_misfit(
    robot: RobotModel, model: mujoco.MjModel, base: int
) -> Iterator[tuple[Path_, str]]:
    mass = float(model.body_subtreemass[base])
    if abs(mass - robot.base_mass) > _MASS_SHARE * mass:
        yield (
            ("base_mass",),
            f"expected the mass of the whole model, {mass:.4g} kg, got {robot.base_mass:g}",
        )


def _is_velocity_servo(motor: mujoco.MjsActuator) -> bool:
    gain, bias = motor.gainprm, motor.biasprm
    return bool(gain[0] > 0 and bias[1] == 0 and bias[2] == -gain[0] and motor.gear[0] == 1)


def _hinge_misfits(model: mujoco.MjModel, base: int, name: str) -> Iterator[str]:
    """Yield why a joint is no hinge of the robot."""
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if joint < 0:
        yield _no_such("joint", name, _names(model, "joint"))
    elif model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
        yield f"expected a hinge, but the joint '{name}' is a {_kind(model, joint)} joint"
    elif model.body_rootid[model.jnt_bodyid[joint]] != base:
        yield f"the joint '{name}' is not below the body of the base"


def _wheel_place(
    data: mujoco.MjData, base: int, name: str, expected: Point3, most: float
) -> Iterator[str]:
    """Yield that a wheel is at another place than the robot's file says."""
    turn = data.xmat[base].reshape(3, 3)
    x, y, z = (turn.T @ (data.joint(name).xanchor - data.xpos[base])).tolist()
    if math.dist((x, y, z), expected) > most:
        a, b, c = expected
        yield (
            f"expected the wheel '{name}' at ({a:.4g}, {b:.4g}, {c:.4g}) m, by"
            f" `drive` and `base_height`, but in the model it is at ({x:.4g}, {y:.4g}, {z:.4g})"
        )


def _wheel_misfits(
    model: mujoco.MjModel, data: mujoco.MjData, base: int, name: str
) -> Iterator[str]:
    joint = model.joint(name).id
    body = int(model.jnt_bodyid[joint])
    if model.jnt_limited[joint]:
        yield f"the joint '{name}' of a wheel has a range; a wheel turns without end"
    if model.body_parentid[body] != base or model.body_jntnum[body] != 1:
        yield f"expected a body directly below the base, with the joint '{name}' alone"
    axis = data.xmat[base].reshape(3, 3).T @ data.xaxis[joint]
    if abs(axis[1]) < _STRAIGHT:
        got = ", ".join(f"{each:.3g}" for each in axis.tolist())
        yield f"expected the axis of the wheel '{name}' along y of the base, got ({got})"
    count = int((_colliding(model) & (model.geom_bodyid == body)).sum())
    if count != 1:
        yield f"expected one geom that touches the floor at the wheel '{name}', got {count}"
    driven = _actuators(model, joint)
    if len(driven) > 1:
        yield f"{len(driven)} actuators drive the wheel '{name}'; expected one, or none"


def _radius_misfit(
    robot: RobotModel, model: mujoco.MjModel, data: mujoco.MjData, name: str
) -> Iterator[tuple[Path_, str]]:
    """Yield that the geom of a rolling wheel has another radius than the robot's file says."""
    joint = model.joint(name)
    geoms = np.flatnonzero(_colliding(model) & (model.geom_bodyid == joint.bodyid))
    expected = robot.drive.wheel_radius
    for geom in geoms[:1].tolist():
        radius = radius_of(model, data, geom, data.xanchor[joint.id], data.xaxis[joint.id])
        if abs(radius - expected) > _RADIUS_SHARE * radius:
            text = f"expected the radius of the wheel '{name}' in the model, {radius:.4g} m"
            yield ("drive", "wheel_radius"), f"{text}, got {expected:g}"


def _nothing_at(place: Point3, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData) -> str:
    """Return that no geom is at the place of a caster, and where the nearest one is."""
    touching = np.flatnonzero(_colliding(model))
    places = _in_base(model, data, own, data.geom_xpos[touching])
    x, y, z = places[np.linalg.norm(places - np.array(place), axis=1).argmin()].tolist()
    wanted = ", ".join(f"{each:g}" for each in place)
    return (
        f"the model has no geom that touches anything at ({wanted}) m of the base; the nearest is"
        f" at ({x:.4g}, {y:.4g}, {z:.4g})"
    )


def _joint_misfits(
    model: mujoco.MjModel, name: str, limits: JointLimits, base: int, own: ModelFile
) -> Iterator[str]:
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if joint < 0:
        yield _no_such("joint", name, _names(model, "joint"))
        return
    if name in (*own.wheels, *(own.steering or ())):
        yield f"the joint '{name}' also is a wheel"
    is_inside = model.body_rootid[model.jnt_bodyid[joint]] == base
    kinds = (mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value)
    if int(model.jnt_type[joint]) not in kinds or not is_inside:
        yield f"expected a hinge or a slide of the robot, but '{name}' is a {_kind(model, joint)}"
        return
    low, high = model.jnt_range[joint].tolist()
    if model.jnt_limited[joint] and not (low - 1e-3 <= limits.min and limits.max <= high + 1e-3):
        yield (
            f"expected min and max of '{name}' within the range of the model, {low:.4g} to"
            f" {high:.4g}, got {limits.min:g} to {limits.max:g}"
        )
    driven = _actuators(model, joint)
    if len(driven) != 1:
        yield f"expected one <position> actuator at the joint '{name}', got {len(driven)} actuators"
        return
    gain, bias = model.actuator_gainprm[driven[0]], model.actuator_biasprm[driven[0]]
    if not (gain[0] > 0 and bias[1] == -gain[0]):
        yield f"expected a <position> actuator at the joint '{name}', got one of another kind"
    low, high = model.actuator_ctrlrange[driven[0]].tolist()
    if model.actuator_ctrllimited[driven[0]] and not (low <= limits.min and limits.max <= high):
        yield f"the actuator of '{name}' takes only {low:.4g} to {high:.4g} (ctrlrange)"


def _place_misfits(
    robot: RobotModel, own: ModelFile, model: mujoco.MjModel, data: mujoco.MjData, base: int
) -> Iterator[tuple[Path_, str]]:
    """Compare the places of sensors in both files."""
    turn, origin = data.xmat[base].reshape(3, 3), data.xpos[base]
    for name, kind, places in (
        ("lidar", "site", data.site_xpos),
        ("imu", "site", data.site_xpos),
        ("camera", "camera", data.cam_xpos),
    ):
        wanted, part = getattr(own, name), getattr(robot, name)
        if wanted is None:
            continue
        known = _names(model, kind)
        if wanted not in known:
            yield ("model", name), _no_such(kind, wanted, known)
            continue
        if part is None:
            yield ("model", name), f"the robot's file has no {name}"
            continue
        x, y, z = (turn.T @ (places[known.index(wanted)] - origin)).tolist()
        if math.dist((x, y, z), (part.x, part.y, part.z)) > _PLACE_M:
            text = (
                f"expected the place of '{wanted}' in the model, ({x:.4g}, {y:.4g}, {z:.4g}) m,"
                f" got ({part.x:g}, {part.y:g}, {part.z:g})"
            )
            yield (name,), text


def _actuators(model: mujoco.MjModel, joint: int) -> list[int]:
    """Return the actuators that drive a joint directly."""
    return [
        int(actuator)
        for actuator in np.flatnonzero(model.actuator_trnid[:, 0] == joint)
        if int(model.actuator_trntype[actuator])
        in (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
    ]


def _kind(model: mujoco.MjModel, joint: int) -> str:
    return str(mujoco.mjtJoint(int(model.jnt_type[joint])).name).removeprefix("mjJNT_").lower()


_COUNTS = {"body": "nbody", "joint": "njnt", "geom": "ngeom", "site": "nsite", "camera": "ncam"}


def _names(model: mujoco.MjModel, kind: str) -> list[str]:
    """Return the names of all elements of a kind, in their order."""
    return [str(getattr(model, kind)(i).name) for i in range(getattr(model, _COUNTS[kind]))]


def _no_such(kind: str, name: str, known: Sequence[str]) -> str:
    names = sorted(filter(None, known))
    near = did_you_mean(name, names)
    text = f"the model has no {kind} '{name}' (it has: {listed(names)})"
    return f"{text}; {near}" if near else text
