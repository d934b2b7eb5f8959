"""The stage: world, servers and executive in one process on one virtual clock.

This is the one module that connects the three. They communicate through real rclpy and DDS, as
between processes; only the clock is virtual.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import chain, count
from pathlib import Path

import rclpy
from rclpy.node import Node

from action_servers.mapping.node import MapperNode
from action_servers.server.node import ServersNode
from bt_mission.base.clock_watch import ClockWatch, Interrupted, LeftError, refuse_leaving
from bt_mission.base.dds.discovery import isolate
from bt_mission.base.errors import BtMissionError, callback_failure, cause_of
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.language.mission import Mission
from bt_mission.language.trees import has_python
from bt_mission.programs import ProgramHost
from bt_mission.programs.goals import ObservedGoal
from bt_mission.programs.mains import MainProgram, WholeProgram
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.ros.executors.action_endpoints import duplicate_servers
from bt_mission.ros.graph import ProcessNode, SharedContext, as_default
from bt_mission.ros.observable_publisher import ObservableNode
from bt_mission.ros.virtual_time import DiscoveryError, VirtualTimeExecutor, self_test
from bt_mission.sessions import stage_nature
from bt_mission.sessions.own_nodes import OwnNodes, imported
from bt_mission.sessions.session import Session
from bt_mission.sessions.stage_files import StageFiles, stage_facts
from bt_mission.sessions.stage_nodes import StageSimNode
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions, StageRun
from sim.physics.simulator import SimulatorError
from sim.physics.spawn import RobotSpawn, RobotSpawnError
from sim.robot.fit import SpawnError
from sim.ros.node import SimNode, SimOptions
from sim.world.world import Spawn, World

START_NS = 1_000_000_000
MOST_RAISED = 200
"""Exceptions of callbacks after which a stage ends, since its time may not move."""

RAISED_S = 30.0
"""Wall time after the first one at which a stage ends with the next one, s."""


class StageError(BtMissionError):
    """The stage cannot continue."""

    code = "BT-903"


def free_folder(parent: Path) -> Path:
    """Return the first of ``run_001``, ``run_002``, ... that does not exist; it is not created.

    Raises:
        StageError: The working folder does not exist.
    """
    try:
        parent = parent.expanduser().resolve()
    except FileNotFoundError as error:
        raise StageError("the working folder has been deleted; change to another") from error
    return next(path for n in count(1) if not (path := parent / f"run_{n:03d}").exists())


class Stage(Session):
    """A world with a robot, its action servers, and the executive of one mission; or with several.

    Where a mission does not know its map, a mapper is there too, and the world publishes none.
    Of the actions, those of the mission are offered, and all once somebody else may ask for them:
    the servers that nobody asks would take a twelfth of the time.

    All random values derive from seeds.

    Args:
        mission: The mission of a robot alone; it names world, robot and seed.
        robots: Instead of a mission: robots with names, in the order in which they are served.
            Relative names of a mission lie in the namespace of its robot.
        image_folder: Where this run makes a folder of its own for pictures, if it takes any.
        say: Where ``log`` nodes speak to, of several robots with the name before each line; None
            is the ROS log.
        options: See :class:`StageOptions`.

    Raises:
        BtMissionError: For a world, robot or action type that is not there, for robots that do not
            fit, and where this machine cannot keep virtual time.
    """

    is_stepping = False
    is_broken = False
    """Whether an interrupt has left a step in the middle: no step follows it."""

    _since_raised: Stopwatch | None = None

    def __init__(
        self,
        mission: Mission | None = None,
        *,
        robots: Sequence[FleetRobot] = (),
        image_folder: Path,
        say: Callable[[str], None] | None = None,
        options: StageOptions | None = None,
    ) -> None:
        super().__init__()
        members = _members(mission, robots)
        self._options = options or StageOptions()
        self._host: ProgramHost | None = None
        self._started = 0
        own_seed = members[0].mission.seed
        self._seed = own_seed if self._options.seed is None else self._options.seed
        isolate(visible=self._options.visible, network=self._options.network)
        files = StageFiles.find(members, self._options)
        world = files.world
        if self._options.start is not None:
            x, y, yaw = self._options.start
            world = world.model_copy(update={"spawn": Spawn(x=x, y=y, yaw=yaw)})
        models = [load_robot(source) for source in files.robots]
        self._natures = stage_nature.natures(members, self._options, world)
        self_test()
        self.image_folder: Path = free_folder(image_folder)
        self.runs: tuple[StageRun, ...] = ()
        with ExitStack() as made, self._named_holder():
            if self._options.context is not None:
                self.context = self._options.context
            else:
                self.context = SharedContext()
                rclpy.init(context=self.context)
                made.callback(self.context.shutdown)
            self.clock = VirtualTimeExecutor(start_ns=START_NS, context=self.context)
            if _has_users_code(members, self._options):
                made.callback(self._begin_watch().close)
            self.sim = self.clock.world = self._make_sim(world, members, models)
            made.callback(self.sim.destroy_node)
            own = self._own = self._make_own(members, made)
            self.runs = self._make_runs(members, say, own.actions, made)
            for run in self.runs:
                run.executive.started_ns = START_NS
                run.executive.flaws = self._flaws
            made.callback(self.clock.shutdown)
            stage_nature.delay(self.clock, self.runs, self._seed)
            self.clock.add_node(self.sim)
            servers = [*chain(*(run.nodes for run in self.runs))]
            executives = [run.node for run in self.runs]
            own.refuse_names_of((self.sim, *servers, *executives))
            self._serve_all(servers, own, executives)
            self._exit = made.pop_all()
        self.world: str = world.name
        self.facts["world"] = world.name
        self.facts |= stage_facts(members, self._options, self._natures)
        self.files = files.contents
        self._raised = 0
        self.guests: list[str] = []
        """Names of the nodes that others have added."""
        for run, model in zip(self.runs, models, strict=True):
            run.executive.announce(START_NS, world.name, model.name, run.member.mission.seed)

    def _make_sim(
        self, world: World, members: Sequence[FleetRobot], models: Sequence[RobotModel]
    ) -> SimNode:
        """Make the simulator; a start without space is moved towards the nominal start."""
        *shares, last = stage_nature.SHARES if any(self._natures) else (1.0,)
        for share in shares:
            with suppress(SpawnError, RobotSpawnError):
                return self._sim_with(share, world, members, models)
        return self._sim_with(last, world, members, models)

    def _sim_with(
        self,
        share: float,
        world: World,
        members: Sequence[FleetRobot],
        models: Sequence[RobotModel],
    ) -> SimNode:
        """Make the simulator with a share of the offsets that nature gives the starts."""
        chosen = self._options.simulator
        made = StageSimNode(
            world,
            [
                RobotSpawn(
                    model, member.name, stage_nature.moved(member.start_in(world), nature, share)
                )
                for member, model, nature in zip(members, models, self._natures, strict=True)
            ],
            SimOptions(
                seed=self._seed,
                start_ns=START_NS,
                lean=True,
                command_type=self._options.command_type,
                has_parameters=self._options.visible,
                context=self.context,
                with_map=members[0].mission.map == "known",
                props=self._options.props,
                simulator=None if chosen is None else imported(chosen),
                places=_places_of(members),
            ),
        )
        for nature in filter(None, self._natures):
            nature.update({name: share * nature[name] for name in stage_nature.STARTS})
        return made

    def _make_own(self, members: Sequence[FleetRobot], made: ExitStack) -> OwnNodes:
        """Make the nodes of the user, which may wait meanwhile."""
        named = (*self._options.nodes, *self._options.programs)
        if named or any(robot.mission.nodes for robot in members):
            self._host = ProgramHost(self.clock, START_NS)
        return OwnNodes(
            self._options.nodes,
            members,
            self.context,
            made,
            self._host,
            self._seed,
            self._options.programs,
        )

    def _serve_all(
        self, servers: Sequence[Node], own: OwnNodes, executives: Sequence[Node]
    ) -> None:
        """Have all nodes served, in this order."""
        for node in servers:
            self.clock.add_node(node)
        own.serve()
        for node in executives:
            self.clock.add_node(node)
        for run in self.runs:
            if (why := duplicate_servers(run.node, sorted(own.actions))) is not None:
                raise StageError(why, code="BT-914")

    def _make_runs(
        self,
        members: Sequence[FleetRobot],
        say: Callable[[str], None] | None,
        offered: Collection[str],
        made: ExitStack,
    ) -> tuple[StageRun, ...]:
        """Make the servers of every robot, then every executive."""
        runs = []
        for member, robot, nature in zip(members, self.sim.robots, self._natures, strict=True):
            run = StageRun(member, robot, self.context, self.image_folder, self._options, offered)
            run.live_with(nature)
            made.callback(run.destroy)
            runs.append(run)
        for run in runs:
            run.make_executive(say)
            made.callback(run.node.destroy_node)
        return tuple(runs)

    def __getitem__(self, name: str) -> StageRun:
        """Return the robot of that name. Raises KeyError."""
        return {run.name: run for run in self.runs}[name]

    @property
    def seed(self) -> int:
        """The seed of all sensor noise."""
        return self._seed

    @property
    def servers(self) -> ServersNode:
        """The action servers."""
        return self.runs[0].servers

    @property
    def mapper(self) -> MapperNode | None:
        """The mapper, if the mission has no map."""
        return self.runs[0].mapper

    @property
    def now_ns(self) -> int:
        """The present instant of virtual time, ns; runs start at one second."""
        return self.clock.now_ns

    @property
    def start_ns(self) -> int:
        """Virtual time of the start, ns."""
        return START_NS

    def add_node(self, node: Node) -> None:
        """Serve a node of the caller on the clock of the stage; its owner destroys it."""
        self.offer_all()
        self.watch_users()
        self.guests.append(node.get_name())
        self.clock.add_node(node)
        self._exit.callback(self.clock.remove_node, node)

    def watch_users(self) -> None:
        """Watch for code of users that holds the clock, from now on."""
        if self.watch is None:
            self._exit.callback(self._begin_watch().close)

    def _begin_watch(self) -> ClockWatch:
        limit_s = self._options.hold_limit_s
        self.watch = ClockWatch(self._progress, is_virtual=True, limit_s=limit_s)
        self.watch.last_words.append(self.leave)
        return self.watch

    def start_program(self, whole: WholeProgram) -> MainProgram:
        """Start a program beside the missions; return it once it waits.

        Raises:
            BtMissionError: It computes for too long before it waits.
            StageError: It offers an action that is offered already.
        """
        self.watch_users()
        if self._host is None:
            self._host = ProgramHost(self.clock, START_NS)
            self._exit.callback(self._host.close)
        self._started += 1
        started = self._own.start(self._host, whole, f"{self._seed}/program {self._started} later")
        self.offer_all()
        with as_default(self.context):
            self.clock.run_until_quiet()
        for run in self.runs:
            if (why := duplicate_servers(run.node, sorted(self._own.actions))) is not None:
                hint = "run the mission without ours: stage.run(..., without=[name])"
                raise StageError(f"{why}; {hint}", code="BT-914")
        return started

    def interrupt_program(self, program: MainProgram) -> None:
        """Send SIGINT to a program, and serve what follows at this instant."""
        if self._host is not None:
            with as_default(self.context):
                self._host.interrupt(program)
                self.clock.run_until_quiet()

    def interrupt_programs(self) -> None:
        """Send SIGINT to all programs that run."""
        for program in self._own.programs:
            if program.exit_code is None:
                self.interrupt_program(program)

    @property
    def served_goals(self) -> Sequence[ObservedGoal]:
        """The goals that action servers have got since there are programs, in their order."""
        return () if self._host is None else self._host.goals.all

    @property
    def program_warnings(self) -> Sequence[str]:
        """The warnings of programs' nodes about their threads, messages and clocks."""
        return () if self._host is None else self._host.remarks.warnings

    def has_idle_programs(self, *, only_serve: bool) -> bool:
        """Return whether no program will do anything unless another one asks for it.

        Args:
            only_serve: Programs with servers keep the messages that they get for requests.
        """
        return self._host is None or self._host.is_idle(only_serves=only_serve)

    def _progress(self) -> int:
        resumed = 0 if self._host is None else self._host.switches
        return self.clock.callbacks_served + resumed

    def _flaws(self) -> Sequence[str]:
        held = () if self.watch is None else self.watch.flaws
        return (*held, *self._own.flaws())

    @contextmanager
    def _named_holder(self) -> Iterator[None]:
        """Name the code of a user that was interrupted while the stage was made."""
        try:
            yield
        except Interrupted:
            overrun = self.watch.take_overrun() if self.watch else None
            raise overrun or KeyboardInterrupt from None

    def make_node(self, name: str) -> Node:
        """A bare node that takes part, and goes with the stage."""
        node = ObservableNode(
            name, context=self.context, enable_rosout=False, start_parameter_services=False
        )
        self._exit.callback(node.destroy_node)
        self.add_node(node)
        return node

    def offer_all(self) -> None:
        """Offer also the actions that the missions do not use."""
        for run in self.runs:
            run.offer_all()

    def kill_servers(self, run: StageRun) -> None:
        """Have a robot's action servers leave the graph at once, as a process that is killed."""
        if run.has_servers:
            run.has_servers = False
            self.clock.remove_node(run.servers)
            run.servers.vanish()

    def start_servers(self, run: StageRun) -> None:
        """Start a robot's servers again, after the first were killed, without earlier goals."""
        if not run.has_servers:
            run.replace_servers()
            self.clock.add_node(run.servers)

    def step(self) -> None:
        """Jump to the next instant at which anything is due, and serve it.

        An exception in a callback ends every mission that runs as failed with the cause. Further
        ones do not keep goals from their end.

        Raises:
            StageError: After :data:`MOST_RAISED` exceptions or :data:`RAISED_S`, after one when
                all missions have ended, and for a simulation that became unstable.
            SimulatorError: Another simulator does not do what it has to do.
        """
        self.is_stepping = True
        try:
            if self.watch is None:
                self.clock.step()
            else:
                with as_default(self.context):
                    self.clock.step()
        except (SimulatorError, DiscoveryError):
            raise
        except Exception as error:  # noqa: BLE001 - callbacks are others', too
            self._end_by(error)
        except Interrupted:
            if self.watch is not None and (overrun := self.watch.take_overrun()) is not None:
                self._end_by(overrun)
        except BaseException as error:  # noqa: BLE001 - an interrupt is raised again
            self._end_by_leaving(error)
        finally:
            self.is_stepping = False
        for run in self.runs:
            if not run.record_pose(self.clock.now_ns):
                raise StageError("the simulation became unstable: the robot's pose is not finite")
        self._call_onlookers()

    def _end_by_leaving(self, error: BaseException) -> None:
        """End the missions as failed where a user's code would end the process."""
        try:
            refuse_leaving(error)
        except LeftError as error_of_user:
            self._end_by(error_of_user)
        else:
            self.is_broken = True
            raise error

    def _end_by(self, error: Exception) -> None:
        if self.is_done:
            raise StageError(f"a callback failed after the mission: {cause_of(error)}") from error
        self._raised += 1
        since = self._since_raised = self._since_raised or Stopwatch()
        if self._raised > MOST_RAISED or since.elapsed_s > RAISED_S:
            raise StageError(
                f"{self._raised} callbacks failed in {since.elapsed_s:.0f} s of wall time, the "
                f"last one with {cause_of(error)}"
            ) from error
        for run in self.runs:
            run.executive.fail(callback_failure(error))

    def inside(self) -> Iterator[ProcessNode]:
        """The nodes of the stage."""
        for node in self.clock.get_nodes():
            yield ProcessNode(node, is_sensor=node is self.sim)

    def _call_onlookers(self) -> None:
        for onlooker in tuple(self._onlookers):
            try:
                onlooker.after_step()
            except Exception as error:
                if not onlooker.acts:
                    raise
                self._onlookers.remove(onlooker)
                self._end_by(error)


def _has_users_code(members: Sequence[FleetRobot], options: StageOptions) -> bool:
    """Return whether code of users takes part, or may do so after a revision."""
    is_named = any(robot.mission.nodes or has_python(robot.mission) for robot in members)
    return bool(
        is_named or options.nodes or options.programs or options.simulator or options.editable
    )


def _places_of(members: Sequence[FleetRobot]) -> dict[str, tuple[float, float]]:
    """Return the named places of the missions; two robots may use one name for two places."""
    return {name: (x, y) for member in members for name, (x, y, _) in member.mission.places.items()}


def _members(mission: Mission | None, robots: Sequence[FleetRobot]) -> Sequence[FleetRobot]:
    """Return the robots of a stage: one without a name, or all with one."""
    if (mission is None) == (not robots):
        raise StageError("expected either a mission, or robots with a mission each")
    if mission is not None:
        return (FleetRobot("", mission),)
    for robot in robots:
        if not robot.name and len(robots) > 1:
            raise StageError("expected a name for each robot: its names lie in that namespace")
        if robot.mission.map == "unknown":
            raise StageError(f"{robot.name}: a fleet has no mapper, so 'map: unknown' cannot run")
    return robots
