"""A robot's own MuJoCo model, and the joints that are neither wheels nor steering.

The model is a file of MuJoCo (MJCF) beside the robot's file. Arm and gripper have the limits within
which goals are accepted; they lie within those of the model.
"""

from typing import Annotated, Self

from pydantic import Field, model_validator

from bt_mission.robots.parts import NotNegative, Number, Point3, Positive, RobotPart

JointName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,59}$")]
ModelName = Annotated[str, Field(min_length=1, max_length=200)]


class ModelFile(RobotPart):
    """The MuJoCo model of a robot, and its names for what this package needs.

    `file` lies in the folder of the robot's file, or below it. `base` is the body with the free
    joint, whose frame is `base_link`. `wheels` are the joints of the wheels: left, right; of four
    wheels front left, front right, rear left, rear right; of an omnidirectional base in the order
    of `drive`. `steering` are the joints that steer a car: left, right. `casters` are geoms that
    slide without friction, each by its name, or by the place of its middle in the frame of the base
    (x, y, z in m). `lidar`, `imu` (sites) and `camera` are
    optional: `check` compares their places with those of the robot's file.
    """

    file: ModelName
    base: ModelName
    wheels: Annotated[tuple[ModelName, ...], Field(min_length=2, max_length=4)]
    steering: tuple[ModelName, ModelName] | None = None
    casters: Annotated[tuple[ModelName | Point3, ...], Field(max_length=16)] = ()
    lidar: ModelName | None = None
    imu: ModelName | None = None
    camera: ModelName | None = None


class JointLimits(RobotPart):
    """Where a joint may go, how fast, and where it starts; rad or m. `max_velocity` a second."""

    min: Number
    max: Number
    max_velocity: Positive
    start: Number = 0.0

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.min <= self.start <= self.max or self.min == self.max:
            raise ValueError(
                f"expected min < max with start between them, got {self.min:g}, {self.max:g} and"
                f" {self.start:g}"
            )
        return self


class ArmModel(RobotPart):
    """The joints of an arm, each with a position actuator of the model, by their names there."""

    joints: Annotated[dict[JointName, JointLimits], Field(min_length=1, max_length=16)]


class GripperModel(JointLimits):
    """A gripper: joints of the model that move together, and the largest force (N or N m).

    Limits and `position` of goals are those of each of its joints.
    """

    joints: Annotated[tuple[JointName, ...], Field(min_length=1, max_length=4)]
    max_effort: Positive
    tolerance: NotNegative = 0.002
