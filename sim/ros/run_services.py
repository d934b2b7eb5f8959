"""The standard services for the run of a simulation: its state, its steps, its reset, its features.

`simulation_interfaces` of ROS 2, with names of the node's own (`/bt_mission_sim/step_simulation`).
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from simulation_interfaces import action, srv

from bt_mission.base.ros_log import log_of
from sim.physics.names import STEP_NS
from sim.ros.node import SimNode
from sim.ros.requests import (
    Code,
    Feature,
    Offer,
    RefusedError,
    fill_result,
    offer,
    refuse_while_quitting,
    service_name,
)
from sim.ros.run_control import RunControl, RunState, StepRun
from sim.ros.topics import REQUESTS

MOST_STEPS = 200_000
"""The most steps of one call of the service, a thousand seconds; the action takes any number, as it
can be canceled.
"""

_RESULT_KEPT_S = 10


class Scope(IntFlag):
    """The scope of a reset: simulation_interfaces/ResetSimulation."""

    TIME = 1
    STATE = 2
    SPAWNED = 4
    ALL = 255


class Transition(IntEnum):
    """Why a state was not entered: simulation_interfaces/SetSimulationState."""

    ALREADY_IN_TARGET_STATE = 101
    INCORRECT_TRANSITION = 103


_PARTS = Scope.TIME | Scope.STATE | Scope.SPAWNED
_WORLDS = {4: "there is always a world here", 5: "worlds are loaded at the start only"}


class RunServices:
    """The services for state, steps and reset of a simulation.

    Args:
        node: The simulation.
        control: Controls the simulation.
    """

    def __init__(self, node: SimNode, control: RunControl) -> None:
        self._node = node
        self._control = control
        self.features = offer(node, control, srv, self._offers())
        waiting = ReentrantCallbackGroup()  # while steps are awaited, all else is served
        node.create_service(
            srv.StepSimulation,
            service_name("StepSimulation"),
            self._step,
            qos_profile=REQUESTS,
            callback_group=waiting,
        )
        self.features += [Feature.STEP_SIMULATION_SINGLE, Feature.STEP_SIMULATION_MULTIPLE]
        self._steps = ActionServer(
            node,
            action.SimulateSteps,
            node.resolve_service_name(service_name("SimulateSteps")),
            execute_callback=self._simulate_steps,
            cancel_callback=self._cancel_steps,
            callback_group=waiting,
            result_timeout=_RESULT_KEPT_S,
        )
        self.features.append(Feature.STEP_SIMULATION_ACTION)

    def _offers(self) -> tuple[Offer, ...]:
        return (
            Offer(
                "ResetSimulation",
                self._reset,
                (
                    Feature.SIMULATION_RESET,
                    Feature.SIMULATION_RESET_TIME,
                    Feature.SIMULATION_RESET_STATE,
                    Feature.SIMULATION_RESET_SPAWNED,
                ),
            ),
            Offer(
                "SetSimulationState",
                self._set_state,
                (Feature.SIMULATION_STATE_SETTING, Feature.SIMULATION_STATE_PAUSE),
            ),
        )

    def offer_always(self, features: list[Feature], about: str) -> None:
        """Offer the services of every state: the state, and the features of the simulator."""
        features = sorted({*features, Feature.SIMULATION_STATE_GETTING})

        def get_features(_: Any, response: Any) -> Any:
            response.features.features = [int(feature) for feature in features]
            response.features.spawn_formats = ["yaml"]
            response.features.custom_info = about
            return response

        def get_state(_: Any, response: Any) -> Any:
            response.state.state = int(self._control.state)
            fill_result(response.result, Code.OK)
            return response

        for kind, answer in (
            (srv.GetSimulatorFeatures, get_features),
            (srv.GetSimulationState, get_state),
        ):
            name = service_name(kind.__name__)
            self._node.create_service(kind, name, answer, qos_profile=REQUESTS)

    # ---- state and reset -----------------------------------------------------------------

    def _set_state(self, request: Any, _: Any) -> None:
        wanted, control = request.state.state, self._control
        if wanted in _WORLDS:
            text = f"cannot be set to state {wanted}: {_WORLDS[wanted]}"
            raise RefusedError(Transition.INCORRECT_TRANSITION, text)
        if wanted not in set(RunState):
            text = f"expected a state from 0 (stopped) to 3 (quitting), got {wanted}"
            raise RefusedError(Code.FEATURE_UNSUPPORTED, text)
        state = RunState(wanted)
        if state is control.state:
            text = f"the simulation is {state.name.lower()} already"
            raise RefusedError(Transition.ALREADY_IN_TARGET_STATE, text)
        clock_s = self._node.clock_ns / 1e9
        control.set_state(state)
        log_of(self._node).info(f"{state.name.lower()} at {clock_s:.3f} s of /clock")
        if state is RunState.STOPPED:
            self._reset_parts(_PARTS)

    def _reset(self, request: Any, response: Any) -> None:
        scope = request.scope or Scope.ALL
        if scope != Scope.ALL and scope & ~_PARTS:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED,
                f"expected a scope of 1 (time), 2 (state), 4 (spawned), a sum of them, or 0 or 255"
                f" for all, got {request.scope}",
            )
        self._control.give_up_steps("the simulation was reset")
        removed = self._reset_parts(Scope(scope) & _PARTS)
        if removed:
            text = f"no room any more, so deleted: {', '.join(removed)}"
            fill_result(response.result, Code.OK, text)

    def _reset_parts(self, scope: Scope) -> list[str]:
        node, clock_s, removed = self._node, self._node.clock_ns / 1e9, []
        if Scope.STATE in scope:
            removed = node.reset(keep_props=Scope.SPAWNED not in scope)
        elif Scope.SPAWNED in scope:
            node.physics.props.clear()
        if Scope.TIME in scope:
            node.set_clock_back()
        what = ", ".join(part.name or "" for part in scope).lower()
        log_of(node).info(f"reset at {clock_s:.3f} s of /clock: {what}")
        return removed

    # ---- steps ---------------------------------------------------------------------------

    async def _step(self, request: Any, response: Any) -> Any:
        if request.steps > MOST_STEPS:
            text = (
                f"expected at most {MOST_STEPS} steps of {STEP_NS / 1e6:g} ms, got {request.steps};"
                " the action simulate_steps takes any number, and can be canceled"
            )
            fill_result(response.result, Code.OPERATION_FAILED, text)
        else:
            await self._do_steps(request.steps, response.result, lambda _: None)
        return response

    async def _simulate_steps(self, goal: Any) -> Any:
        wanted, feedback = goal.request.steps, action.SimulateSteps.Feedback()

        def send_progress(done: int) -> None:
            feedback.completed_steps, feedback.remaining_steps = done, wanted - done
            goal.publish_feedback(feedback)

        result = action.SimulateSteps.Result()
        await self._do_steps(wanted, result.result, send_progress)
        if result.result.result == Code.OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result

    def _cancel_steps(self, _: Any) -> CancelResponse:
        self._control.give_up_steps("canceled")
        return CancelResponse.ACCEPT

    async def _do_steps(self, wanted: int, result: Any, on_step: Any) -> None:
        """Move on by some steps, and fill the result once that is over."""
        try:
            self._check_steps(wanted)
        except RefusedError as error:
            fill_result(result, error.result_code, str(error))
            return
        ended = Future(executor=self._node.executor)
        steps = StepRun(wanted, on_step, lambda: ended.set_result(None))
        self._control.start_steps(steps)
        await ended
        if steps.given_up:
            text = f"given up after {steps.done} of {wanted} steps: {steps.given_up}"
            fill_result(result, Code.OPERATION_FAILED, text)
        else:
            fill_result(result, Code.OK)

    def _check_steps(self, wanted: int) -> None:
        refuse_while_quitting(self._control)
        state = self._control.state
        if state is not RunState.PAUSED:
            raise RefusedError(
                Code.OPERATION_FAILED,
                f"steps are for a paused simulation, and this one is {state.name.lower()}:"
                " set its state to 2 (paused) first",
            )
        if wanted < 1:
            raise RefusedError(Code.OPERATION_FAILED, f"expected 1 step or more, got {wanted}")
