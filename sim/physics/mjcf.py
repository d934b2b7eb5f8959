"""A robot's own MuJoCo model: read, checked, and attached to the world.

Two things guard MuJoCo's parser and compiler, which end the process for some files. The XML is read
by SAX first, without entities, within limits of size, depth and numbers, and all files that it
names lie in its folder. The names of the robot's file are compared with the compiled model.
"""

from __future__ import annotations

import math
import re
import xml.sax
import xml.sax.handler
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from operator import attrgetter
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from bt_mission.core.diagnostics import did_you_mean, listed
from bt_mission.core.errors import BtMissionError
from bt_mission.core.robot.joints import JointLimits, ModelFile
from bt_mission.core.robot.model import RobotModel
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

Path_ = tuple[str, ...]

MOST_XML_BYTES = 2_000_000
MOST_ASSET_BYTES = 50_000_000
MOST_ELEMENTS = 5_000
MOST_DEPTH = 60
MOST_FILES = 200
LARGEST_NUMBER = 1e10
_PLACE_M = 1e-3
"""How far the place of a sensor in both files may differ."""
_MASS_SHARE = 0.01

_REFUSED = {
    **dict.fromkeys(("plugin", "extension"), "plugins are programs, which are not loaded"),
    **dict.fromkeys(
        ("composite", "flexcomp", "flex", "skin", "replicate", "attach", "model", "hfield"),
        "this element is not supported in a robot's model",
    ),
    "size": "sizes of memory are chosen by MuJoCo",
}
_FOLDERS = {"mesh": "meshdir", "texture": "texturedir"}
_FILE_ATTRIBUTE = re.compile(r"^file(up|down|left|right|front|back)?$")
_NUMBERS = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$")


class MjcfError(BtMissionError):
    """A robot's MuJoCo model cannot be used.

    Args:
        problems: Each with its key in the robot's file.
    """

    code = "BT-813"

    def __init__(self, problems: Sequence[tuple[Path_, str]]) -> None:
        super().__init__("; ".join(text for _, text in problems))
        self.problems = tuple(problems)


@dataclass
class _Written:
    """What the XML of a model holds, with its includes."""

    folder: Path
    elements: int = 0
    depth: int = 0
    files: list[Path] = field(default_factory=list)
    assets: list[tuple[str, str]] = field(default_factory=list)
    """The kind and the name of each file of an asset."""
    folders: dict[str, str] = field(default_factory=dict)

    def begin(self, tag: str) -> str | None:
        """Count an element that begins; return why it is refused, or None."""
        self.elements += 1
        self.depth += 1
        if self.elements > MOST_ELEMENTS:
            return f"more than {MOST_ELEMENTS:,} elements"
        if self.depth > MOST_DEPTH:
            return f"elements are nested more than {MOST_DEPTH} deep"
        return f"<{tag}>: {_REFUSED[tag]}" if tag in _REFUSED else None


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
    own, (child, _) = _of(robot), _read(robot)
    _take_settings(child, spec)
    at_first = set(spec.actuators)
    body = spec.worldbody.add_frame().attach_body(child.body(own.base), prefix + MODEL_PREFIX, "")
    mine = prefix + MODEL_PREFIX
    body.name = prefix + BASE
    for joint in body.joints:
        joint.name = prefix + BASE
    actuators = [actuator for actuator in spec.actuators if actuator not in at_first]
    renamed = {mine + own.base: prefix + BASE}
    for name, joint_name in zip(WHEELS, own.wheels, strict=True):
        renamed[mine + joint_name] = prefix + name
    for equality in spec.equalities:
        equality.name1 = renamed.get(equality.name1, equality.name1)
        equality.name2 = renamed.get(equality.name2, equality.name2)
    casters = {mine + name for name in own.casters}
    _set_contacts(body, casters, contype)
    for name, joint_name in zip(WHEELS, own.wheels, strict=True):
        joint = spec.joint(mine + joint_name)
        joint.name = prefix + name
        _set_wheel(joint.parent, prefix + name)
        motor = next((each for each in actuators if each.target == mine + joint_name), None)
        if motor is None:
            motor = _add_motor(spec, robot)
            actuators.append(motor)
        motor.name = motor.target = prefix + name
    for actuator in actuators:
        actuator.group = (
            group if actuator.name in {prefix + name for name in WHEELS} else JOINT_GROUP
        )
    if contype:
        _exclude_each_other(spec, body, prefix)
    return body


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
            geom.name = ""
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


