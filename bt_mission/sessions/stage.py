"""The stage: world, servers and executive in one process on one virtual clock.

This is the one module that puts the three together. Everything between them goes through real
rclpy and DDS, as between processes; only time is ours.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Self

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from action_servers.mapping.node import MapperNode, MapperOptions
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.core.dds.discovery import isolate
from bt_mission.core.errors import BtMissionError
from bt_mission.core.robot.model import load_robot
from bt_mission.executive.executive import MissionStatus
from bt_mission.executive.trace import Trace
from bt_mission.language.nodes.steps import ActionStep, PythonStep
from bt_mission.language.trees import all_steps
from bt_mission.ros.graph import ProcessNode
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.robot_relay import RobotRelay, RobotSnapshot
from bt_mission.virtual_time import VirtualTimeExecutor, self_test
from sim.ros.node import SimNode, SimOptions
from sim.world.loader import load_world

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission
    from bt_mission.sessions.observers import SessionObserver

START_NS = 1_000_000_000
DEFAULT_WORLD = "empty_arena"


class StageError(BtMissionError):
    """The stage cannot go on."""


def free_folder(parent: Path) -> Path:
    """The first of ``run_001``, ``run_002``, ... that is not there yet; it is not made."""
    parent = parent.expanduser().resolve()
    return next(path for n in count(1) if not (path := parent / f"run_{n:03d}").exists())


def _has_code_of_its_own(mission: Mission) -> bool:
    """Is there any behaviour of which only its author knows what it asks for?"""
    return any(isinstance(step, PythonStep) for step in all_steps(mission))


class Stage:
    """A world with a robot, its action servers, and the executive of one mission.

    Where the mission does not know its map, a mapper is there too, and the world publishes none.
    Of the actions, those of the mission are offered, and all once somebody else may ask for them:
    the servers that nobody asks would take a twelfth of the time.

    Use it as a context manager; :meth:`step` until :attr:`is_done`. Everything that is random
    comes from the mission's seed.

    :param mission: what to carry out; it names world, robot and seed.
    :param image_folder: where this run makes a folder of its own for pictures, if it takes any.
    :param say: where ``log`` nodes speak to; None is the ROS log.
    :param visible: may other processes of this machine look on, and take part?
    :param watched: offer the topics and services for tools also where nobody else may look on.
    :param without: actions that the servers leave to others, by their relative names.
    :param context: the rclpy context of all nodes, which stays; None makes one for the run.
    :param props: how many obstacles can appear while it runs.
    :raises BtMissionError: for a world, robot or action type that is not there, and where this
        machine cannot keep virtual time.
    """

    def __init__(
        self,
        mission: Mission,
        *,
        image_folder: Path,
        say: Callable[[str], None] | None = None,
        visible: bool = False,
        watched: bool = False,
        without: Collection[str] = (),
        context: Context | None = None,
        props: int = 0,
    ) -> None:
        self.mission = mission
        isolate(visible=visible)
        world = load_world(mission.world or DEFAULT_WORLD, near=mission.file)
        robot = load_robot(mission.robot, near=mission.file)
        self_test()
        images = free_folder(image_folder)
        with ExitStack() as made:
            if context is None:
                context = Context()
                rclpy.init(context=context)
                made.callback(context.shutdown)
            self.sim = SimNode(
                world,
                robot,
                SimOptions(
                    seed=mission.seed,
                    start_ns=START_NS,
                    lean=True,
                    context=context,
                    with_map=mission.map == "known",
                    props=props,
                ),
            )
            made.callback(self.sim.destroy_node)
            self._offers_all = visible or watched or _has_code_of_its_own(mission)
            options = ServerOptions(
                image_folder=images, lean=True, context=context, without=without
            )
            self._make_servers: Callable[[], ServersNode] = lambda: ServersNode(
                robot, replace(options, at_first=self._at_first())
            )
            self.servers = self._make_servers()
            self.has_servers = True
            made.callback(self._end_servers)
            self.mapper: MapperNode | None = None
            if mission.map == "unknown":
                self.mapper = MapperNode(robot, MapperOptions(lean=True, context=context))
                made.callback(self.mapper.destroy_node)
            trace = Trace(hide={str(images): "<images>"})
            self.node = MissionNode(
                mission,
                context=context,
                lean=True,
                say=say,
                trace=trace,
                has_controls=visible or watched,
                why_rejected=self._why_rejected,
            )
            made.callback(self.node.destroy_node)
            self.clock = VirtualTimeExecutor(start_ns=START_NS, world=self.sim, context=context)
            made.callback(self.clock.shutdown)
            for node in (self.sim, self.servers, self.mapper, self.node):
                if node is not None:
                    self.clock.add_node(node)
            if visible or watched:
                relay = RobotRelay(self.node, self._look)
                self.node.executive.after_tick.append(relay.flush)
            self._exit = made.pop_all()
        self.context = context
        self.executive = self.node.executive
        self.trace = self.node.trace
        self.image_folder = images
        self.facts = {
            "world": world.name,
            "robot_hull": json.dumps([robot.hull.front, robot.hull.rear, robot.hull.half_width]),
        }
        self._observers: list[SessionObserver] = []
        self._beats = 0
        self.trace.record(
            START_NS,
            "start",
            mission=mission.name,
            world=world.name,
            robot=robot.name,
            seed=mission.seed,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""
        return self.executive.is_done

    @property
    def now_ns(self) -> int:
        """The present instant of virtual time, ns; runs start at one second."""
        return self.clock.now_ns

    @property
    def start_ns(self) -> int:
        """Virtual time of the start, ns."""
        return START_NS

    @property
    def collisions(self) -> int:
        """How often the robot has touched something other than the floor."""
        return self.sim.simulation.collisions

    @property
    def distance_travelled_m(self) -> float:
        """The true length of the robot's path, m."""
        return self.sim.simulation.distance_travelled

    def _look(self) -> RobotSnapshot:
        """What people who look on see of the robot."""
        robot = self.sim.simulation
        spec, battery = robot.robot.lidar, robot.battery
        return RobotSnapshot(
            time_ns=self.now_ns,
            pose=robot.pose,
            lidar=(spec.x, spec.y, 0.0),
            ranges=robot.scan(0),
            reach=(spec.min_range, spec.max_range),
            charge=battery.percentage,
            voltage=battery.voltage,
        )

    def add_node(self, node: Node) -> None:
        """Have a node of one's own take part, on the clock of the stage; its owner destroys it."""
        self.offer_all()
        self.clock.add_node(node)
        self._exit.callback(self.clock.remove_node, node)

    def make_node(self, name: str) -> Node:
        """A bare node that takes part, and goes with the stage."""
        node = Node(name, context=self.context, enable_rosout=False, start_parameter_services=False)
        self._exit.callback(node.destroy_node)
        self.add_node(node)
        return node

    def offer_all(self) -> None:
        """Offer also the actions that the mission does not use."""
        self._offers_all = True
        if self.has_servers:
            self.servers.offer_all()

    def kill_servers(self) -> None:
        """Have the action servers leave the graph without a word, as a process that is killed."""
        if self.has_servers:
            self.has_servers = False
            self.clock.remove_node(self.servers)
            self.servers.vanish()

    def start_servers(self) -> None:
        """Have action servers again, after the first were killed; they know nothing of goals."""
        if not self.has_servers:
            self.servers = self._make_servers()
            self.has_servers = True
            self.clock.add_node(self.servers)

    def drain(self) -> None:
        """Serve what is on its way once the mission has ended; time stands still."""
        self.clock.run_until_quiet()

    def step(self) -> None:
        """Jump to the next instant at which anything is due, and serve it.

        An exception in a callback of a node ends the mission as failed with the cause; a second
        one, while the goals are seen to their end, is raised as :class:`StageError`.
        """
        try:
            self.clock.step()
        except Exception as error:
            failing = f"{type(error).__name__}: {error}"
            if self.executive.status is not MissionStatus.RUNNING:
                raise StageError(f"the stage broke while the mission ended: {failing}") from error
            self.executive.fail(f"a callback failed: {failing}")
        if self.executive.cycles != self._beats:
            self._beats = self.executive.cycles
            x, y, yaw = self.sim.simulation.pose
            self.trace.record(
                self.now_ns, "pose", x=x, y=y, yaw=yaw, collisions=self.sim.simulation.collisions
            )
            if not math.isfinite(x + y + yaw):
                raise StageError("the simulation became unstable: the robot's pose is not finite")
        for observer in self._observers:
            observer.look()

    def inside(self) -> Iterator[ProcessNode]:
        """The nodes of the stage."""
        for node in self.clock.get_nodes():
            yield ProcessNode(node, is_sensor=node is self.sim)

    def add_observer(self, observer: SessionObserver) -> None:
        """Call an observer after each step, when all of that instant has happened.

        Its node is not served: it takes by itself what it was sent, without an effect on the run.
        """
        self._observers.append(observer)

    def remove_observer(self, observer: SessionObserver) -> None:
        """Call it no more, and destroy its node."""
        self._observers.remove(observer)
        observer.node.destroy_node()

    def _at_first(self) -> set[str] | None:
        """The actions to offer for now, by their relative names; None is all."""
        if self._offers_all:
            return None
        steps = all_steps(self.mission)
        return {step.action.strip("/") for step in steps if isinstance(step, ActionStep)}

    def _why_rejected(self, action: str) -> str:
        return self.servers.why_rejected(action)

    def _end_servers(self) -> None:
        if self.has_servers:
            self.servers.destroy_node()
