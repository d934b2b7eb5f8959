"""Several robots in one world, each with servers and a mission of its own, on one virtual clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

import rclpy
from rclpy.context import Context

from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.core.dds.discovery import isolate
from bt_mission.core.robot.model import load_robot
from bt_mission.executive.trace import Trace
from bt_mission.ros.mission_node import MissionNode
from bt_mission.sessions.stage import START_NS, StageError, free_folder
from bt_mission.virtual_time import VirtualTimeExecutor, self_test
from sim.physics.spawn import RobotSpawn
from sim.robot.robot import SimulatedRobot
from sim.ros.node import SimNode, SimOptions
from sim.world.loader import load_world
from sim.world.world import Spawn

if TYPE_CHECKING:
    from bt_mission.executive.executive import Executive
    from bt_mission.language.mission import Mission


@dataclass(frozen=True)
class FleetRobot:
    """A robot of the fleet: the namespace of all its names, its mission, and where it starts.

    The mission says which model of robot it is for; `x`, `y` are metres, `yaw` degrees.
    """

    name: str
    mission: Mission
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class FleetRun:
    """One member while the fleet runs."""

    member: FleetRobot
    robot: SimulatedRobot
    node: MissionNode

    @property
    def executive(self) -> Executive:
        """Ticks the member's mission."""
        return self.node.executive

    @property
    def trace(self) -> Trace:
        """What happened in the member's mission."""
        return self.node.trace


class FleetStage:
    """A world with several robots, the action servers of each, and a mission for each.

    Use it as a context manager; :meth:`step` until :attr:`is_done`. Relative names of a mission
    lie in the namespace of its robot, as the short names do.

    :param world: name or path of the world; the missions' own worlds do not count.
    :param members: the robots, in the order in which they are served.
    :param seed: of all sensor noise; each mission's own seed decides the rest.
    :param image_folder: where this run makes a folder for the pictures of each robot.
    :param say: where ``log`` nodes speak to, with the name of the robot; None is the ROS log.
    :raises BtMissionError: as :class:`Stage`, and for robots that do not fit.
    """

    def __init__(
        self,
        world: str | Path,
        members: Sequence[FleetRobot],
        *,
        seed: int,
        image_folder: Path,
        say: Callable[[str, str], None] | None = None,
    ) -> None:
        self._exit = ExitStack()
        for member in members:
            if member.mission.map == "unknown":
                raise StageError(
                    f"{member.name}: a fleet has no mapper, so 'map: unknown' cannot run"
                )
        scene = load_world(world)
        entrants = [
            RobotSpawn(
                load_robot(member.mission.robot, near=member.mission.file),
                member.name,
                Spawn(x=member.x, y=member.y, yaw=member.yaw),
            )
            for member in members
        ]
        isolate(visible=False)
        self_test()
        images = free_folder(image_folder)
        with ExitStack() as made:
            context = Context()
            rclpy.init(context=context)
            made.callback(context.shutdown)
            self.sim = SimNode(
                scene,
                entrants,
                SimOptions(seed=seed, start_ns=START_NS, lean=True, context=context),
            )
            made.callback(self.sim.destroy_node)
            servers = []
            for entrant in entrants:
                one = ServersNode(
                    entrant.robot,
                    ServerOptions(
                        image_folder=images / entrant.name,
                        lean=True,
                        context=context,
                        namespace=entrant.name,
                    ),
                )
                made.callback(one.destroy_node)
                servers.append(one)
            rides = []
            for member in members:
                node = MissionNode(
                    member.mission,
                    context=context,
                    namespace=member.name,
                    lean=True,
                    say=None if say is None else partial(say, member.name),
                    trace=Trace(hide={str(images): "<images>"}),
                )
                made.callback(node.destroy_node)
                rides.append(FleetRun(member, self.sim.fleet[member.name], node))
            self.rides = tuple(rides)
            self.clock = VirtualTimeExecutor(start_ns=START_NS, world=self.sim, context=context)
            made.callback(self.clock.shutdown)
            for each in (self.sim, *servers, *(ride.node for ride in rides)):
                self.clock.add_node(each)
            self._exit = made.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    def __getitem__(self, name: str) -> FleetRun:
        """The member of that name. Raises KeyError."""
        return {ride.member.name: ride for ride in self.rides}[name]

    @property
    def is_done(self) -> bool:
        """Has every mission ended, with every goal accounted for?"""
        return all(ride.executive.is_done for ride in self.rides)

    @property
    def now_ns(self) -> int:
        """The present instant of virtual time, ns."""
        return self.clock.now_ns

    @property
    def collisions(self) -> int:
        """How often any robot has touched an obstacle or another robot."""
        return self.sim.fleet.collisions

    def step(self) -> None:
        """Jump to the next instant at which anything is due, and serve it.

        An exception in a callback ends every mission that runs as failed with the cause; a second
        one, while goals are seen to their end, is raised as :class:`StageError`.
        """
        try:
            self.clock.step()
        except Exception as error:
            failing = f"{type(error).__name__}: {error}"
            running = [r.executive for r in self.rides if r.executive.status == "running"]
            if not running:
                raise StageError(f"the stage broke while missions ended: {failing}") from error
            for executive in running:
                executive.fail(f"a callback failed: {failing}")