def _fail(text: str, *path: str) -> MjcfError:
    return MjcfError([(("model", *path), text)])


def _read(robot: RobotModel) -> tuple[mujoco.MjSpec, mujoco.MjModel]:
    """Read and check a model; return what is attached, and what it compiles to alone."""
    own = _of(robot)
    path = Path(own.file)
    written = _Written(path.parent)
    _look_through(written, path, path.parent.resolve())
    _look_at_assets(written)
    try:
        child = mujoco.MjSpec.from_file(str(path))
        for part in (*child.lights, *child.sensors, *child.keys, *child.excludes, *child.pairs):
            child.delete(part)
        model = child.compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        raise _fail(f"MuJoCo: {_in_a_line(str(error), path)}", "file") from error
    wrong = list(_misfits(robot, own, model, data))
    if wrong:
        raise MjcfError(wrong)
    for camera in list(child.cameras):
        child.delete(camera)
    return child, model


def _in_a_line(text: str, path: Path) -> str:
    """Return an error of MuJoCo on one line, with short names of files."""
    text = text.replace(f"{path.parent}/", "").strip()
    return " ".join(text.split())[:400] or "the model is not valid"


def _look_through(
    written: _Written, path: Path, folder: Path, names: tuple[Path, ...] = ()
) -> None:
    """Read an XML file and those that it includes, before MuJoCo does."""
    name = path.name
    if ".." in path.parts:
        raise _fail(f"{name} must lie in the folder of the robot's file, or below it", "file")
    try:
        real = path.resolve(strict=True)
        size = real.stat().st_size
        if not real.is_relative_to(folder):
            raise _fail(f"{name} lies outside of the folder of the robot's file", "file")
        if size > MOST_XML_BYTES:
            raise _fail(f"{name} has {size:,} bytes, the limit is {MOST_XML_BYTES:,}", "file")
        data = real.read_bytes()
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise _fail(f"cannot read {name}: {reason}", "file") from error
    if real in names:
        raise _fail(f"{name} includes itself", "file")
    written.files.append(real)
    if len(written.files) > MOST_FILES:
        raise _fail(f"{name}: more than {MOST_FILES} files are included", "file")
    for other in _parse(written, name, data):
        _look_through(written, _inside(written.folder, other, name), folder, (*names, real))


class _Handler(xml.sax.handler.ContentHandler, xml.sax.handler.LexicalHandler):
    """Notes the files that an XML text names; refuses what MuJoCo should not see."""

    def __init__(self, written: _Written, name: str) -> None:
        super().__init__()
        self._written, self._name = written, name
        self._locator: Any = None
        self.included: list[str] = []

    def setDocumentLocator(self, locator: Any) -> None:  # noqa: N802 - SAX's name
        """Keep what knows the line."""
        self._locator = locator

    def startElement(self, name: str, attrs: Any) -> None:  # noqa: N802 - SAX's name
        """Count and check an element."""
        wrong = self._written.begin(name)
        if wrong is not None:
            self._refuse(wrong)
        for key, value in attrs.items():
            _check_value(name, key, value, self._refuse)
            if name == "include" and key == "file":
                self.included.append(value)
            else:
                _note_file(self._written, name, key, value)

    def endElement(self, name: str) -> None:  # noqa: N802, ARG002 - SAX's name
        """Count an element."""
        self._written.depth -= 1

    def startDTD(self, *_: Any) -> None:  # noqa: N802 - SAX's name
        """Refuse entities."""
        self._refuse("a DOCTYPE is not supported")

    def _refuse(self, text: str) -> None:
        raise _fail(f"{self._name}, line {self._locator.getLineNumber()}: {text}", "file")


def _parse(written: _Written, name: str, data: bytes) -> list[str]:
    """Look through an XML text; return the files that it includes."""
    handler = _Handler(written, name)
    parser = xml.sax.make_parser()  # noqa: S317 - entities and sizes are limited
    parser.setContentHandler(handler)
    parser.setProperty(xml.sax.handler.property_lexical_handler, handler)
    try:
        parser.parse(BytesIO(data))
    except xml.sax.SAXParseException as error:
        text = f"line {error.getLineNumber()}: {error.getMessage()}"
        raise _fail(f"{name}, {text}", "file") from error
    except (xml.sax.SAXException, ValueError, LookupError) as error:
        raise _fail(f"{name}: {error}", "file") from error
    return handler.included


