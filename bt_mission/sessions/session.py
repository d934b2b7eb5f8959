"""A session and its runs: one or several missions, on the stage, attached to a graph, or served."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Self

from bt_mission.base.clock_watch import ClockWatch
from bt_mission.base.interrupts import name_of
from bt_mission.base.stamps import NS
from bt_mission.executive.executive import Executive
from bt_mission.executive.report import Report, report_on
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.ros.graph import ProcessNode
    from bt_mission.ros.mission_runner import MissionRunner
    from bt_mission.ros.robot_relay import RobotSnapshot


class MissionRun:
    """One mission of a session, with its robot.

    Attributes:
        name: The robot's name; empty if a session has a single robot without one.
        node: The name of the node below which the topics of the mission are; its namespace is that
            of the robot.
        runner: Runs the mission.
        facts: The facts of the robot, such as its hull.
        nature: The drawn nature of the robot; empty without one.
    """

    node: Node
    runner: MissionRunner
    nature: Mapping[str, float] = MappingProxyType({})

    def __init__(self, name: str = "") -> None:
        self.name = name
        self.facts: dict[str, str] = {}

    @classmethod
    def of(cls, runner: MissionRunner, node: Node | None = None) -> Self:
        """Return the run of a runner; the node is the runner's unless another is given."""
        run = cls()
        run.runner, run.node = runner, node or runner.node
        return run

    @property
    def mission(self) -> Mission:
        """The mission."""
        return self.runner.mission

    @property
    def executive(self) -> Executive:
        """Ticks the tree."""
        return self.runner.executive

    @property
    def trace(self) -> Trace:
        """The events, as lines."""
        return self.runner.trace

    def snapshot(self) -> RobotSnapshot | None:
        """Return the state of a simulated robot for viewers; None where it is not simulated."""
        return None

    @property
    def collisions(self) -> int | None:
        """The number of collisions of the robot; None if it is not known."""
        return None

    @property
    def distance_travelled_m(self) -> float | None:
        """True length of the robot's path, m; None if it is not known."""
        return None


class Onlooker:
    """Watches a session from :meth:`attach` to :meth:`close`: a view, a page, a video, a recorder.

    It is called by the session that it is attached to: see :meth:`Session.attach`.

    Attributes:
        node: Receives its messages; None where it has none. A session that follows a graph serves
            this node. The stage does not: the onlooker reads its messages alone.
        acts: Does it change the run? It is then called after all others, and an exception of it
            ends the missions.
        why_left: Why the missions are to end; empty while they may continue.
    """

    node: Node | None = None
    acts = False
    why_left = ""

    def attach(self, session: Session) -> None:
        """Start to watch a session, before its first step."""

    def after_step(self) -> None:
        """Called after each step of the session."""

    def close(self) -> None:
        """Stop watching."""


class StepCallback(Onlooker):
    """Calls a function after each step, when all onlookers have been called.

    Args:
        call: An exception of it ends the missions.
    """

    acts = True

    def __init__(self, call: Callable[[], object]) -> None:
        self._call = call

    def after_step(self) -> None:
        """Call it."""
        self._call()


class Session:
    """Missions that run together. A mission alone is a session with one run.

    Use it as a context manager; :meth:`step` until :attr:`is_done`. `mission`, `executive` and
    the like are those of the first run.

    Attributes:
        runs: One for each robot.
        facts: What is known of the place of the run, such as the world.
        files: The texts of the world and the robot, by name; empty where they are not simulated.
        world: Name of the simulated world; None where no world is simulated here.
        image_folder: Where the session saves its pictures; None where that is not known.
    """

    runs: tuple[MissionRun, ...]
    world: str | None = None
    image_folder: Path | None = None
    watch: ClockWatch | None = None
    """Watches the code of users; None without such code."""

    def __init__(self) -> None:
        self.facts: dict[str, str] = {}
        self.files: Mapping[str, bytes] = {}
        self._onlookers: list[Onlooker] = []
        self._exit = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    def step(self) -> None:
        """Continue for a little while, then call the onlookers."""
        raise NotImplementedError

    @property
    def is_done(self) -> bool:
        """Whether every mission has ended, with every goal accounted for."""
        return all(run.executive.status.is_final for run in self.runs)

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""
        return self.runner.now_ns

    @property
    def start_ns(self) -> int:
        """ROS time of the first tick, ns; before it, the present."""
        return self.executive.started_ns or self.now_ns

    @property
    def node(self) -> Node:
        """The node of the first run."""
        return self.runs[0].node

    @property
    def runner(self) -> MissionRunner:
        """The runner of the first run."""
        return self.runs[0].runner

    @property
    def mission(self) -> Mission:
        """The mission of the first run."""
        return self.runs[0].mission

    @property
    def executive(self) -> Executive:
        """The executive of the first run."""
        return self.runs[0].executive

    @property
    def trace(self) -> Trace:
        """The trace of the first run."""
        return self.runs[0].trace

    def inside(self) -> Iterable[ProcessNode]:
        """Yield the nodes whose publishers onlookers may observe; others need subscriptions."""
        return ()

    def add_node(self, node: Node) -> None:
        """Serve another node, too; its owner destroys it."""
        self._serve(node)

    def leave(self) -> None:
        """End the missions at once, from another thread: a callback does not return."""
        numbers = self.watch.signals if self.watch else []
        for run in self.runs:
            if numbers:
                run.executive.interrupt(f"interrupted by {name_of(numbers[-1])}")
            run.executive.abandon("left while a callback did not return")

    def attach(self, onlooker: Onlooker) -> None:
        """Attach an onlooker; it is called after each step from now on."""
        if onlooker.node is not None:
            self._serve(onlooker.node)
        onlooker.attach(self)
        self._onlookers.append(onlooker)
        self._onlookers.sort(key=lambda onlooker: onlooker.acts)

    def detach(self, onlooker: Onlooker) -> None:
        """Call it no more, and destroy its node."""
        if onlooker in self._onlookers:
            self._onlookers.remove(onlooker)
            if onlooker.node is not None:
                self._drop(onlooker.node)

    def reports(self, wall_s: float = 0.0) -> tuple[Report, ...]:
        """The report of each run, so far or complete."""
        return tuple(self.report(wall_s, run) for run in self.runs)

    def report(self, wall_s: float = 0.0, run: MissionRun | None = None) -> Report:
        """Return the report of a run; of the first if none is given.

        Args:
            wall_s: Its wall time.
        """
        run = run or self.runs[0]
        end_ns = run.executive.ended_ns or self.now_ns
        distance = run.distance_travelled_m
        return replace(
            report_on(
                run.mission,
                run.executive,
                run.trace,
                (end_ns - self.start_ns) / NS,
                wall_s,
                run.runner.requirements.results(),
                run.runner.warnings,
            ),
            world=self.world,
            collisions=run.collisions,
            nature=dict(run.nature),
            distance_travelled_m=None if distance is None else round(distance, 6),
        )

    # ---- for subclasses --------------------------------------------------------------------

    def _call_onlookers(self) -> None:
        for onlooker in tuple(self._onlookers):
            onlooker.after_step()

    def _serve(self, node: Node) -> None:
        """Serve the node of an onlooker."""

    def _drop(self, node: Node) -> None:
        """Serve it no more, and destroy it."""
        node.destroy_node()
