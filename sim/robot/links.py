"""The links that the joints of arm and gripper move: their frames, and what people see of them.

A link is the body of a joint in the robot's MuJoCo model. Its frame has the origin of the joint and
the axes of the body. Its parent is the link of the next declared joint towards the base, or
`base_link`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from bt_mission.robots.joints import JointLimits
from bt_mission.robots.model import RobotModel
from sim.frames import BASE_LINK, FramePose, Quaternion, Vector
from sim.physics.names import BASE, LOOKS, MODEL_PREFIX
from sim.physics.physics import Physics

_KINDS = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "cylinder",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
}
"""The shapes of URDF for those of MuJoCo; a box is drawn around others."""


@dataclass(frozen=True)
class LinkShape:
    """What people see of a link: a sphere or cylinder of radius and half height, or half edges."""

    kind: str
    half: Vector
    at: Vector
    rotation: Quaternion
    rgba: tuple[float, float, float, float]


@dataclass(frozen=True)
class Link:
    """A link, its joint, and its frame while all joints are at 0."""

    joint: str
    is_slide: bool
    axis: Vector
    limits: JointLimits
    max_effort: float
    frame: FramePose
    shapes: tuple[LinkShape, ...]


class Links:
    """The links of one robot, and their places while it moves."""

    def __init__(self, physics: Physics, robot: RobotModel, prefix: str) -> None:
        model = physics.model
        limits = robot.moved_joints
        own = prefix + MODEL_PREFIX
        joints = {name: int(model.joint(own + name).id) for name in limits}
        self._data = physics.data
        self._base = int(model.body(prefix + BASE).id)
        self._bodies = {int(model.jnt_bodyid[joint]): joint for joint in joints.values()}
        self._model = model
        self._parents = {body: self._parent(body) for body in self._bodies}
        at_zero = mujoco.MjData(model)
        at_zero.qpos[[model.jnt_qposadr[joint] for joint in joints.values()]] = 0.0
        mujoco.mj_kinematics(model, at_zero)
        names = {body: self._name(body, own) for body in self._bodies} | {self._base: BASE_LINK}
        self.all = tuple(
            self._link(name, joint, limits[name], names, at_zero) for name, joint in joints.items()
        )
        """In the order of the joints in the robot's file; a body of two joints is that of both."""

    def places(self) -> tuple[float, ...]:
        """Return x, y, z (m) and the quaternion x, y, z, w of each frame now, one after another."""
        poses = (self._pose(body, self._data) for body in self._bodies)
        return tuple(number for place, turn in poses for number in (*place, *turn))

    @property
    def frames(self) -> tuple[FramePose, ...]:
        """The frames of all links while their joints are at 0, each once, as in `places`."""
        return tuple({link.frame.child: link.frame for link in self.all}.values())

    def _parent(self, body: int) -> int:
        above = int(self._model.body_parentid[body])
        while above not in self._bodies and above != self._base:
            above = int(self._model.body_parentid[above])
        return above

    def _name(self, body: int, own: str) -> str:
        joint = self._model.joint(self._bodies[body]).name
        return f"{joint.removeprefix(own).removesuffix('_joint')}_link"

    def _place(self, body: int, data: mujoco.MjData) -> tuple[Any, Any]:
        """Return the origin and the rotation of a link in the map."""
        turn = data.xmat[body].reshape(3, 3)
        if body == self._base:
            return data.xpos[body], turn
        return data.xpos[body] + turn @ self._model.jnt_pos[self._bodies[body]], turn

    def _pose(self, body: int, data: mujoco.MjData) -> tuple[Vector, Quaternion]:
        (above, above_turn), (here, turn) = (
            self._place(each, data) for each in (self._parents[body], body)
        )
        place = above_turn.T @ (here - above)
        return _vector(place), _quaternion(above_turn.T @ turn)

    def _link(
        self,
        name: str,
        joint: int,
        limits: JointLimits,
        names: dict[int, str],
        at_zero: mujoco.MjData,
    ) -> Link:
        model, body = self._model, int(self._model.jnt_bodyid[joint])
        place, turn = self._pose(body, at_zero)
        actuator = int(np.flatnonzero(model.actuator_trnid[:, 0] == joint)[0])
        return Link(
            name,
            bool(model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE),
            _vector(model.jnt_axis[joint]),
            limits,
            float(model.actuator_forcerange[actuator, 1]),
            FramePose(names[self._parents[body]], names[body], place, turn),
            tuple(self._shapes(body, at_zero)),
        )

    def _shapes(self, body: int, data: mujoco.MjData) -> Sequence[LinkShape]:
        """Return what is seen of a body, and of those that are fixed to it."""
        model = self._model
        origin, turn = self._place(body, data)
        own = (model.body_weldid[model.geom_bodyid] == body) & (model.geom_group == LOOKS)
        shapes = []
        for geom in np.flatnonzero(own).tolist():
            kind = _KINDS.get(mujoco.mjtGeom(int(model.geom_type[geom])), "box")
            axes = data.geom_xmat[geom].reshape(3, 3)
            middle, half = data.geom_xpos[geom], model.geom_size[geom]
            if kind == "box":
                middle = middle + axes @ model.geom_aabb[geom, :3]
                half = model.geom_aabb[geom, 3:]
            shapes.append(
                LinkShape(
                    kind,
                    _vector(half),
                    _vector(turn.T @ (middle - origin)),
                    _quaternion(turn.T @ axes),
                    tuple(model.geom_rgba[geom].tolist()),
                )
            )
        return shapes


def _vector(numbers: Any) -> Vector:
    x, y, z = np.asarray(numbers).tolist()
    return x, y, z


def _quaternion(turn: Any) -> Quaternion:
    result = np.empty(4)
    mujoco.mju_mat2Quat(result, np.ascontiguousarray(turn).ravel())
    w, x, y, z = result.tolist()
    return x, y, z, w
