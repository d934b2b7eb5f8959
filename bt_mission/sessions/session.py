"""One run of a mission from start to report, on the stage or attached, and who looks on."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, Self

from bt_mission.core.errors import BtMissionError
from bt_mission.core.interrupts import InterruptSignals
from bt_mission.core.wall_clock import Pacer, Stopwatch, rest
from bt_mission.executive.executive import Executive
from bt_mission.executive.leaf_statistics import LeafStatistics
from bt_mission.executive.report import Report, report_on
from bt_mission.executive.status import Change
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.ros.graph import ProcessNode
    from bt_mission.ros.mission_node import MissionNode
    from bt_mission.ros.mission_runner import MissionRunner


Steps = Generator[float, None, Report]
"""A session on its way: see :func:`driving`."""

TURN_S = 0.02
"""Wall time for which steps are taken at a stretch, before keys and pictures have their turn."""

SHORTEST_REST_S = 0.001


class Session(Protocol):
    """A mission with what carries it out: :class:`bt_mission.sessions.stage.Stage`, for one."""

    mission: Mission
    executive: Executive
    trace: Trace
    runner: MissionRunner

    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...
    def step(self) -> None:
        """Move on a little."""

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""

    @property
    def start_ns(self) -> int:
        """ROS time of the start, ns."""

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""

    @property
    def world(self) -> str | None:
        """Name of the simulated world; None where the robot is not simulated here."""

    @property
    def collisions(self) -> int | None:
        """Contacts of the robot, where they are known."""

    @property
    def distance_travelled_m(self) -> float | None:
        """True length of the robot's path, where it is known."""


class SessionObserver(Protocol):
    """What looks on, such as a recorder."""

    node: Node

    def look(self) -> None:
        """Called after each step of the session."""


class ObservableSession(Session, Protocol):
    """A session that can be looked on at: on the stage, or attached."""

    node: MissionNode

    @property
    def image_folder(self) -> Path | None:
        """Where the run makes its pictures; None where that is not known."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is known of the place of the run: the world, the hull of the robot."""

    @property
    def files(self) -> Mapping[str, str]:
        """The texts of the world and the robot, by name; empty where they are not simulated."""

    def inside(self) -> Iterable[ProcessNode]:
        """The nodes of the process that take part."""

    def add_observer(self, observer: SessionObserver, /) -> None:
        """Call an observer after each step; serve its node where messages do not come at once."""

    def remove_observer(self, observer: SessionObserver, /) -> None:
        """Call it no more, and destroy its node."""


class View(AbstractContextManager["View"], Protocol):
    """What people see while a mission runs."""

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Begin to show a session."""

    def on_change(self, change: Change) -> None:
        """A node changed its status."""

    def refresh(self) -> None:
        """Called between steps."""

    def say(self, text: str) -> None:
        """The mission says something."""


class SessionViews:
    """A view that may lose its reader: a pipe that closes ends the mission in good order."""

    def __init__(self, view: View) -> None:
        self.has_left = False
        self.fault: Exception | None = None
        self._view = view

    def on_change(self, change: Change) -> None:
        """Show a change, while somebody looks."""
        self._show(lambda: self._view.on_change(change))

    def refresh(self) -> None:
        """Draw again, while somebody looks."""
        self._show(self._view.refresh)

    @property
    def why_left(self) -> str:
        """What ended the view, for people."""
        if isinstance(self.fault, BrokenPipeError):
            return "nobody reads the output any more"
        return f"the view failed: {type(self.fault).__name__}: {self.fault}"

    def _show(self, show: Callable[[], None]) -> None:
        if not self.has_left:
            try:
                show()
            except Exception as error:  # noqa: BLE001 - what shows a mission must not break it
                self.has_left = True
                self.fault = error


def drive(
    session: Session, view: View, *, speed: float | None = None, trace_file: Path | None = None
) -> Report:
    """Step a session to its end, paced and shown; gives the report: see :func:`driving`."""
    return finish(driving(session, view, InterruptSignals(), speed=speed, trace_file=trace_file))


def finish(steps: Steps) -> Report:
    """Take all steps that are left, each when it is due; gives the report."""
    while True:
        try:
            rest(next(steps))
        except StopIteration as end:
            report: Report = end.value
            return report


class StepDriver:
    """Takes the steps of a session within somebody else's loop.

    Args:
        steps: The session on its way.
    """

    def __init__(self, steps: Steps) -> None:
        self.report: Report | None = None
        """Once the session has ended."""
        self._steps = steps

    def advance(self) -> float:
        """Take the steps that are due, for :data:`TURN_S`; gives the wall time to the next, s."""
        since = Stopwatch()
        wait_s = 0.0
        while self.report is None and wait_s <= 0 and since.elapsed_s < TURN_S:
            try:
                wait_s = next(self._steps)
            except StopIteration as end:
                self.report = end.value
        return max(wait_s, SHORTEST_REST_S)

    def finish(self) -> Report:
        """Take all steps that are left, each when it is due; gives the report."""
        if self.report is None:
            self.report = finish(self._steps)
        return self.report


def driving(
    session: Session,
    view: View,
    interrupts: InterruptSignals,
    *,
    speed: float | None = None,
    trace_file: Path | None = None,
) -> Steps:
    """Step a session to its end, paced and shown; gives the report.

    Whoever drives takes one step after another. A step tells the wall time until the next is due,
    s, for which to rest or to look after other things; when it comes too early, it changes nothing.

    The first Ctrl-C or SIGTERM halts the tree and waits until every goal has ended; the second
    leaves at once, and the report's reason names the goals left behind.

    Raises:
        BtMissionError: When ``trace_file`` cannot be written.
    """
    wall = Stopwatch()
    with ExitStack() as stack:
        if trace_file is not None:
            stack.enter_context(session.trace.written_to(trace_file))
        stack.enter_context(interrupts)
        view.open(session, wall)
        stack.enter_context(view)
        audience = SessionViews(view)
        session.executive.listeners.append(audience.on_change)
        tally = LeafStatistics(lambda: session.distance_travelled_m)
        session.executive.listeners.append(tally.on_change)
        pacer = Pacer(speed, session.start_ns)
        while not session.is_done:
            if audience.has_left:
                session.executive.interrupt(audience.why_left)
            if interrupts.count == 1:
                session.executive.interrupt(f"interrupted by {interrupts.name}")
            elif interrupts.count > 1:
                session.executive.interrupt(f"interrupted by {interrupts.name}")
                session.executive.abandon(f"left at once after a second {interrupts.name}")
                break
            _step(session)
            while (ahead_s := pacer.ahead_s(session.now_ns)) > 0:
                if interrupts.count > 0 and not session.is_done:
                    break
                yield ahead_s
            audience.refresh()
            yield 0.0
    return replace(summarise(session, wall.elapsed_s), leaves=tally.summaries())


def _step(session: Session) -> None:
    try:
        session.step()
    except BtMissionError as error:
        session.executive.abandon(str(error))


def summarise(session: Session, wall_s: float) -> Report:
    """The report of a session that has ended."""
    end_ns = session.executive.ended_ns or session.now_ns
    virtual_s = (end_ns - session.start_ns) / 1e9
    distance = session.distance_travelled_m
    return replace(
        report_on(
            session.mission,
            session.executive,
            session.trace,
            virtual_s,
            wall_s,
            session.runner.requirements.results(),
        ),
        world=session.world,
        collisions=session.collisions,
        distance_travelled_m=None if distance is None else round(distance, 6),
    )
