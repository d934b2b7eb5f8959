"""The executive alone, on the clock of the ROS graph it joins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Self

from rclpy.node import Node

from bt_mission.language.mission import Mission
from bt_mission.ros.graph import GraphConnection, NodeOptions, ProcessNode
from bt_mission.ros.journal import open_journal
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.sessions.session import SessionObserver


@dataclass(frozen=True, kw_only=True)
class AttachedOptions:
    """How a mission joins a graph.

    Attributes:
        namespace: Of the robot whose servers to use.
        wall_clock: Keep to this machine's clock, without looking for ``/clock``.
        allow_duplicates: Go on where several nodes publish the same odometry or clock.
        journal: File in which to write down where the mission stands.
        resume: Go on with the mission of that journal.
    """

    namespace: str | None = None
    wall_clock: bool = False
    allow_duplicates: bool = False
    journal: Path | None = None
    resume: bool = False


class AttachedSession:
    """Runs one mission against action servers in other processes.

    Args:
        mission: What to carry out.
        options: How it joins the graph.
        say: Where ``log`` nodes speak to; None is the ROS log.

    Raises:
        BtMissionError: When the mission cannot be set up, the journal not be used, or two robots be
            taken for one.
    """

    image_folder: Path | None = None
    world: str | None = None
    collisions: int | None = None
    nature: Mapping[str, float] = MappingProxyType({})
    distance_travelled_m: float | None = None

    def __init__(
        self,
        mission: Mission,
        options: AttachedOptions | None = None,
        say: Callable[[str], None] | None = None,
    ) -> None:
        chosen = options or AttachedOptions()
        self.mission = mission
        self.facts: dict[str, str] = {}
        self.files: dict[str, str] = {}
        self._observers: list[SessionObserver] = []
        with ExitStack() as made:
            self._graph = GraphConnection(wall_clock=chosen.wall_clock)
            made.callback(self._graph.close)
            node = NodeOptions(
                namespace=chosen.namespace,
                context=self._graph.context,
                use_sim_time=self._graph.has_clock,
            )
            self.node = MissionNode(mission, RunnerOptions(say=say), node=node)
            self.runner = self.node.runner
            made.callback(self.node.destroy_node)
            if not chosen.allow_duplicates:
                self._graph.refuse_duplicates(self.node)
            self._graph.host(self.node)
            if chosen.journal is not None:
                journal = open_journal(chosen.journal, mission, self.runner, resume=chosen.resume)
                made.callback(journal.close)
            self._exit = made.pop_all()
        self.executive = self.runner.executive
        self.trace = self.runner.trace

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    @property
    def runs(self) -> tuple[Self]:
        """Itself: its one mission."""
        return (self,)

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""
        return self.executive.is_done

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""
        return self.runner.now_ns

    @property
    def start_ns(self) -> int:
        """ROS time of the first tick, ns; before it, the present."""
        return self.executive.started_ns or self.now_ns

    def add_node(self, node: Node) -> None:
        """Serve a node of somebody who looks on, too; its owner destroys it."""
        self._graph.host(node)

    def drain(self) -> None:
        """Serve what is on its way once the mission has ended."""
        self._graph.drain()

    def step(self) -> None:
        """Serve what comes next, for at most a tenth of a second."""
        self._graph.step(self.executive, self.node)
        for observer in self._observers:
            observer.look()

    def inside(self) -> tuple[ProcessNode, ...]:
        """None: all of the graph is heard by subscriptions."""
        return ()

    def add_observer(self, observer: SessionObserver) -> None:
        """Serve an observer's node, too, and call it after each step."""
        self._graph.host(observer.node)
        self._observers.append(observer)

    def remove_observer(self, observer: SessionObserver) -> None:
        """Call it no more, and destroy its node."""
        self._observers.remove(observer)
        self._graph.drop(observer.node)
