"""Faults of the clock that one node follows, while all other nodes and the world continue."""

from __future__ import annotations

from bt_mission.scenarios.faults.fault import FaultInstance
from bt_mission.scenarios.faults.kind import Arguments, FaultKind
from bt_mission.scenarios.faults.parameters import Parameter, any_of, steps


def _jump(fault: FaultInstance, given: Arguments) -> None:
    clock = fault.run.stage.clock
    whose = fault.node(given["node"])
    by_ns = max(round(given["by"] * 1e9), -clock.clocks.at(whose, clock.now_ns))
    clock.clocks.set_ahead(whose, by_ns, clock.now_ns)
    if fault.fault.lasting is not None:
        fault.undo(lambda: clock.clocks.set_ahead(whose, -by_ns, clock.now_ns))


def _stop(fault: FaultInstance, given: Arguments) -> None:
    clock = fault.run.stage.clock
    whose = fault.node(given["node"])
    clock.clocks.stop(whose, clock.now_ns)
    fault.undo(lambda: clock.clocks.go_on(whose, clock.now_ns))


NODE = Parameter(
    "node",
    "text",
    "Whose clock.",
    "bt_mission",
    names="node",
    by_name=True,
    drawn=any_of("bt_mission", "bt_mission_servers"),
)

ROWS = (
    FaultKind(
        "jump_clock",
        "The clock is set forward, or back if `by` is below 0. At the end of the fault it jumps "
        "back.",
        _jump,
        (Parameter("by", "number", unit="s", drawn=steps(-2, 2, 0.5, instead_of_0=0.5)), NODE),
        "The clock of a node",
        "clock",
        check=lambda given: "" if given["by"] else "expected seconds other than 0",
    ),
    FaultKind(
        "stop_clock",
        "The clock stands still, and resumes from there.",
        _stop,
        (NODE,),
        "The clock of a node",
        "clock",
    ),
)
