"""The one MuJoCo model of a simulation, and its time.

Pure: no ROS and no wall clock. Time is counted in nanoseconds and moves in steps of 5 ms.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np

from bt_mission.base.errors import BtMissionError
from sim.physics import spawn as entrants_
from sim.physics.body import add_robot, add_screen
from sim.physics.history import SimulationState
from sim.physics.names import (
    FLOOR_CONTACTS,
    LOOSE_PREFIX,
    MOVER_PREFIX,
    OBSTACLE_PREFIX,
    PROP_PREFIX,
    ROBOT_BIT,
    STEP_NS,
)
from sim.physics.prop_bodies import add_bodies, bodies_of, check_count, keep_figures
from sim.physics.props import Props
from sim.physics.scenery import add_world
from sim.physics.simulator import TOUCHING_M, FollowedSimulator, SimulatorFactory
from sim.physics.spawn import RobotSpawn
from sim.physics.wheels import Grip
from sim.world.world import World

_SETTLING_STEPS = 40

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION.value

SCREEN_COLOURS = ("purple", "orange", "brown", "black", "grey", "white")

_OVER = 0.03
"""The height in metres of a robot's screen above the highest lidar."""


_MOST_KEPT = 8
"""Compiled models, 0.4 MB each."""

_compiled: dict[str, mujoco.MjModel] = {}


def compile_model(world: World, entrants: Sequence[RobotSpawn], props: int = 0) -> mujoco.MjModel:
    """Return the compiled model with each robot at its start. `props`: spare bodies.

    A model that this process has compiled before is copied, in a sixth of the time.
    """
    if any(entrant.robot.model is not None for entrant in entrants):
        return _compile(world, entrants, props)  # its files may have changed
    written = repr((world, tuple(entrants), props))  # distinguishes 0.0 from -0.0, unlike equality
    model = _compiled.get(written)
    if model is None:
        model = _compiled[written] = _compile(world, entrants, props)
        if len(_compiled) > _MOST_KEPT:
            del _compiled[next(iter(_compiled))]
    return copy.copy(model)


def _compile(world: World, entrants: Sequence[RobotSpawn], props: int) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.modelname = world.name
    spec.option.timestep = STEP_NS / 1e9
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # So odometry is off by 0.16 mm in 2 m; with elliptic cones or impratio 1, by 1.6 mm.
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.option.impratio = 10.0
    spec.visual.global_.offwidth = spec.visual.global_.offheight = 1
    add_world(spec, world)
    several = len(entrants) > 1
    lidars = max(entrant.robot.base_height + entrant.robot.lidar.z for entrant in entrants)
    for index, entrant in enumerate(entrants):
        spawn, contype = entrant.spawn or world.spawn, ROBOT_BIT if several else 0
        base = add_robot(spec, entrant, spawn, group=index, contype=contype)
        if several:
            colour = SCREEN_COLOURS[index % len(SCREEN_COLOURS)]
            add_screen(base, entrant.robot, lidars + _OVER, colour)
    model = spec.compile()
    if not props:
        return model
    add_bodies(spec, props)
    spare = spec.compile()
    keep_figures(spare, model)
    return spare


class UnstableError(BtMissionError):
    """Forces have grown beyond what a step of the physics can follow."""

    code = "BT-809"


class Movers:
    """Moves every moving obstacle: its place is a function of time alone.

    Each slides on two joints, x and y, and is put in its place with its velocity before every step
    of the physics. So a contact knows its speed; a mocap body would have no velocity. It weighs a
    ton, so that a robot does not stop it within a step.
    """

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        self._each = []
        for obstacle in world.moving:
            assert obstacle.motion is not None
            joint = model.joint(f"{MOVER_PREFIX}{obstacle.name}/x")
            home = obstacle.motion.at(0.0)
            self._each.append(
                (int(joint.qposadr[0]), int(joint.dofadr[0]), obstacle.motion.at, *home[:2])
            )

    def place(self, data: mujoco.MjData, time_ns: int) -> None:
        """Set positions and velocities to those at this time after the start."""
        qpos, qvel, time_s = data.qpos, data.qvel, time_ns / 1e9
        for q, v, at, x_0, y_0 in self._each:
            x, y, vx, vy = at(time_s)
            qpos[q], qpos[q + 1] = x - x_0, y - y_0
            qvel[v], qvel[v + 1] = vx, vy


