"""The one MuJoCo model that everything stands in, and its time.

Pure: no ROS and no wall clock. Time is counted in nanoseconds and moves in steps of 5 ms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import mujoco
import numpy as np

from bt_mission.core.errors import BtMissionError
from sim.physics import spawn as entrants_
from sim.physics.grip import Grip
from sim.physics.history import SimulationState
from sim.physics.model import compile_model
from sim.physics.movers import Movers
from sim.physics.names import OBSTACLE_PREFIX, PROP_PREFIX, STEP_NS
from sim.physics.prop_bodies import bodies_of
from sim.physics.props import Props, check_count
from sim.physics.spawn import RobotSpawn
from sim.world.world import World

_SETTLING_STEPS = 40

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION.value


class UnstableError(BtMissionError):
    """Forces have grown beyond what a step of the physics can follow."""


class Moved(Protocol):
    """What the physics moves and asks, at every step: a robot."""

    def step_hooks(self) -> tuple[Callable[[int], None], Callable[[int], None]]:
        """Return what is to be called before and after each step, with its beginning (ns).

        Asked for after every restart.
        """

    def restart(self) -> None:
        """Be as at the start: time begins, or the state has been put back."""


class Physics:
    """Model, state and time of a world with robots in it.

    `begin` hands over the robots, once the springs of their wheels have found their rest. `props`
    is how many obstacles can be placed later.
    """

    def __init__(
        self, world: World, entrants: Sequence[RobotSpawn], start_ns: int, props: int = 0
    ) -> None:
        entrants_.check(entrants)
        check_count(props)
        self.world = world
        self.time_ns = start_ns
        self.model = compile_model(world, entrants, props)
        self.names, bodies = bodies_of(self.model)
        """What each geom is reported as."""
        self.prefixes = tuple(entrant.prefix for entrant in entrants)
        """What stands before the names of each robot's parts."""
        self.robot_names = tuple(entrant.name for entrant in entrants)
        self.obstacle_geoms = tuple(
            geom
            for geom in range(self.model.ngeom)
            if self.model.geom(geom).name.startswith((OBSTACLE_PREFIX, PROP_PREFIX))
        )
        self.data = mujoco.MjData(self.model)
        self._epoch_ns = start_ns
        self._robots: tuple[Moved, ...] = ()
        self._hooks: list[tuple[Callable[[int], None], Callable[[int], None]]] = []
        self._movers = Movers(self.model, world) if world.moving else None
        self.grip = Grip(self.model, world)
        self.props = Props(self, bodies)
        """Obstacles that appear, move and vanish."""
        self._place()
        mujoco.mj_forward(self.model, self.data)
        self._at_start = np.empty(mujoco.mj_stateSize(self.model, _STATE))

    def begin(self, robots: Sequence[Moved]) -> None:
        """Let the springs of wheels and casters find their rest; time begins."""
        model, data = self.model, self.data
        data.qvel[:] = 0.0
        mujoco.mj_step(model, data, nstep=_SETTLING_STEPS)
        data.qvel[:] = 0.0
        self._place()
        mujoco.mj_getState(model, data, self._at_start, _STATE)
        self._robots = tuple(robots)
        self._restart()

    def reset(self) -> None:
        """Put everything back to its state at the start, without props. Time goes on."""
        self.props.clear()
        mujoco.mj_setState(self.model, self.data, self._at_start, _STATE)
        self._epoch_ns = self.time_ns
        self._restart()

    def _restart(self) -> None:
        for robot in self._robots:
            robot.restart()
        self._hooks = [robot.step_hooks() for robot in self._robots]
        mujoco.mj_forward(self.model, self.data)

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
        model, data, step = self.model, self.data, mujoco.mj_step
        movers, grip = self._movers, self.grip if self.world.slippery else None
        props = self.props or None
        robots = self._hooks
        began = data.time
        for now in range(self.time_ns, time_ns, STEP_NS):
            if movers is not None:
                movers.place(data, now - self._epoch_ns)
            if props is not None:
                props.move(data, now)
            if grip is not None:
                grip.apply(data)
            for before, _ in robots:
                before(now)
            step(model, data)
            for _, after in robots:
                after(now)
        self.time_ns = time_ns
        if steps:
            # MuJoCo has put all to its start, and its time to 0, where numbers grew out of bounds.
            if data.time - began < (steps - 0.5) * STEP_NS / 1e9:
                raise UnstableError(
                    f"the physics became unstable before {time_ns / 1e9:.3f} s: forces are too"
                    " large, or a robot is deep inside of something"
                )
            self._place()
            # What was computed within a step is that of its beginning.
            mujoco.mj_kinematics(model, data)

    def record(self) -> SimulationState:
        """Return what everything stands like now, to be looked at later (`sim.physics.history`)."""
        data = self.data
        return SimulationState(
            self.time_ns, data.qpos.tobytes(), data.qvel.tobytes(), self.props.shown
        )

    def _place(self) -> None:
        if self._movers is not None:
            self._movers.place(self.data, self.time_ns - self._epoch_ns)
        if self.props:
            self.props.move(self.data, self.time_ns)
