"""A fault: an action on a run that lasts for a while, and can be ended."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, Protocol

from py_trees.behaviour import Behaviour
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.node import Node

from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.executive.events.events import FaultChanged
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.ros.interface_types import action_type
from bt_mission.ros.virtual_time import Delivery, Passing, ServiceResponse, Side
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.sessions.scripted_server import ScriptedServer
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageRun

Fates = Iterable[Delivery | ServiceResponse]
"""The messages that replace a passing one; without any it is lost."""

Begin = Callable[["FaultInstance"], None]
"""Starts a fault, and gives its instance the function that undoes it."""

Tap = Callable[["FaultInstance", Passing], Fates]
"""Replaces passing messages while a fault is active."""


class FaultTarget(Protocol):
    """The run in which something goes wrong.

    Attributes:
        robot_run: The run of the robot that is concerned, on the stage.
        faults: What has gone wrong for this robot so far.
    """

    stage: Stage
    robot_run: StageRun
    faults: list[FaultInstance]

    @property
    def scripted(self) -> Mapping[str, ScriptedServer]:
        """The servers that a test plays, by the full names of their actions."""

    def make_node(self, name: str) -> Node:
        """Return a new node of the test's own."""

    def find(self, name: str) -> Behaviour:
        """Return the node of this name, or at this path. Raises ScenarioError."""

    def blame_test(self, error: Exception) -> None:
        """Raise an error in the test, and not in the mission."""


@dataclass(eq=False, repr=False)
class Fault:
    """Something that goes wrong: an action for ``run.do``, ``run.at`` and ``run.when``.

    It lasts for the given time, until :attr:`end` runs, or to the end of the run.

    Args:
        what: name of the method of ``stage.faults`` that makes it.
        parameters: the arguments of that method, without those that change nothing.
        begin: see :data:`Begin`.
        lasting: s of virtual time; None is until it is ended.
    """

    what: str
    parameters: Mapping[str, Any]
    begin: Begin
    lasting: float | None = None
    was_applied: bool = field(default=False, init=False)
    """Has an action of a test called it?"""
    _instance: FaultInstance | None = field(default=None, init=False)

    def __call__(self, run: FaultTarget) -> None:
        """Begin.

        Raises:
            ScenarioError: for an unknown name, and while it is already active.
        """
        self.was_applied = True
        if self._instance is not None and self._instance.goes_on_in(run):
            raise ScenarioError(f"{self!r} is already active: end it first, or make another")
        instance = FaultInstance(run, self)
        try:
            self.begin(instance)
        except BaseException:
            instance.undo_all()
            raise
        self._instance = instance
        instance.has_begun()
        if self.lasting is not None:
            end_ns = run.stage.now_ns + round(self.lasting * 1e9)
            run.stage.clock.call_at(end_ns, instance.end)

    def end(self, run: FaultTarget) -> None:
        """End it if it is active; also an action."""
        if self._instance is not None and self._instance.goes_on_in(run):
            self._instance.end_from_outside()

    @property
    def obstacle(self) -> str:
        """Name of what it has brought into the world, or will."""
        made = self._instance.made if self._instance else None
        given = self.parameters.get("name", self.what.removeprefix("spawn_"))
        return str(getattr(made, "name", given))

    def __repr__(self) -> str:
        given = [f"{name}={value!r}" for name, value in plain(self.parameters).items()]
        if self.lasting is not None:
            given.append(f"lasting={self.lasting!r}")
        return f"faults.{self.what}({', '.join(given)})"