class Controlled(Protocol):
    """The controller of a base: the time of its next command to the wheels."""

    due_ns: float


@dataclass(frozen=True, slots=True)
class StepHooks:
    """What is called at a step of the physics: before it, with its beginning in ns, and after it.

    Before it only while something is `acting`, or from the time on at which the controller is due.
    """

    before: Callable[[int], None]
    after: Callable[[], None]
    controller: Controlled
    acting: Sequence[Any]


class Moved(Protocol):
    """A robot that the physics moves, and calls at every step."""

    def step_hooks(self) -> StepHooks:
        """Return the functions to call at each step.

        Called after every restart, and when the robot was put elsewhere.
        """

    def look_for_collisions(self, now_ns: int) -> None:
        """Note new contacts; called after each step with any contact."""

    def restart(self) -> None:
        """Be as at the start: time begins, or the state has been put back."""

    @property
    def commanded(self) -> tuple[float, float]:
        """The velocity that it commands to its wheels, m/s and rad/s."""


class Physics:
    """Model, state and time of a world with robots in it.

    `begin` sets the robots, once the springs of their wheels are at rest. `props` is the number of
    obstacles that can be placed later. With `simulator`, that one moves the robot.
    """

    def __init__(
        self,
        world: World,
        entrants: Sequence[RobotSpawn],
        start_ns: int,
        props: int = 0,
        simulator: SimulatorFactory | None = None,
        seed: int = 0,
    ) -> None:
        entrants_.check(entrants)
        check_count(props)
        self.world = world
        self.time_ns = start_ns
        self.model = compile_model(world, entrants, props)
        self.names, bodies = bodies_of(self.model)
        """The reported name of each geom."""
        self.prefixes = tuple(entrant.prefix for entrant in entrants)
        """The prefix of the names of each robot's parts."""
        self.robot_names = tuple(entrant.name for entrant in entrants)
        self.obstacle_geoms = tuple(
            geom
            for geom in range(self.model.ngeom)
            if self.model.geom(geom).name.startswith((OBSTACLE_PREFIX, PROP_PREFIX))
        )
        self.data = mujoco.MjData(self.model)
        sensor = int(self.model.sensor(FLOOR_CONTACTS).adr[0])
        self._on_floor = self.data.sensordata[sensor : sensor + 1]
        self._epoch_ns = start_ns
        self._robots: tuple[Moved, ...] = ()
        self._entrants = tuple(entrants)
        self._make_simulator, self._seed = simulator, seed
        self.has_simulator = simulator is not None
        """Whether another simulator moves the robot."""
        self.simulator: FollowedSimulator | None = None
        """Moves the robot in place of MuJoCo, from `begin` on."""
        self._hooks: list[StepHooks] = []
        self._movers = Movers(self.model, world) if world.moving else None
        self.grip = Grip(self.model, world)
        self.props = Props(self, bodies)
        """Obstacles that appear, move and vanish."""
        self._place(self.time_ns)
        mujoco.mj_forward(self.model, self.data)
        self._at_start = np.empty(mujoco.mj_stateSize(self.model, _STATE))

    def begin(self, robots: Sequence[Moved]) -> None:
        """Let the springs of wheels and casters settle, and start time."""
        model, data = self.model, self.data
        data.qvel[:] = 0.0
        mujoco.mj_step(model, data, nstep=_SETTLING_STEPS)
        data.qvel[:] = 0.0
        self._place(self.time_ns)
        mujoco.mj_getState(model, data, self._at_start, _STATE)
        self._robots = tuple(robots)
        if self._make_simulator is not None:
            self.simulator = FollowedSimulator(
                self._make_simulator, self.world, self._entrants, self._seed
            )
            self.simulator.follow(data, lambda: robots[0].commanded)
            # Its contacts may leave no overlap.
            self.model.geom_margin[list(self.obstacle_geoms)] = TOUCHING_M
        self._restart()

    def reset(self, *, keep_props: bool = False) -> list[str]:
        """Restore the state at the start. Time continues.

        Props vanish; with `keep_props` each stands where it was placed, except for those whose
        place is occupied. Returns the names of those.
        """
        if not keep_props:
            self.props.clear()
        mujoco.mj_setState(self.model, self.data, self._at_start, _STATE)
        removed = self.props.put_back()
        self._epoch_ns = self.time_ns
        self._restart()
        return removed

    @property
    def objects(self) -> dict[str, tuple[float, float, float]]:
        """The places of loose objects in the map, m: of their middles, by their names."""
        places = {}
        for loose in self.world.objects:
            x, y, z = self.data.body(LOOSE_PREFIX + loose.name).xpos.tolist()
            places[loose.name] = (x, y, z)
        return places

    @property
    def running_s(self) -> float:
        """Time since the start, or since the last reset, s."""
        return (self.time_ns - self._epoch_ns) / 1e9

    @property
    def is_touching(self) -> bool:
        """Whether a robot touches anything but the floor."""
        return bool(self.data.ncon > self._on_floor[0])

    def put_in_place(self) -> None:
        """Compute again what follows from all poses."""
        mujoco.mj_forward(self.model, self.data)

    def ask_hooks(self) -> None:
        """Ask the robots for their step hooks again."""
        self._hooks = [robot.step_hooks() for robot in self._robots]

    def _restart(self) -> None:
        if self.simulator is not None:
            self.simulator.restart()
        for robot in self._robots:
            robot.restart()
        self.ask_hooks()
        self.put_in_place()

    def advance_to(self, time_ns: int) -> None:
        """Step up to `time_ns`, a whole number of steps from now.

        Raises ValueError where that time is past, or lies between two steps, and UnstableError.
        """
        steps, rest = divmod(time_ns - self.time_ns, STEP_NS)
        if steps < 0 or rest:
            raise ValueError(
                f"cannot advance from {self.time_ns} ns to {time_ns} ns: expected a later time,"
                f" a multiple of {STEP_NS} ns away"
            )
        model, data = self.model, self.data
        step = mujoco.mj_step if self.simulator is None else self.simulator.step
        grip = self.grip if self.world.slippery else None
        moves = self._movers is not None or bool(self.props.placed)
        robots, on_floor = self._hooks, self._on_floor
        began = data.time
        for now in range(self.time_ns, time_ns, STEP_NS):
            if moves:
                self._place(now)
            if grip is not None:
                grip.apply(data)
            for hooks in robots:
                if hooks.acting or now >= hooks.controller.due_ns:
                    hooks.before(now)
            step(model, data)
            for hooks in robots:
                hooks.after()
            if data.ncon > on_floor[0]:  # what is not the floor's is of a robot
                self._look_for_collisions(now)
        self.time_ns = time_ns
        if steps:
            self._check_stable(data.time - began, steps)
            self._place(time_ns)
            # What was computed within a step is that of its beginning.
            mujoco.mj_kinematics(model, data)

    def _look_for_collisions(self, now_ns: int) -> None:
        for robot in self._robots:
            robot.look_for_collisions(now_ns)

    def _check_stable(self, passed_s: float, steps: int) -> None:
        # MuJoCo has put all to its start, and its time to 0, where numbers grew out of bounds.
        if passed_s < (steps - 0.5) * STEP_NS / 1e9:
            raise UnstableError(
                f"the physics became unstable before {self.time_ns / 1e9:.3f} s: forces are too"
                " large, or a robot is deep inside of something"
            )

    def record(self) -> SimulationState:
        """Return the present state, to be evaluated later (`sim.physics.history`)."""
        data = self.data
        return SimulationState(
            self.time_ns, data.qpos.tobytes(), data.qvel.tobytes(), self.props.shown
        )

    def _place(self, time_ns: int) -> None:
        if self._movers is not None:
            self._movers.place(self.data, time_ns - self._epoch_ns)
        if self.props.placed:
            self.props.move(self.data, time_ns)
