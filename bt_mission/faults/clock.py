"""A clock that is set, or stands still."""

from __future__ import annotations

from bt_mission.faults.errors import ScenarioError
from bt_mission.faults.fault import Begin, FaultInstance
from bt_mission.faults.maker import Maker, makes_fault
from bt_mission.faults.parameters import NodeName, Seconds

EXECUTIVE = "bt_mission"


class ClockFaults(Maker):
    """Faults of the clock that one node follows, while all others go on."""

    @makes_fault
    def jump_clock(
        self, by: Seconds, *, node: NodeName = EXECUTIVE, lasting: Seconds | None = None
    ) -> Begin:
        """Have a node's clock jump, as when a simulator is reset or skips time.

        It goes on from there; where the fault ends, it jumps back to where it would be.

        Args:
            by: Seconds; below zero, back. What would be before zero is zero.
            node: Whose clock.
        """
        if by == 0:
            raise ScenarioError("jump_clock: expected seconds other than 0")

        def begin(fault: FaultInstance) -> None:
            clock = fault.run.stage.clock
            whose = fault.node(node)
            by_ns = max(round(by * 1e9), -clock.clocks.at(whose, clock.now_ns))
            clock.clocks.set_ahead(whose, by_ns, clock.now_ns)
            if lasting is not None:
                fault.undo(lambda: clock.clocks.set_ahead(whose, -by_ns, clock.now_ns))

        return begin

    @makes_fault
    def stop_clock(self, *, node: NodeName = EXECUTIVE, lasting: Seconds | None = None) -> Begin:
        """Have a node's clock stand still, as when a simulator is paused; then it goes on.

        Args:
            node: Whose clock.
        """

        def begin(fault: FaultInstance) -> None:
            clock = fault.run.stage.clock
            whose = fault.node(node)
            clock.clocks.stop(whose, clock.now_ns)
            fault.undo(lambda: clock.clocks.go_on(whose, clock.now_ns))

        return begin
