"""A simulation with the standard services of simulators, paced by a virtual clock."""

from typing import Any

import pytest
from simulation_interfaces import srv

from sim.physics.names import STEP_NS
from sim.ros.live import offer_standard_services
from sim.ros.run_control import RunControl

NEVER = 2**62


class Paced:
    """Moves a simulation on with its executor's clock, which stands for the wall clock."""

    def __init__(self, node: Any, control: RunControl) -> None:
        self._node, self._control = node, control
        self._now_ns = node.time_ns

    @property
    def next_due_ns(self) -> int:
        """The next step of the physics."""
        return self._now_ns + STEP_NS if self._control.is_running else NEVER

    def advance_to(self, time_ns: int) -> None:
        """Let as much time pass in the simulation, as far as it runs."""
        passed_ns, self._now_ns = time_ns - self._now_ns, time_ns
        self._control.advance_to(self._node.time_ns + passed_ns)


class Simulator:
    """A simulation, and somebody who asks it."""

    def __init__(self, stage: Any, source: str) -> None:
        self.stage, self.node = stage, stage.sim
        self.control = RunControl(self.node)
        offer_standard_services(self.node, self.control, source)
        stage.clock.world = Paced(self.node, self.control)

    def begin(self, kind: str, **fields: Any) -> Any:
        """Send a request to a service, and return the future of its answer."""
        words = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in kind)
        kind_type = getattr(srv, kind)
        client = self.stage.ear.create_client(kind_type, f"/bt_mission_sim/{words[1:]}")
        future = client.call_async(kind_type.Request(**fields))
        self.stage.clock.run_until_quiet()
        return future

    def ask(self, kind: str, **fields: Any) -> Any:
        """Return a service's answer, which comes at once."""
        future = self.begin(kind, **fields)
        assert future.done()
        return future.result()

    def set_state(self, state: int) -> tuple[int, str]:
        """Ask for a state, and return how that went."""
        request = srv.SetSimulationState.Request()
        request.state.state = state
        return result_of(self.ask("SetSimulationState", state=request.state))

    @property
    def state(self) -> int:
        """The state that is result_of."""
        return int(self.ask("GetSimulationState").state.state)

    def wait(self, seconds: float) -> None:
        """Let time pass on the clock that paces the simulation."""
        self.stage.run(self.stage.clock.now_ns + round(seconds * 1e9))


def result_of(answer: Any) -> tuple[int, str]:
    """Return how a request went, and why."""
    return answer.result.result, answer.result.error_message


@pytest.fixture
def make_simulator(make_stage, make_world):
    """Makes a simulation with its services, in a wide empty world by default."""

    def make(
        *topics: str, source: str = "empty_arena", world: dict[str, Any] | None = None, **options
    ) -> Simulator:
        stage = make_stage(make_world(**(world or {})), *topics, props=4, **options)
        return Simulator(stage, source)

    return make
