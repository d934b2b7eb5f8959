"""One run of a mission from start to report, on the stage or attached, and who looks on."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Generic, Protocol, Self, TypeAlias, TypeVar

from bt_mission.core.errors import BtMissionError, cause_of
from bt_mission.core.interrupts import TWO_WISHES, InterruptSignals
from bt_mission.core.wall_clock import Pacer, Stopwatch, rest
from bt_mission.events.events import Event, NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.leaf_statistics import LeafStatistics
from bt_mission.executive.report import Report, report_on
from bt_mission.executive.status import MissionStatus
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.ros.graph import ProcessNode
    from bt_mission.ros.mission_runner import MissionRunner


R = TypeVar("R")
Steps: TypeAlias = Generator[float, None, R]
"""A session on its way to its report: see :func:`driving`."""

TURN_S = 0.02
"""Wall time for which steps are taken at a stretch, before keys and pictures have their turn."""

SHORTEST_REST_S = 0.001


class Stepped(Protocol):
    """What moves on step by step."""

    def step(self) -> None:
        """Move on a little."""

    @property
    def is_done(self) -> bool:
        """Has every mission ended, with every goal accounted for?"""

    @property
    def start_ns(self) -> int:
        """ROS time of the start, ns."""

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""


class Session(Stepped, Protocol):
    """A mission with what carries it out: :class:`bt_mission.sessions.stage.Stage`, for one."""

    mission: Mission
    executive: Executive
    trace: Trace
    runner: MissionRunner

    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...

    @property
    def world(self) -> str | None:
        """Name of the simulated world; None where the robot is not simulated here."""

    @property
    def collisions(self) -> int | None:
        """Contacts of the robot, where they are known."""

    @property
    def distance_travelled_m(self) -> float | None:
        """True length of the robot's path, where it is known."""

    @property
    def nature(self) -> Mapping[str, float]:
        """What nature has drawn for the robot, where it is simulated."""


class SessionObserver(Protocol):
    """What looks on, such as a recorder."""

    node: Node

    def look(self) -> None:
        """Called after each step of the session."""


class ObservedRun(Protocol):
    """A mission with its executive, to be looked on at."""

    @property
    def mission(self) -> Mission:
        """What is carried out."""

    @property
    def node(self) -> Node:
        """By its name the mission is known; in its namespace the robot is."""

    @property
    def runner(self) -> MissionRunner:
        """What carries it out."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is known of its robot, such as the hull."""


class RecordableSession(Protocol):
    """Missions that can be looked on at: on the stage, attached, or served."""

    @property
    def node(self) -> Node:
        """That of the first mission."""

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""

    @property
    def runs(self) -> Sequence[ObservedRun]:
        """Each mission, with its executive."""

    @property
    def image_folder(self) -> Path | None:
        """Where the run makes its pictures; None where that is not known."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is known of the place of the run, such as the world."""

    @property
    def files(self) -> Mapping[str, str]:
        """The texts of the world and the robot, by name; empty where they are not simulated."""

    def inside(self) -> Iterable[ProcessNode]:
        """The nodes of the process that take part."""

    def add_observer(self, observer: SessionObserver, /) -> None:
        """Call an observer after each step; serve its node where messages do not come at once."""

    def remove_observer(self, observer: SessionObserver, /) -> None:
        """Call it no more, and destroy its node."""


class ObservableSession(Session, RecordableSession, Protocol):
    """A session that can be looked on at."""