class FaultInstance:
    """One activation of a fault in one run.

    Attributes:
        began_ns: when it began, ns of virtual time.
        ended_ns: when it ended; None while it is active.
        made: what it has brought into the world.
        kept: what its taps have to remember, by receiver or goal.
    """

    def __init__(self, run: FaultTarget, fault: Fault) -> None:
        self.run = run
        self.fault = fault
        self.began_ns: int = run.stage.now_ns
        self.ended_ns: int | None = None
        self.number = len(run.faults) + 1
        self.made: Any = None
        self.kept: dict[Any, Any] = {}
        likes = sum(str(injected.fault) == str(fault) for injected in run.faults)
        self.is_within_step = run.stage.is_stepping
        """Did it begin while an instant was served, rather than between two?"""
        self.is_ended_from_outside = False
        self.is_ended_between = False
        """Was it ended from outside, between two instants?"""
        self._seed = f"{run.robot_run.seed_text}/{fault}/{likes}"
        self._undo = ExitStack()
        self._is_lasting = False
        self._calls = 0
        self._passed: dict[str, tuple[int, int]] = {}

    @property
    def began_s(self) -> float:
        """When it began, s of virtual time since the start."""
        return (self.began_ns - self.run.stage.start_ns) / NS

    @property
    def ended_s(self) -> float | None:
        """When it ended; None while it is active."""
        return None if self.ended_ns is None else (self.ended_ns - self.run.stage.start_ns) / NS

    # ---- its life ------------------------------------------------------------------------

    def goes_on_in(self, run: FaultTarget) -> bool:
        """Return whether it is active in this run."""
        return self.run is run and self._is_lasting and self.ended_ns is None

    def undo(self, function: Callable[[], Any]) -> None:
        """Have a function called when it ends; a fault without one ends where it begins."""
        self._is_lasting = True
        self._undo.callback(function)

    def undo_all(self) -> None:
        """Put everything back."""
        self._undo.close()

    def has_begun(self) -> None:
        """Tell the trace."""
        self.run.faults.append(self)
        self._record("begins" if self._is_lasting else "happens")
        if not self._is_lasting:
            self.ended_ns = self.began_ns

    def end(self) -> None:
        """End; it may have ended before."""
        if self.ended_ns is None:
            self.undo_all()
            self.ended_ns = self.run.stage.now_ns
            self._record("ends")

    def end_from_outside(self) -> None:
        """End, as an action of a test does."""
        self.is_ended_from_outside = self.ended_ns is None
        self.is_ended_between = self.is_ended_from_outside and not self.run.stage.is_stepping
        self.end()

    def __str__(self) -> str:
        begin = seconds(self.began_s)
        if not self._is_lasting:
            return f"{self.fault!r} at {begin}"
        end = self.ended_s
        until = "on" if end is None else f"to {seconds(end)}"
        return f"{self.fault!r} from {begin} {until}"

    def _record(self, state: str) -> None:
        parameters = None if state == "ends" else plain(self.fault.parameters)
        what = self.fault.what
        self.run.robot_run.executive.events.emit(
            FaultChanged(self.run.stage.now_ns, self.number, what, state, parameters)
        )

    # ---- for those who write faults --------------------------------------------------------

    def generator(self, *key: Any) -> random.Random:
        """Make a generator of its own for each key, the same in every run of one seed."""
        return random.Random("/".join([self._seed, *map(str, key)]))

    def draw(self, passing: Passing) -> random.Random:
        """Make the generator for something that passes: one for all receivers of a message."""
        time_ns, count = self._passed.get(passing.receiver, (0, 0))
        count = count + 1 if time_ns == passing.time_ns else 0
        self._passed[passing.receiver] = (passing.time_ns, count)
        return self.generator(passing.time_ns, count)

    def ends_at_call(self, number: int) -> bool:
        """Count a call; end at that of this number, from 1, and tell whether this is it."""
        self._calls += 1
        if self._calls == number:
            self.end()
        return self._calls == number

    def tap(self, name: str, side: Side, tap: Tap, receiver: str | None = None) -> None:
        """Decide what becomes of what passes, until the end.

        Args:
            name: full name of a topic or service.
            side: what of it passes.
            tap: decides.
            receiver: full name of the one node that is concerned; None is all.
        """

        def guarded(passing: Passing) -> Fates:
            if receiver is None or passing.receiver == receiver:
                try:
                    return tuple(tap(self, passing))
                except ScenarioError as error:
                    self.run.blame_test(error)  # a mistake of the test's is none of the mission's
            return (Delivery(passing.message),)

        self.undo(self.run.stage.clock.taps.add(name, side, guarded))

    def topic(self, name: str) -> str:
        """Return the full name of a topic of the graph.

        Raises:
            ScenarioError: when the name is unknown.
        """
        node = self.run.robot_run.node
        full = node.resolve_topic_name(name)
        known = {topic for topic, _ in node.get_topic_names_and_types()}
        if full not in known:
            raise no_such(
                "topic", full, sorted(topic for topic in known if "/_action/" not in topic)
            )
        return full

    def action(self, name: str) -> str:
        """Return the full name of an action that somebody offers.

        Args:
            name: of the action; a short name of the mission language will do.

        Raises:
            ScenarioError: when nobody offers it.
        """
        full = self.run.robot_run.node.resolve_topic_name(
            ACTION_NAMES[name].name if name in ACTION_NAMES else name
        )
        if full not in self._actions():
            self.run.stage.offer_all()
        known = self._actions()
        if full not in known:
            raise no_such("action", full, sorted(known))
        return full

    def action_type(self, name: str) -> Any:
        """Return the type of an action that somebody offers."""
        full = self.action(name)
        return action_type(self._actions()[full])

    def service(self, name: str) -> tuple[str, Any]:
        """Return the full name and the type of a service that somebody offers.

        Raises:
            ScenarioError: when nobody does.
        """
        stage = self.run.stage
        full = self.run.robot_run.node.resolve_service_name(name)
        known = {
            service.service_name: service.srv_type
            for node in stage.clock.get_nodes()
            for service in node.services
            if "/_action/" not in service.service_name
        }
        if full not in known:
            raise no_such("service", full, sorted(known))
        return full, known[full]

    def _actions(self) -> dict[str, str]:
        stage = self.run.stage
        return {
            name: types[0]
            for node in stage.clock.get_nodes()
            for name, types in get_action_server_names_and_types_by_node(
                stage.node, node.get_name(), node.get_namespace()
            )
        }

    def node(self, name: str) -> Node:
        """Return the node of a name: in the namespace of the robot, or else without one.

        Raises:
            ScenarioError: when it does not exist.
        """
        namespace = self.run.robot_run.node.get_namespace().rstrip("/")
        full = name if name.startswith("/") else f"{namespace}/{name}"
        known = {node.get_fully_qualified_name(): node for node in self.run.stage.clock.get_nodes()}
        node = known.get(full) or known.get(f"/{name}")
        if node is None:
            raise no_such("node", full, list(known))
        return node


def plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a trace can hold: functions go by their names, exceptions by their text.

    Nothing in it differs from one process to the next.
    """
    shown: dict[str, Any] = {}
    for name, value in parameters.items():
        if isinstance(value, BaseException):
            shown[name] = f"{type(value).__name__}: {value}"
        elif isinstance(value, Fault):
            shown[name] = value.obstacle
        elif isinstance(value, str | int | float | bool | list | tuple | dict):
            shown[name] = value
        else:
            shown[name] = getattr(value, "__name__", type(value).__name__)
    return shown
