"""The declaration of an action: one `Action` beside its maneuver, which all layers read.

The servers offer it, `bt-mission check` compares goals with its limits, the mission language has
its short name, and the contract suite runs against it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from action_servers.core.checks import (
    missing,
    refusal,
    stale,
    stale_joints,
    stale_odometry,
)
from action_servers.core.limits import Limits, faults
from action_servers.core.maneuver import Fields, Finished, Maneuver, Observation, Refusal
from action_servers.core.tuning import FrontierTuning, NavigationTuning, Tuning
from bt_mission.base.actions import ActionName
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel

if TYPE_CHECKING:
    from action_servers.core.grid import Floats

FeedbackRanges: TypeAlias = Mapping[str, tuple[float, float]]
"""From where to where the numbers of a feedback can go, by their names."""


class CameraSwitch(Protocol):
    """Switches the images for one maneuver on and off; both may be called in any state."""

    def on(self) -> None:
        """Request images; the observations contain them from then on."""

    def off(self) -> None:
        """Have no more pictures sent."""


class CameraTopic(Protocol):
    """The camera of the robot, as the servers see it."""

    @property
    def topic(self) -> str:
        """Its resolved name."""

    @property
    def is_sent(self) -> bool:
        """Whether a node publishes images."""

    def user(self) -> CameraSwitch:
        """Return a switch for one maneuver."""


class JointCommands(Protocol):
    """Sends joints of arm and gripper to positions."""

    def send(
        self, names: Sequence[str], positions: Sequence[float], efforts: Sequence[float] = ()
    ) -> None:
        """Send joints to positions, rad or m, to be reached within a period of control.

        `efforts` are their largest forces, N or N m; 0 is that of the robot.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerContext:
    """The possible parameters of a plan, by name; `camera` is then a separate switch."""

    robot: RobotModel
    tuning: Tuning
    navigation: NavigationTuning
    frontiers: FrontierTuning
    camera: CameraTopic
    image_folder: Path
    turn_velocity: float
    """Speed of a turn if the goal's speed is 0, rad/s."""
    publish_distance: Callable[[float], None]
    """Sends the distance that is being recorded, m."""
    joints: JointCommands
    publish_path: Callable[[Floats], None]
    """Sends a path that is planned: points in the map, `n x 2` m."""


def _no_limits(_robot: RobotModel, _tuning: Tuning) -> Limits:
    return ()


def _no_misfit(_goal: Any, _robot: RobotModel) -> None:
    return None


def _no_ranges(_goal: Any) -> FeedbackRanges:
    return {}


def _nothing(_maneuver: Any, _goal_id: str) -> AbstractContextManager[None]:
    return nullcontext()


@dataclass(frozen=True, kw_only=True)
class Action(ActionName):
    """An action that the servers offer. Where its result has `error_code`, they fill it.

    In the package `action_servers` it is assigned to a constant of a module, and what `ActionName`
    has is written as literals.

    Args:
        plan: Called with a goal message that is within the limits and with an observation that has
            what the action needs; returns the maneuver, or why the goal is refused. Its further
            parameters are fields of `ServerContext`, by their names.
        limits: The limits of single fields, for a robot and the parameters of its servers.
        misfit: Returns why the fields of a goal are invalid together for a robot, or None.
        misfit_code: The error code with which such a goal is aborted once it is accepted, as by
            Nav2; 0 where `plan` refuses it.
        codes: Of an action of Nav2: the error codes of Nav2 with which its goals end. The codes of
            a stop, of motors that are off and the like are from 900 on.
        feedback: The ranges of the feedback's numbers for a goal whose fields are all known.
        waits: Whether a goal is accepted before there is what it needs.
        during: Entered when a goal is accepted, with its maneuver and its id (32 hexadecimal
            digits), and left at its end.
    """

    plan: Callable[..., Maneuver | Refusal]
    limits: Callable[[RobotModel, Tuning], Limits] = _no_limits
    misfit: Callable[[Any, RobotModel], str | None] = _no_misfit
    misfit_code: int = 0
    codes: tuple[int, ...] = ()
    feedback: Callable[[Any], FeedbackRanges] = _no_ranges
    waits: bool = False
    during: Callable[[Any, str], AbstractContextManager[None]] = _nothing

    def planned(self, goal: Any, now: Observation, context: ServerContext) -> Maneuver | Refusal:
        """Check a goal; return the maneuver that runs it, or the refusal."""
        robot, tuning = context.robot, context.tuning
        if self.needs_camera and robot.camera is None:
            return Refusal(f"the robot '{robot.name}' has no camera")
        if lacks_part(self, robot):
            return Refusal(f"the robot '{robot.name}' has no {self.part}")
        refused = refusal(*faults(goal, self.limits(robot, tuning)))
        if refused is not None:
            return refused
        misfit = self.misfit(goal, robot) if self.misfit_code else None
        if misfit is not None:
            return Misfit(self.misfit_code, misfit)
        unready = None if self.waits else self._unready(now, tuning.sensor_timeout)
        if unready is not None:
            return unready
        planned = self.plan(goal, now, **self._asked(context))
        if isinstance(planned, Refusal) or not self.needs_camera or context.camera.is_sent:
            return planned
        return Refusal(f"nobody publishes {context.camera.topic}")

    def _unready(self, now: Observation, timeout_s: float) -> Refusal | None:
        return refusal(
            missing(now) if "map" in self.needs else None,
            stale_joints(now, timeout_s) if self.part else None,
            unready=stale(now, timeout_s)
            if "scan" in self.needs
            else stale_odometry(now, timeout_s)
            if "odometry" in self.needs
            else None,
        )

    def _asked(self, context: ServerContext) -> dict[str, Any]:
        """Return the parameters of the plan beyond goal and observation."""
        names = tuple(inspect.signature(self.plan).parameters)[2:]
        unknown = [name for name in names if name not in _CONTEXT]
        if unknown:
            raise TypeError(
                f"the plan of {self.name} asks for {', '.join(unknown)}; "
                f"there are: {', '.join(_CONTEXT)}"
            )
        return {
            name: context.camera.user() if name == "camera" else getattr(context, name)
            for name in names
        }


def lacks_part(action: ActionName, robot: RobotModel) -> bool:
    """Return whether a robot has no part that an action moves."""
    return bool(action.part) and getattr(robot, action.part) is None


_CONTEXT = tuple(field.name for field in fields(ServerContext))


class Misfit:
    """A goal that is accepted and then aborted, because its fields do not fit each other."""

    needs_base = False

    def __init__(self, code: int, reason: str) -> None:
        self._end = Finished("aborted", code, reason)

    def step(self, now: Observation) -> Twist2D | Finished:  # noqa: ARG002 - a maneuver's
        """End."""
        return self._end

    def feedback(self) -> Fields | None:
        """Return nothing: nothing was done."""
        return None

    def result(self) -> Fields:
        """Return nothing: nothing was done."""
        return {}
