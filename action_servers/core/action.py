"""The declaration of an action: one `Action` beside its maneuver, which all layers read.

The servers offer it, `bt-mission check` compares goals with its limits, the mission language has
its short name, and the contract suite runs against it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from action_servers.core.limits import Limits, faults
from action_servers.core.maneuver import (
    Fields,
    Finished,
    Maneuver,
    Observation,
    Refusal,
    missing,
    refusal,
    stale,
    stale_joints,
    stale_odometry,
)
from action_servers.core.tuning import TUNING
from bt_mission.base.actions import ActionName, declared
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import specs
from bt_mission.robots.model import RobotModel

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


@dataclass(frozen=True, slots=True)
class PublishedTopic:
    """A topic on which goals publish besides their feedback; a header gets the map and the time."""

    name: str
    type: str
    is_latched: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerContext:
    """The services of the servers to every action.

    Its fields are the possible parameters of a plan, by name. For one action, `tuning` has the
    present values of its parameters, `camera` is a separate switch, and `publish` takes the fields
    of a message on its topic.
    """

    robot: RobotModel
    tuning: Callable[[Any], Any]
    """Returns parameters with their present values, from the defaults."""
    camera: CameraTopic
    image_folder: Path
    """The folder in which images are stored, those of each goal in a folder."""
    joints: JointCommands
    publish: Callable[[PublishedTopic, Fields], None]


def _no_limits(_robot: RobotModel, _tuning: Any) -> Limits:
    return ()


def _no_misfit(_goal: Any, _robot: RobotModel) -> None:
    return None


def _no_ranges(_goal: Any) -> FeedbackRanges:
    return {}


def _nothing(_maneuver: Any, _goal_id: str) -> AbstractContextManager[None]:
    return nullcontext()


def _is_ready() -> None:
    pass


@dataclass(frozen=True, kw_only=True)
class Action(ActionName):
    """An action that the servers offer. Where its result has `error_code`, they fill it.

    In the package `action_servers` it is assigned to a constant of a module, and what `ActionName`
    has is written as literals.

    Args:
        plan: Called with a goal message that is within the limits and with an observation that has
            what the action needs; returns the maneuver, or why the goal is refused. Its further
            parameters are fields of `ServerContext`, by their names.
        tuning: Its parameters, a frozen dataclass of `bt_mission.base.parameters.number`s. The
            servers declare them.
        topic: The topic on which its goals publish, if any.
        limits: The limits of single fields, for a robot and the values of `tuning`.
        misfit: Returns why the fields of a goal are invalid together for a robot, or None.
        misfit_code: The error code with which such a goal is aborted once it is accepted, as by
            Nav2; 0 where `plan` refuses it.
        codes: Of an action of Nav2: the error codes of Nav2 with which its goals end. The codes of
            a stop, of motors that are off and the like are from 900 on.
        feedback: The ranges of the feedback's numbers for a goal whose fields are all known.
        waits: Whether a goal is accepted before there is what it needs.
        during: Entered when a goal is accepted, with its maneuver and its id (32 hexadecimal
            digits), and left at its end.
        offered: Called before the action is offered: it loads what a first goal would wait for.
    """

    plan: Callable[..., Maneuver | Refusal]
    tuning: Any = TUNING
    topic: PublishedTopic | None = None
    limits: Callable[[RobotModel, Any], Limits] = _no_limits
    misfit: Callable[[Any, RobotModel], str | None] = _no_misfit
    misfit_code: int = 0
    codes: tuple[int, ...] = ()
    feedback: Callable[[Any], FeedbackRanges] = _no_ranges
    waits: bool = False
    during: Callable[[Any, str], AbstractContextManager[None]] = _nothing
    offered: Callable[[], object] = _is_ready

    def limits_with(self, robot: RobotModel, values: Mapping[str, Any] | None = None) -> Limits:
        """Return its limits for a robot and servers; `values` are those of parameters by name."""
        given = values or {}
        changes = {
            attribute: given[name]
            for attribute, (name, _) in specs(self.tuning).items()
            if name in given
        }
        return self.limits(robot, replace(self.tuning, **changes))

    def planned(self, goal: Any, now: Observation, context: ServerContext) -> Maneuver | Refusal:
        """Check a goal; return the maneuver that runs it, or the refusal."""
        robot, tuning = context.robot, context.tuning(self.tuning)
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
        unready = None if self.waits else self._unready(now, context.tuning(TUNING).sensor_timeout)
        if unready is not None:
            return unready
        given = {name: _given(name, self, context, tuning) for name in self._asked}
        planned = self.plan(goal, now, **given)
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

    @cached_property
    def _asked(self) -> tuple[str, ...]:
        """The parameters of the plan beyond goal and observation."""
        names = tuple(inspect.signature(self.plan).parameters)[2:]
        unknown = [name for name in names if name not in _CONTEXT]
        if unknown:
            raise TypeError(
                f"the plan of {self.name} asks for {', '.join(unknown)}; "
                f"there are: {', '.join(_CONTEXT)}"
            )
        return names


def _given(name: str, action: Action, context: ServerContext, tuning: Any) -> Any:
    """Return what an action gets for a parameter of its plan."""
    if name == "tuning":
        return tuning
    if name == "camera":
        return context.camera.user()
    if name == "publish":
        assert action.topic is not None, f"{action.name} has no topic"
        return partial(context.publish, action.topic)
    return getattr(context, name)


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


def action(name: str) -> Action:
    """Return one of the actions of `declared`.

    Its module is imported now: the libraries for images and maps take longer to import than
    everything else.
    """
    place = declared()[name]
    declaration: Action = getattr(import_module(place.module), place.attribute)
    return declaration
