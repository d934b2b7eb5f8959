"""The views of a fleet's run: every line says of which robot it tells."""

from __future__ import annotations

import sys
from functools import partial
from typing import TextIO

from rich.cells import cell_len
from rich.console import Group
from rich.text import Text

from bt_mission.core.terminal.console import EscapingConsole
from bt_mission.core.text import counted, escape_control, seconds
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import NodeChanged
from bt_mission.events.log import verdict
from bt_mission.fleets.plan import FleetPlan
from bt_mission.fleets.run import FleetView, QuietFleet
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRun
from bt_mission.views.terminal.lines import PlainLines
from bt_mission.views.terminal.marks import clean
from bt_mission.views.terminal.output_capture import OutputCapture
from bt_mission.views.terminal.views import LiveScreen, LiveTree

ABOVE = 4
"""Rows of a screen that are left free of trees: the line above them, and what scrolls by."""


def fleet_view_for(stream: TextIO, plan: FleetPlan, *, plain: bool) -> FleetView:
    """Live trees on a terminal, plain lines in a pipe; `FleetSpeech` is for ``--json``."""
    console = EscapingConsole(stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return FleetLines(stream, plan)
    capture = OutputCapture()
    return FleetScreen(EscapingConsole(capture.terminal), plan, capture)


class FleetSpeech(QuietFleet):
    """Shows nothing but what missions say, on standard error."""

    def on_robot_line(self, robot: str, text: str, /) -> None:
        """Pass on what a mission says."""
        print(f"{robot}: {text}", file=sys.stderr)


class FleetLines(QuietFleet):
    """A line for each leaf that starts or ends, with the robot's name before it."""

    def __init__(self, stream: TextIO, plan: FleetPlan) -> None:
        self._stream = stream
        self._plan = plan
        self._lines: dict[str, PlainLines] = {}

    def open(self, stage: Stage, _wall: Stopwatch, /) -> None:
        """Say what is run."""
        width = max(len(run.member.name) for run in stage.runs)
        print(title_of(self._plan), file=self._stream, flush=True)
        for run in stage.runs:
            mission, name = run.member.mission, run.member.name
            who = f"{name:{width}}  "
            self._lines[name] = PlainLines(
                self._stream, run.executive, lambda: stage.start_ns, lambda: stage.now_ns, who=who
            )
            line = f"  {who}{mission.name} ({mission.robot}, seed {mission.seed})"
            print(escape_control(line), file=self._stream, flush=True)

    def on_robot_change(self, robot: str, change: NodeChanged, /) -> None:
        """Show a change."""
        self._lines[robot].on_change(change)

    def on_robot_line(self, robot: str, text: str, /) -> None:
        """Show what a mission says."""
        self._lines[robot].say(text)

    def refresh(self) -> None:
        """Show what others have done to the missions."""
        for lines in self._lines.values():
            lines.refresh()


class FleetScreen(LiveScreen):
    """The trees of all robots below each other, each with as many rows as fit."""

    def __init__(
        self, console: EscapingConsole, plan: FleetPlan, capture: OutputCapture | None = None
    ) -> None:
        super().__init__(console, capture)
        self._plan = plan
        self._stage: Stage | None = None
        self._wall = Stopwatch()
        self._trees: list[tuple[FleetRun, LiveTree]] = []
        self._width = 0

    def open(self, stage: Stage, wall: Stopwatch, /) -> None:
        """Begin to draw."""
        self._stage, self._wall = stage, wall
        self._width = max(len(run.member.name) for run in stage.runs)
        for run in stage.runs:
            tree = LiveTree(self.console, run.executive, partial(self._header, run))
            self._trees.append((run, tree))
        self.begin(self._picture)

    def on_robot_change(self, _robot: str, _change: NodeChanged, /) -> None:
        """Its tree is drawn anyway."""

    def on_robot_line(self, robot: str, text: str, /) -> None:
        """Have it scroll by."""
        if self._stage is not None:
            time_ns = self._stage.now_ns - self._stage.start_ns
            self.scroll(time_ns, text, f"{robot:{self._width}}")

    def _picture(self) -> Group:
        rows = max(self.console.height - ABOVE, 1) // len(self._trees)
        trees = [tree.render(max(rows - 1, 0)) for _, tree in self._trees]
        above = clean(self._title(), self.marks)
        return Group(Text(above, style="bold", no_wrap=True, overflow="ellipsis"), *trees)

    def _title(self) -> str:
        assert self._stage is not None
        virtual_s = (self._stage.now_ns - self._stage.start_ns) / 1e9
        factor = virtual_s / self._wall.elapsed_s if self._wall.elapsed_s > 0 else 0.0
        return f"{title_of(self._plan)}   {seconds(virtual_s)}   {factor:.0f} x real time"

    def _header(self, run: FleetRun) -> str:
        """How a mission goes, and what runs in it, in one line."""
        executive, mission = run.executive, run.member.mission
        state = verdict(executive.state, executive.explanation)
        parts = [f"{run.member.name:{self._width}}", mission.name, state]
        running = ", ".join(leaf.name for leaf in executive.running_leaves)
        if running and cell_len("  ".join([*parts, running])) <= self.console.width:
            parts.append(running)
        return "  ".join(parts)


def title_of(plan: FleetPlan) -> str:
    """Name, world and seed of a fleet."""
    robots = counted(len(plan.robots), "robot")
    return escape_control(f"{plan.name} in {plan.world.name} ({robots}, seed {plan.seed})")