def _note_file(written: _Written, tag: str, key: str, value: str) -> None:
    """Note an attribute that names a file, or the folder of files."""
    if key == "assetdir":
        written.folders.update(meshdir=value, texturedir=value)
    elif key in ("meshdir", "texturedir"):
        written.folders[key] = value
    elif _FILE_ATTRIBUTE.match(key):
        written.assets.append((tag, value))


def _check_value(tag: str, key: str, value: str, refuse: Any) -> None:
    """Refuse numbers beyond any robot's, and texts that are too long."""
    if len(value) > 100_000:
        refuse(f"{tag}.{key} has {len(value):,} characters")
    for word in value.split():
        if word.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            refuse(f"{tag}.{key}: expected finite numbers, got {word}")
        if _NUMBERS.match(word) and not abs(float(word)) <= LARGEST_NUMBER:
            refuse(f"{tag}.{key}: {word} is larger than {LARGEST_NUMBER:g}")


def _inside(folder: Path, name: str, where: str) -> Path:
    """Return a file that a model names. It must lie in its folder."""
    plain = Path(name)
    if plain.is_absolute() or ".." in plain.parts or "\0" in name:
        raise _fail(f"{where} names {name}, which is outside of its folder", "file")
    return folder / plain


def _look_at_assets(written: _Written) -> None:
    total = 0
    folder = written.folder.resolve()
    for tag, name in written.assets:
        below = written.folders.get(_FOLDERS.get(tag, ""), "")
        path = _inside(_inside(written.folder, below, "the model"), name, "the model")
        try:
            real = path.resolve(strict=True)
            total += real.stat().st_size
        except (OSError, ValueError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise _fail(f"cannot read {name}: {reason}", "file") from error
        if not real.is_relative_to(folder):
            raise _fail(f"{name} lies outside of the folder of the robot's file", "file")
        if total > MOST_ASSET_BYTES:
            raise _fail(f"meshes and textures have more than {MOST_ASSET_BYTES:,} bytes", "file")


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
    yield from _rolling_misfits(own, model, base)
    yield from _place_misfits(robot, own, model, data, base)
    for path, name, limits in _moved(robot):
        for text in _joint_misfits(model, name, limits, base, own):
            yield path, text


def _rolling_misfits(
    own: ModelFile, model: mujoco.MjModel, base: int
) -> Iterator[tuple[Path_, str]]:
    """Yield what is wrong with wheels and casters."""
    for name in own.wheels:
        for text in _wheel_misfits(model, base, name):
            yield ("model", "wheels"), text
    if own.wheels[0] == own.wheels[1]:
        yield ("model", "wheels"), f"both wheels are the joint '{own.wheels[0]}'"
    geoms = _names(model, "geom")
    for name in own.casters:
        if name not in geoms:
            yield ("model", "casters"), _no_such("geom", name, geoms)


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
    if not (_colliding(model) & (model.geom_bodyid == base)).any():
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


def _wheel_misfits(model: mujoco.MjModel, base: int, name: str) -> Iterator[str]:
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if joint < 0:
        yield _no_such("joint", name, _names(model, "joint"))
        return
    body = int(model.jnt_bodyid[joint])
    if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
        yield f"expected a hinge, but the joint '{name}' is a {_kind(model, joint)} joint"
    if model.jnt_limited[joint]:
        yield f"the joint '{name}' of a wheel has a range; a wheel turns without end"
    if model.body_parentid[body] != base or model.body_jntnum[body] != 1:
        yield f"expected a body directly below the base, with the joint '{name}' alone"
    count = int((_colliding(model) & (model.geom_bodyid == body)).sum())
    if count != 1:
        yield f"expected one geom that touches the floor at the wheel '{name}', got {count}"
    driven = _actuators(model, joint)
    if len(driven) > 1:
        yield f"{len(driven)} actuators drive the wheel '{name}'; expected one, or none"
    for actuator in driven:
        gain, bias = model.actuator_gainprm[actuator], model.actuator_biasprm[actuator]
        if not (gain[0] > 0 and bias[1] == 0 and bias[2] == -gain[0]):
            yield f"expected a <velocity> actuator at the wheel '{name}', or none"


def _joint_misfits(
    model: mujoco.MjModel, name: str, limits: JointLimits, base: int, own: ModelFile
) -> Iterator[str]:
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if joint < 0:
        yield _no_such("joint", name, _names(model, "joint"))
        return
    if name in own.wheels:
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
    text = f"the model has no {kind} '{name}' (it has: {listed(names) if names else 'none'})"
    return f"{text}; {near}" if near else text
