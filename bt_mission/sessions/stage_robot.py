"""One robot on the stage: its action servers, and the executive of its mission."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

from rclpy.context import Context
from rclpy.node import Node
from typing_extensions import override

from action_servers.mapping.node import MapperNode, MapperOptions
from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.base.nature import NO_NATURE, Nature
from bt_mission.base.yaml.document import Document
from bt_mission.executive.events.events import PoseSampled
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission, NodeFactory
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.trees import all_steps, has_python
from bt_mission.programs.mains import WholeProgram
from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.ros.robot_relay import RobotRelay, RobotSnapshot
from bt_mission.sessions.revising import read_revision
from bt_mission.sessions.session import MissionRun
from bt_mission.sessions.stage_nodes import StageMapperNode, StageMissionNode, StageServersNode
from bt_mission.sessions.stage_signals import StageSignals
from sim.physics.simulator import SimulatorFactory
from sim.robot.robot import SimulatedRobot
from sim.world.world import Spawn, World


@dataclass(frozen=True)
class StageOptions:
    """The options of a stage.

    Attributes:
        world: The world, its name, path or text; None is that of the first mission.
        simulator: What makes the simulator of a robot alone (:mod:`sim.physics.simulator`); None is
            MuJoCo.
        start: The start of a robot alone: x m, y m, yaw degrees; None is that of the world.
        nature: The differences between runs; None is that of the mission, or else of the world.
        default_nature: The nature if neither these options nor mission nor world set one.
        seed: The seed of all sensor noise and of nature; None is that of the first mission. Each
            mission's own seed decides the rest.
        visible: Whether other processes of this machine may watch, and take part.
        network: With `visible`, whether those of other machines may, too.
        watched: Offer the topics and services for tools even if no other process can watch.
        without: Actions that other nodes serve, by their relative names.
        nodes: Make nodes of the user, besides those that missions name; called with ``context=``.
            The nodes join the stage on its clock. Actions that they offer replace those of the
            servers.
        programs: Whole programs, which run beside those.
        context: The rclpy context of all nodes, which stays; None makes one for the run.
        props: The number of obstacles that can appear during the run.
        editable: Take new versions of missions from other processes while they run.
        command_type: The type of `cmd_vel`: `TwistStamped` ("stamped") or `Twist` ("plain").
        hold_limit_s: Wall time after which a callback of a user is interrupted, s; None waits for
            Ctrl-C.
    """

    world: str | Path | Document | World | None = None
    simulator: NodeFactory | SimulatorFactory | None = None
    start: tuple[float, float, float] | None = None
    nature: Nature | None = None
    default_nature: Nature = NO_NATURE
    seed: int | None = None
    visible: bool = False
    network: bool = False
    watched: bool = False
    without: Collection[str] = ()
    nodes: Sequence[NodeFactory | Callable[..., Node]] = ()
    programs: Sequence[WholeProgram] = ()
    context: Context | None = None
    props: int = 0
    editable: bool = False
    command_type: Literal["stamped", "plain"] = "stamped"
    hold_limit_s: float | None = None

    @property
    def has_tools(self) -> bool:
        """Whether there are topics and services for tools."""
        return self.visible or self.watched


def _portable_names(mission: Mission) -> dict[str, str]:
    """Name the files of a mission in its trace as on every machine; failures name their place."""
    names = {document.file: mission.portable_name(document.file) for document in mission.documents}
    return {file: name for file, name in names.items() if file != name}


def _relative(names: Collection[str], namespace: str) -> Iterator[str]:
    """Yield those of the full names that lie in a namespace, without it."""
    prefix = f"/{namespace}/" if namespace else "/"
    return (name.removeprefix(prefix) for name in names if name.startswith(prefix))


@dataclass(frozen=True)
class FleetRobot:
    """A robot for the stage, with its mission.

    Attributes:
        name: The namespace of all its names. A robot without one is alone on the stage, and starts
            at the world's spawn.
        mission: It says which model of robot it is for.
        x: Its start on the map, m; y: the same along y.
        yaw: Its heading there, degrees.
        model: The text of its model; None is that of the mission.
    """

    name: str
    mission: Mission
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    model: Document | None = None

    def start_in(self, world: World) -> Spawn:
        """Return where it starts."""
        return Spawn(x=self.x, y=self.y, yaw=self.yaw) if self.name else world.spawn


class StageRun(MissionRun):
    """The run of one robot on the stage, with its action servers.

    Args:
        member: The robot.
        robot: What moves in the simulation.
        context: The rclpy context of its nodes.
        images: The folder of the stage's images; a robot with a name has a subfolder.
        options: The options of the stage.
        offered: Actions that nodes of the user offer, by their full names.
    """

    def __init__(
        self,
        member: FleetRobot,
        robot: SimulatedRobot,
        context: Context,
        images: Path,
        options: StageOptions,
        offered: Collection[str],
    ) -> None:
        super().__init__(member.name)
        self.member = member
        self.robot = robot
        hull = robot.robot.hull
        # From its center to front, rear and side, m.
        self.facts = {"robot_hull": json.dumps([hull.front, hull.rear, hull.half_width])}
        self.node: MissionNode
        self._context = context
        self._cycles = 0
        self._images = images
        self._options = options
        self._server_options = ServerOptions(
            image_folder=images / member.name,
            lean=True,
            has_parameters=options.visible,
            context=context,
            namespace=member.name or None,
            command_type=options.command_type,
            without={*options.without, *_relative(offered, member.name)},
        )
        # Python code may use actions that only its author knows.
        has_code = bool(member.mission.nodes or options.nodes) or has_python(member.mission)
        self._offers_all = options.has_tools or bool(member.name) or has_code
        self.servers = self._make_servers()
        self.has_servers = True
        self.mapper: MapperNode | None = None
        if member.mission.map == "unknown":
            mapping = MapperOptions(lean=True, has_parameters=options.visible, context=context)
            self.mapper = StageMapperNode(robot.robot, mapping)

    def _make_servers(self) -> ServersNode:
        options = replace(self._server_options, at_first=self._at_first())
        return StageServersNode(self.robot.robot, options)

    def make_executive(self, say: Callable[[str], None] | None) -> None:
        """Make the node of the mission; `say` receives the lines of its ``log`` nodes."""
        name, mission = self.member.name, self.member.mission
        options = RunnerOptions(
            say=(lambda text: say(f"{name}: {text}")) if say and name else say,
            trace=Trace(hide={str(self._images): "<images>", **_portable_names(mission)}),
            goal_seed=self.seed_text,
            has_controls=self._options.has_tools,
            has_presence=False,
            why_rejected=self._why_rejected,
            signals=partial(StageSignals, robot=self.robot),
            read_revision=(
                partial(read_revision, place=self.robot.physics.world)
                if self._options.editable
                else None
            ),
        )
        node = NodeOptions(
            namespace=name or None,
            context=self._context,
            lean=True,
            has_parameters=self._options.visible,
        )
        self.node = StageMissionNode(mission, options, node=node)
        self.runner = self.node.runner
        self.runner.revising.subscribe(self._offer_for)
        if options.has_controls:
            relay = RobotRelay(self.node, self.snapshot)
            self.executive.after_tick.append(relay.flush)

    @property
    def seed_text(self) -> str:
        """The mission's seed, with the robot's name if it has one: equal seeds draw differently."""
        return f"{self.member.mission.seed} {self.name}".rstrip()

    def live_with(self, nature: Mapping[str, float]) -> None:
        """Apply the drawn nature of the robot; without one nothing changes."""
        self.nature = nature
        if nature:
            self.robot.live_with(nature)

    @override
    def snapshot(self) -> RobotSnapshot:
        robot = self.robot
        spec, battery = robot.robot.lidar, robot.battery
        return RobotSnapshot(
            time_ns=self.runner.now_ns,
            pose=robot.pose,
            lidar=(spec.x, spec.y, math.radians(spec.yaw)),
            ranges=robot.look_around(),
            reach=(spec.min_range, spec.max_range),
            charge=battery.percentage,
            voltage=battery.voltage,
        )

    @property
    def collisions(self) -> int:
        """The number of collisions of the robot."""
        return self.robot.collisions

    @property
    def distance_travelled_m(self) -> float:
        """The true length of the robot's path, m."""
        return self.robot.distance_travelled

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Servers and mapper, as far as they are there."""
        return tuple(node for node in (self.servers, self.mapper) if node is not None)

    def offer_all(self) -> None:
        """Offer also the actions that the mission does not use."""
        self._offers_all = True
        if self.has_servers:
            self.servers.offer_all()

    def replace_servers(self) -> None:
        """Start action servers without earlier goals, after the first were killed."""
        self.servers = self._make_servers()
        self.has_servers = True

    def record_pose(self, now_ns: int) -> bool:
        """Write its pose into the trace after each control step; return whether it is finite."""
        executive = self.executive
        if executive.cycles == self._cycles:
            return True
        self._cycles = executive.cycles
        x, y, yaw = self.robot.pose
        executive.events.emit(PoseSampled(now_ns, x, y, yaw, self.robot.collisions))
        return math.isfinite(x + y + yaw)

    def destroy(self) -> None:
        """Take its servers and its mapper off the graph."""
        if self.mapper is not None:
            self.mapper.destroy_node()
        if self.has_servers:
            self.servers.destroy_node()

    def _why_rejected(self, action: str) -> str | None:
        servers = self.servers
        return servers.why_rejected(action) if action in servers.actions else None

    def _offer_for(self, mission: Mission) -> None:
        """Offer all actions if a revision uses others than the mission did at its start."""
        if not self._offers_all and not _actions_of(mission) <= _actions_of(self.member.mission):
            self.offer_all()

    def _at_first(self) -> set[str] | None:
        """Return the actions to offer for now, by their relative names; None is all."""
        if self._offers_all:
            return None
        return _actions_of(self.member.mission)


def _actions_of(mission: Mission) -> set[str]:
    steps = all_steps(mission)
    return {step.ros_name.strip("/") for step in steps if isinstance(step, GoalNode)}
