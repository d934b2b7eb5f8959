"""Whether the simulation runs: played, paused, moved on by some steps, stopped, ended.

Pure of ROS. Whoever paces the simulation asks `RunControl` to move on, instead of the node.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Protocol

from sim.physics.names import STEP_NS


class RunState(IntEnum):
    """The state of a simulation; numbers as in simulation_interfaces/SimulationState."""

    STOPPED = 0
    PLAYING = 1
    PAUSED = 2
    QUITTING = 3


class SteppedNode(Protocol):
    """The simulation that is controlled: its time goes on in steps of the physics."""

    @property
    def time_ns(self) -> int:
        """The present instant of the physics, ns."""

    def advance_to(self, time_ns: int) -> None:
        """Step the physics up to `time_ns`, and publish what is due."""


class StepRun:
    """Steps that were asked for.

    Args:
        wanted: How many.
        on_step: Told after each, with how many are done.
        on_end: Called once, when all are done or when they are given up.
    """

    def __init__(
        self, wanted: int, on_step: Callable[[int], None], on_end: Callable[[], None]
    ) -> None:
        self.wanted = wanted
        self.done = 0
        self.given_up = ""
        """Why not all were done; empty where they were."""
        self._on_step, self._on_end = on_step, on_end

    def count(self) -> None:
        """Count a step."""
        self.done += 1
        self._on_step(self.done)

    def end(self, given_up: str = "") -> None:
        """Say that no more are done."""
        self.given_up = given_up
        self._on_end()


class RunControl:
    """Lets a simulation run, stand, or move on by some steps. It runs at first."""

    def __init__(self, node: SteppedNode) -> None:
        self._node = node
        self._state = RunState.PLAYING
        self._steps: StepRun | None = None

    @property
    def state(self) -> RunState:
        """The state; while steps are done it is that of a simulation that is played."""
        return RunState.PLAYING if self._steps is not None else self._state

    @property
    def is_running(self) -> bool:
        """Whether time goes on."""
        return self.state is RunState.PLAYING

    def set_state(self, state: RunState) -> None:
        """Be in a state from now on; steps under way are given up."""
        self._state = state
        self.give_up_steps(f"the simulation is {state.name.lower()} now")

    def start_steps(self, steps: StepRun) -> None:
        """Move a paused simulation on by some steps, at the pace of a played one."""
        self._steps = steps

    def give_up_steps(self, why: str) -> None:
        """End steps under way, if there are any."""
        steps, self._steps = self._steps, None
        if steps is not None:
            steps.end(why)

    def advance_to(self, time_ns: int) -> None:
        """Go on to `time_ns` at most, as far as the state has it."""
        if self._steps is None:
            if self._state is RunState.PLAYING:
                self._node.advance_to(time_ns)
            return
        while (steps := self._steps) is not None and self._node.time_ns + STEP_NS <= time_ns:
            self._node.advance_to(self._node.time_ns + STEP_NS)
            steps.count()
            if steps.done == steps.wanted and steps is self._steps:
                self._steps = None
                steps.end()
