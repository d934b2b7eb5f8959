"""Faults that begin while a run is watched, as its viewers ask for them."""

from __future__ import annotations

import json

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import cause_of
from bt_mission.base.stamps import NS
from bt_mission.scenarios.faults.located import fault_in_text
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.faults.targets import StageTarget
from bt_mission.sessions.stage import Stage

_MS = 1_000_000

MOST = 50
"""Faults that viewers can make in a run."""


class LiveFaults:
    """Makes faults in a running simulation of one robot.

    A fault begins at the next millisecond. A run with the same fault planned for that time is the
    same run. So a recording names it among the faults of the run.
    """

    def __init__(self, stage: Stage) -> None:
        self.target = StageTarget(stage, stage.runs[0])
        self.begun: list[tuple[str, tuple[float, float] | None]] = []
        """The texts of the faults that have begun, and their places on the map."""
        self._stage = stage
        self._lines: list[str] = []
        self._asked = 0

    def make(self, text: str) -> None:
        """Make a fault, such as `spawn_box at (1, 2)`. A line for viewers has the result."""
        since_ns = self._stage.now_ns - self._stage.start_ns
        at_ns = (max(since_ns, 0) // _MS + 1) * _MS
        if self._asked >= MOST:
            self._lines.append(f"a run takes at most {MOST} faults from its viewers")
            return
        try:
            planned = fault_in_text(f"at {at_ns / NS!r}: {text}")
            planned.make()
        except InputError as error:
            self._lines.append(error.diagnostics[0].message)
            return
        self._asked += 1
        self._stage.clock.call_at(self._stage.start_ns + at_ns, lambda: self._begin(planned))

    def take_lines(self) -> list[str]:
        """Return the lines for viewers since the last call."""
        lines, self._lines = self._lines, []
        return lines

    def _begin(self, planned: PlannedFault) -> None:
        run = self.target.robot_run
        if run.executive.is_done:
            self._lines.append("the mission has ended: no fault was made")
            return
        try:
            planned.make()(self.target)
        except Exception as error:  # noqa: BLE001 - a fault must not break into the mission
            self._lines.append(f"not possible: {cause_of(error)}")
            return
        texts = json.loads(run.facts.get("faults", "[]"))
        run.facts["faults"] = json.dumps([*texts, planned.text])
        at: tuple[float, float] | None = None
        match planned.arguments.get("at"):
            case (int() | float() as x, int() | float() as y):
                at = (float(x), float(y))
        self.begun.append((planned.text, at))
        self._lines.append(planned.text)