class View(AbstractContextManager["View"], Protocol):
    """What people see while a mission runs."""

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Begin to show a session."""

    def on_change(self, change: NodeChanged) -> None:
        """A node changed its status."""

    def refresh(self) -> None:
        """Called between steps."""

    def say(self, text: str) -> None:
        """The mission says something."""


class SessionViews:
    """A view that may lose its reader: a pipe that closes ends the mission in good order.

    Args:
        refresh: Draws the view again.
    """

    def __init__(self, refresh: Callable[[], None]) -> None:
        self.has_left = False
        self.fault: Exception | None = None
        self._refresh = refresh

    def refresh(self) -> None:
        """Draw again, while somebody looks."""
        self.show(self._refresh)

    @property
    def why_left(self) -> str:
        """What ended the view, for people."""
        if isinstance(self.fault, BrokenPipeError):
            return "nobody reads the output any more"
        return f"the view failed: {type(self.fault).__name__}: {self.fault}"

    def show(self, show: Callable[[], None]) -> None:
        """Have something shown, while somebody looks."""
        if not self.has_left:
            try:
                show()
            except Exception as error:  # noqa: BLE001 - what shows a mission must not break it
                self.has_left = True
                self.fault = error


def drive(session: Session, view: View, *, speed: float | None = None) -> Report:
    """Step a session to its end, paced and shown; gives the report: see :func:`driving`."""
    return finish(driving(session, view, InterruptSignals(TWO_WISHES), speed=speed))


def finish(steps: Steps[R]) -> R:
    """Take all steps that are left, each when it is due; gives the report."""
    while True:
        try:
            rest(next(steps))
        except StopIteration as end:
            report: R = end.value
            return report


class StepDriver(Generic[R]):
    """Takes the steps of a session within somebody else's loop.

    Args:
        steps: The session on its way.
    """

    def __init__(self, steps: Steps[R]) -> None:
        self.report: R | None = None
        """Once the session has ended."""
        self.fault: Exception | None = None
        """What a step has raised; no step follows it."""
        self._steps = steps

    @property
    def is_over(self) -> bool:
        """Is there no further step?"""
        return self.report is not None or self.fault is not None

    def advance(self) -> float:
        """Take the steps that are due, for :data:`TURN_S`; gives the wall time to the next, s.

        An event loop reports an exception of its callbacks and continues. So none leaves this
        method: :meth:`finish` raises it.
        """
        since = Stopwatch()
        wait_s = 0.0
        while not self.is_over and wait_s <= 0 and since.elapsed_s < TURN_S:
            try:
                wait_s = next(self._steps)
            except StopIteration as end:
                self.report = end.value
            except Exception as error:  # noqa: BLE001 - raised again by `finish`
                self.fault = error
        return max(wait_s, SHORTEST_REST_S)

    def finish(self) -> R:
        """Take all steps that are left, each when it is due; gives the report.

        Raises:
            Exception: What a step has raised.
        """
        if self.fault is not None:
            raise self.fault
        if self.report is None:
            self.report = finish(self._steps)
        return self.report


def driving(
    session: Session,
    view: View,
    interrupts: InterruptSignals,
    *,
    speed: float | None = None,
) -> Steps[Report]:
    """Step a session to its end, paced and shown; gives the report.

    Whoever drives takes one step after another. A step tells the wall time until the next is due,
    s, for which to rest or to look after other things; when it comes too early, it changes nothing.

    The first Ctrl-C or SIGTERM halts the tree and waits until every goal has ended; the second
    leaves at once, and the report's reason names the goals left behind.
    """
    wall = Stopwatch()
    with ExitStack() as stack:
        stack.enter_context(interrupts)
        view.open(session, wall)
        stack.enter_context(view)
        audience = SessionViews(view.refresh)

        def take(event: Event) -> None:
            if isinstance(event, NodeChanged):
                audience.show(lambda: view.on_change(event))

        session.executive.events.subscribe(take)
        tally = LeafStatistics(session.executive, lambda: session.distance_travelled_m)
        yield from take_steps(session, [session.executive], audience, interrupts, speed)
    return replace(summarise(session, wall.elapsed_s), leaves=tally.summaries())


def take_steps(
    session: Stepped,
    executives: Sequence[Executive],
    audience: SessionViews,
    interrupts: InterruptSignals,
    speed: float | None,
) -> Steps[None]:
    """Step missions to their end, as :func:`driving` does one.

    An exception of a step ends them as failed with the cause, with every goal seen to its end; a
    second one, or one after which the session cannot continue, leaves at once.
    """
    pacer = Pacer(speed, session.start_ns)
    while not session.is_done:
        if audience.has_left:
            _interrupt(executives, audience.why_left)
        if interrupts.count:
            _interrupt(executives, f"interrupted by {interrupts.name}")
        if interrupts.count > 1:
            _abandon(executives, f"left at once after a second {interrupts.name}")
            break
        try:
            session.step()
        except BtMissionError as error:
            _abandon(executives, str(error))
        except Exception as error:  # noqa: BLE001 - whatever takes part may raise anything
            _fail(executives, f"a callback failed: {cause_of(error)}")
        while (ahead_s := pacer.ahead_s(session.now_ns)) > 0:
            if interrupts.count > 0 and not session.is_done:
                break
            yield ahead_s
        audience.refresh()
        yield 0.0


def _interrupt(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        executive.interrupt(reason)


def _fail(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        if executive.status is MissionStatus.RUNNING:
            executive.fail(reason)
        else:
            executive.abandon(reason)


def _abandon(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        executive.abandon(reason)


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
        nature=dict(session.nature),
        distance_travelled_m=None if distance is None else round(distance, 6),
    )
