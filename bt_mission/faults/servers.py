"""Faults of servers themselves: goals that they abort, their death, services that fail."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any, Literal

from bt_mission.core.errors import described
from bt_mission.faults.errors import ScenarioError, no_such
from bt_mission.faults.fault import Begin, FaultInstance, Tap
from bt_mission.faults.maker import Maker, later, lost, makes_fault, mistakes_of_test
from bt_mission.faults.parameters import ActionText, Seconds, ServiceName
from bt_mission.ros.interface_types import fill
from bt_mission.virtual_time import Answer, Side


class ServerFaults(Maker):
    """Faults of action servers, ours and those that a test plays, and of services."""

    @makes_fault
    def abort_goal(
        self,
        action: ActionText,
        code: int = 0,
        message: str = "",
        *,
        when: Callable[[Any], Any] | None = None,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Abort a goal: the one that runs, or else the next.

        A server of ours does so at its next control step, and stops the robot first.

        Args:
            code: The result's ``error_code``.
            message: The result's ``error_msg``.
            when: Looks at feedback, and tells whether it is time; None is at once.
        """

        def begin(fault: FaultInstance) -> None:
            name = fault.action(action)
            played = self._stages.scripted.get(name)
            if played is not None:
                if when is not None:
                    raise ScenarioError(
                        f"abort_goal: {name} is played by the test, which says when"
                    )
                if not played.goals:
                    raise ScenarioError(f"abort_goal: {name} has no goal yet")
                played.goal.abort(error_code=code, error_msg=message)
                return

            def before(method: str, feedback: Mapping[str, Any]) -> tuple[int, str] | None:
                if method != "step" or (when is not None and not _asked(fault, when, feedback)):
                    return None
                fault.end()
                return code, message

            fault.undo(self._servers(fault, name).interpose(name, before))

        return begin

    @makes_fault
    def kill_server(self, action: ActionText, *, lasting: Seconds | None = None) -> Begin:
        """Have the node that offers an action leave the graph without a word, with all it offers.

        At the end of the fault it is back, and knows nothing of the goals before.
        """

        def begin(fault: FaultInstance) -> None:
            stage, name = fault.run.stage, fault.action(action)
            played = self._stages.scripted.get(name)
            if played is None:
                self._servers(fault, name)
                run = fault.run.robot_run
                stage.kill_servers(run)
                fault.undo(lambda: stage.start_servers(run))
                return
            node_name = played.node.get_name()
            stage.clock.remove_node(played.node)
            played.node.destroy_node()

            def restart() -> None:
                played.forget()
                played.offer(self._stages.node(node_name))
                stage.add_node(played.node)

            fault.undo(restart)

        return begin

    @makes_fault
    def raise_in_maneuver(
        self,
        action: ActionText,
        error: Exception | None = None,
        *,
        method: Literal["step", "feedback", "result"] = "step",
        on: int = 1,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Raise an exception in a server of ours, where it carries a goal out.

        Args:
            error: RuntimeError where it is None.
            method: ``step``, ``feedback`` or ``result``.
            on: At which call from now on.
        """
        if method not in ("step", "feedback", "result"):
            raise ScenarioError(
                f"raise_in_maneuver: expected a method of step, feedback, result, got '{method}'"
            )
        raised = error or RuntimeError("made by a fault")

        def begin(fault: FaultInstance) -> None:
            name = fault.action(action)

            def before(called: str, _feedback: Mapping[str, Any]) -> None:
                if called == method and fault.ends_at_call(on):
                    raise raised

            fault.undo(self._servers(fault, name).interpose(name, before))

        return begin

    # ---- services --------------------------------------------------------------------------

    @makes_fault
    def delay_service(
        self, service: ServiceName, by: Seconds, *, lasting: Seconds | None = None
    ) -> Begin:
        """Deliver the answers of a service late; it has done its work then."""
        return _service(service, Side.RESPONSE, later("delay_service", by))

    @makes_fault
    def ignore_service(self, service: ServiceName, *, lasting: Seconds | None = None) -> Begin:
        """Lose requests to a service: it does nothing, and never answers."""
        return _service(service, Side.REQUEST, lost)

    @makes_fault
    def fail_service(
        self, /, service: ServiceName, *, lasting: Seconds | None = None, **fields: Any
    ) -> Begin:
        """Answer in a service's place; it does nothing.

        Args:
            fields: Of the response, such as ``success=False, message="worn out"``; the others are
                empty.
        """

        def begin(fault: FaultInstance) -> None:
            name, kind = fault.service(service)
            with mistakes_of_test(f"fail_service: {name}"):
                fill(kind.Response(), fields)
            fault.tap(name, Side.REQUEST, lambda *_: (Answer(fill(kind.Response(), fields)),))

        return begin

    def _servers(self, fault: FaultInstance, name: str) -> Any:
        """Our servers, where it is they that offer an action."""
        servers = fault.run.robot_run.servers
        if name not in servers.actions:
            raise no_such("action of ours", name, list(servers.actions))
        return servers


def _service(service: str, side: Side, tap: Tap) -> Begin:
    return lambda fault: fault.tap(fault.service(service)[0], side, tap)


def _asked(fault: FaultInstance, when: Callable[[Any], Any], feedback: Mapping[str, Any]) -> bool:
    if not feedback:
        return False
    try:
        return bool(when(SimpleNamespace(**feedback)))
    except Exception as error:  # noqa: BLE001 - whatever a test's function raises is the test's
        fault.run.blame_test(ScenarioError(f"abort_goal: `when` raised {described(error)}"))
        return False
