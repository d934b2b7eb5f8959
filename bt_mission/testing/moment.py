"""One control step of a run, for the conditions that tests state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.text import seconds
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageRun
from bt_mission.testing.history import History, Pose, Recorded, TestedGoal


class MomentSource(Protocol):
    """The run that a moment belongs to."""

    robot_run: StageRun
    stage: Stage
    history: History

    def find(self, name: str) -> Behaviour:
        """Return the node of this name, or at this path. Raises ScenarioError."""

    def topic(self, name: str) -> Recorded:
        """Return the recorded messages of a topic. Raises ScenarioError."""


class NodeView:
    """A node of the tree at one moment; not only of leaves."""

    def __init__(self, run: MomentSource, node: Behaviour, changes: int) -> None:
        self._run = run
        self._node = node
        self._changes = changes
        self._change = run.history.last_change(node, changes)
        self.name: str = node.name

    @property
    def status(self) -> str:
        """``idle``, ``running``, ``success`` or ``failure``."""
        status = self._change.status if self._change else Status.INVALID
        return "idle" if status is Status.INVALID else status.value.lower()

    @property
    def running(self) -> bool:
        """Does it run?"""
        return self.status == "running"

    @property
    def succeeded(self) -> bool:
        """Has it ended well, and not been entered again?"""
        return self.status == "success"

    @property
    def failed(self) -> bool:
        """Has it failed, and not been entered again?"""
        return self.status == "failure"

    @property
    def outcome(self) -> str:
        """What it said last, such as ``canceled by condition: ...``."""
        return self._change.message if self._change else ""

    @property
    def since(self) -> float:
        """When it came into its status, s since the start of the run."""
        change = self._change
        return 0.0 if change is None else self._run.history.seconds(change.time_ns or 0)

    @property
    def runs(self) -> int:
        """How often it has started.

        A leaf that starts and ends in one tick, and does so again with the same end, counts once.
        """
        history, node = self._run.history, self._node
        started = history.count(node, self._changes, Status.RUNNING)
        if started:
            return started
        return history.count(node, self._changes, Status.SUCCESS, Status.FAILURE)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.status} since {seconds(self.since)}>"


@dataclass(frozen=True, repr=False, eq=False)
class Moment:
    """A control step: where everything stood after it.

    Args:
        pose: True pose of the base in the map: x m, y m, yaw rad.
        odometry: Where the robot thinks it is, from where it started: x m, y m, yaw rad.
        commanded: What the base asks of its wheels: m/s ahead, rad/s to the left.
        distance: Length of the way so far, m.
        collisions: How often the robot has touched something so far.
        variables: The mission's inputs, and the outputs written so far.
    """

    _run: MomentSource
    _time_ns: int
    pose: Pose
    odometry: Pose
    _velocity: tuple[float, float]
    commanded: tuple[float, float]
    distance: float
    collisions: int
    variables: Mapping[str, Any]
    _changes: int
    """How many changes of status happened until then; so for goals and log lines."""
    _goal_changes: int
    _line_count: int
    _state: Any
    """Of the simulation, for what is worked out later."""

    @classmethod
    def of(cls, run: MomentSource) -> Moment:
        """Write down where everything stands now."""
        history, sim = run.history, run.robot_run.robot
        odometry = sim.odometry
        return cls(
            run,
            run.stage.now_ns,
            pose=sim.pose,
            odometry=(odometry.x, odometry.y, odometry.yaw),
            _velocity=sim.velocity,
            commanded=sim.commanded,
            distance=sim.distance_travelled,
            collisions=sim.collisions,
            variables=history.variables(),
            _changes=len(history.changes),
            _goal_changes=len(history.goal_changes),
            _line_count=len(history.logged_lines),
            _state=sim.record(),
        )

    @property
    def t(self) -> float:
        """Virtual time since the start, s."""
        return self._run.history.seconds(self._time_ns)

    # ---- the robot -----------------------------------------------------------------------

    @property
    def x(self) -> float:
        """True x, m."""
        return self.pose[0]

    @property
    def y(self) -> float:
        """True y, m."""
        return self.pose[1]

    @property
    def yaw(self) -> float:
        """True heading, rad."""
        return self.pose[2]

    @property
    def speed(self) -> float:
        """True speed ahead, m/s."""
        return self._velocity[0]

    @property
    def turn_rate(self) -> float:
        """True turn rate, rad/s, left positive."""
        return self._velocity[1]

    @property
    def clearance(self) -> float:
        """Room between the robot and the nearest thing it could touch, m; below 0 in it."""
        return float(self._clearance.distance)

    @property
    def nearest(self) -> str | None:
        """Name of the nearest thing that the robot could touch."""
        name = self._clearance.obstacle
        return None if name is None else str(name)

    @property
    def _clearance(self) -> Any:
        return self._run.history.review.clearance(self._state)

    def distance_to(self, x: float, y: float) -> float:
        """How far the axle's middle is from a point, m."""
        return math.hypot(self.x - x, self.y - y)

    # ---- the mission ---------------------------------------------------------------------

    def leaf(self, name: str) -> NodeView:
        """The node of this name, or at this path (``0.1``).

        Raises:
            ScenarioError: If not exactly one exists; it has their paths.
        """
        return NodeView(self._run, self._run.find(name), self._changes)

    @property
    def running(self) -> tuple[str, ...]:
        """Names of the leaves that run."""
        return tuple(
            node.name
            for node in self._run.history.nodes
            if not node.children and NodeView(self._run, node, self._changes).running
        )

    @property
    def goals(self) -> tuple[TestedGoal, ...]:
        """The goals sent so far, with their later states."""
        changes = self._run.history.goal_changes[: self._goal_changes]
        return tuple(dict.fromkeys(life for change, life in changes if change == "sent"))

    @property
    def open_goals(self) -> tuple[str, ...]:
        """Actions of the goals that had been sent and had not ended."""
        live: dict[str, str] = {}
        for change, life in self._run.history.goal_changes[: self._goal_changes]:
            if change == "ended":
                live.pop(life.id, None)
            else:
                live[life.id] = life.action
        return tuple(live.values())

    @property
    def log(self) -> list[str]:
        """What ``log`` nodes have said so far."""
        return [text for _, text in self._run.history.logged_lines[: self._line_count]]

    # ---- topics --------------------------------------------------------------------------

    def topic(self, name: str) -> Any:
        """The newest message of a recorded topic; None before the first.

        Raises:
            ScenarioError: When the topic is not recorded.
        """
        return self._run.topic(name).at(self._time_ns)

    @property
    def scan(self) -> Any:
        """The newest scan; its ``ranges`` are m, counter-clockwise from ahead."""
        return self.topic("scan")

    # ---- people --------------------------------------------------------------------------

    @property
    def tree(self) -> str:
        """The tree as text."""
        return self._run.history.tree_text(self._changes)

    def __repr__(self) -> str:
        return f"<moment {seconds(self.t)} at ({self.x:.2f}, {self.y:.2f})>"


Condition = Callable[[Moment], Any]
"""Something that holds at a moment, or does not."""
