"""The state of the simulation: playing, paused, advanced by some steps, stopped, ended.

The pacer of the simulation asks `RunControl` to advance, instead of the node.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

from sim.physics.names import STEP_NS
from sim.ros.node import SimNode


class RunState(IntEnum):
    """The state of a simulation; numbers as in simulation_interfaces/SimulationState."""

    STOPPED = 0
    PLAYING = 1
    PAUSED = 2
    QUITTING = 3


class StepRun:
    """Steps that were requested.

    Args:
        wanted: The number of steps.
        on_step: Called after each step with the number done.
        on_end: Called once, when all are done or given up.
    """

    def __init__(
        self, wanted: int, on_step: Callable[[int], None], on_end: Callable[[], None]
    ) -> None:
        self.wanted = wanted
        self.done = 0
        self.given_up = ""
        """Why not all were done; empty if they were."""
        self._on_step, self._on_end = on_step, on_end

    def count(self) -> None:
        """Count a step."""
        self.done += 1
        self._on_step(self.done)

    def end(self, given_up: str = "") -> None:
        """End the steps."""
        self.given_up = given_up
        self._on_end()


class RunControl:
    """Lets a simulation run, pause, or advance by some steps. It runs at first."""

    def __init__(self, node: SimNode) -> None:
        self._node = node
        self._state = RunState.PLAYING
        self._steps: StepRun | None = None

    @property
    def state(self) -> RunState:
        """The state; during steps it is that of a playing simulation."""
        return RunState.PLAYING if self._steps is not None else self._state

    @property
    def is_running(self) -> bool:
        """Whether time moves."""
        return self.state is RunState.PLAYING

    def set_state(self, state: RunState) -> None:
        """Set the state; steps under way are given up."""
        self._state = state
        self.give_up_steps(f"the simulation is {state.name.lower()} now")

    def start_steps(self, steps: StepRun) -> None:
        """Advance a paused simulation by some steps, at the pace of a playing one."""
        self._steps = steps

    def give_up_steps(self, why: str) -> None:
        """End steps under way, if there are any."""
        steps, self._steps = self._steps, None
        if steps is not None:
            steps.end(why)

    def advance_to(self, time_ns: int) -> None:
        """Advance to `time_ns` at most, as far as the state allows."""
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
