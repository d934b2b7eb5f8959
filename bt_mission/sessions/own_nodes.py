"""The user's own nodes on a stage, made by what `nodes` of missions, scenarios and fleets name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, NoReturn

from rclpy.action import ActionClient, ActionServer, get_action_server_names_and_types_by_node
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node

from bt_mission.base.diagnostics import InputError, quoted
from bt_mission.base.errors import BtMissionError, described, place_of
from bt_mission.base.interrupts import TookTooLong, interrupted_after
from bt_mission.base.text import escape_lines
from bt_mission.language.mission import NodeFactory
from bt_mission.language.plugins import PythonError, find_factory, find_program, program_of
from bt_mission.programs import Program, ProgramHost
from bt_mission.programs.executors import ProgramExecutor
from bt_mission.programs.mains import MainProgram, WholeProgram, hint_for_commands
from bt_mission.programs.replaced import adopt
from bt_mission.ros.graph import as_default
from bt_mission.sessions.scripted_server import ScriptedServer

if TYPE_CHECKING:
    from bt_mission.sessions.stage_robot import FleetRobot

LONGEST_S = 10.0
"""Wall time after which a factory of a node is stopped, s."""

KEYWORDS = "accept **options, and pass them to rclpy's Node"

Factory = NodeFactory | Callable[..., Any]


class OwnNodes:
    """Makes nodes of the user, and destroys them with the stage.

    They may wait while they are made: virtual time continues, and they are served afterwards.

    Args:
        shared: Factories of nodes of no single robot.
        robots: Their missions may name further factories, whose nodes are in the namespace of the
            robot.
        host: Runs their code.
        seed: Of their random numbers.
        programs: Whole programs that run beside the nodes.
        context: The rclpy context of the stage.
        made: Destroys them.

    Raises:
        InputError: A factory makes no node, with its place; BtMissionError, if it was given in
            Python.
    """

    def __init__(
        self,
        shared: Sequence[Factory],
        robots: Sequence[FleetRobot],
        context: Context,
        made: ExitStack,
        host: ProgramHost | None = None,
        seed: int = 0,
        programs: Sequence[WholeProgram] = (),
    ) -> None:
        self._context, self._host = context, host
        self._is_served = False
        self.programs: list[MainProgram] = []
        """Whole programs, in the order of their start."""
        self._made: list[tuple[Factory, Program, Node]] = []
        self._unmade: list[Factory] = []
        wanted: list[tuple[Factory, str]] = [(factory, "") for factory in shared]
        wanted += [(factory, robot.name) for robot in robots for factory in robot.mission.nodes]
        self._taken: set[str] = set()
        made.callback(self._destroy)
        if host is not None:
            made.callback(host.close)
        for number, (factory, namespace) in enumerate(wanted):
            assert host is not None, "there is code of users"
            name = f"{seed}/{number}/{namespace}/{name_of(factory)}"
            if isinstance(factory, NodeFactory) and _is_program(factory):
                self._run(host, factory, name, namespace)
                continue
            program = host.program(name_of(factory), name, context)
            self._make(host, program, factory, namespace)
        for number, whole in enumerate(programs):
            assert host is not None, "there is code of users"
            self.start(host, whole, f"{seed}/program {number}")

    @property
    def nodes(self) -> list[Node]:
        """In the order in which they were made."""
        made = [node for *_, node in self._made]
        programs = [] if self._host is None else self._host.nodes
        return [*made, *(node for node in programs if node not in made)]

    @property
    def actions(self) -> frozenset[str]:
        """The full names of the actions that they offer."""
        return frozenset(
            name
            for node in self.nodes
            for name, _ in get_action_server_names_and_types_by_node(
                node, node.get_name(), node.get_namespace()
            )
        )

    def flaws(self) -> Iterator[str]:
        """Yield a line for each node that its own code has destroyed, or has not made."""
        for factory in self._unmade:
            yield (
                f"{name_of(factory)} has not returned, so its node was not there: it must create "
                "and return the node"
            )
        for factory, _, node in self._made:
            if isinstance(getattr(node, "server", None), ScriptedServer):
                continue  # a fault destroys it
            try:
                with node.handle:
                    pass
            except InvalidHandle:
                yield (
                    f"the node of {name_of(factory)} was destroyed while it was needed "
                    f"({place_of(type(node))}): leave out destroy_node(), which the stage calls"
                )

    def refuse_names_of(self, others: Iterable[Node]) -> None:
        """Refuse nodes with the name of another node."""
        self._taken.update(other.get_fully_qualified_name() for other in others)
        for factory, _, node in self._made:
            self._refuse_name(factory, node)

    def serve(self) -> None:
        """Have the nodes served, also those that are still to come."""
        self._is_served = True
        for _, program, node in self._made:
            _serve(program, node)

    def _destroy(self) -> None:
        with ExitStack() as made:
            for factory, _, node in self._made:
                made.callback(_destroy, factory, node)

    def _refuse_name(self, factory: Factory, node: Node) -> None:
        name = node.get_fully_qualified_name()
        if name in self._taken:
            hint = "give the node another name"
            _refuse(factory, f"a node {quoted(name)} already exists on the stage", hint)
        self._taken.add(name)

    def _make(self, host: ProgramHost, program: Program, factory: Factory, namespace: str) -> None:
        options: dict[str, Any] = {"context": self._context}
        if namespace:
            options["namespace"] = namespace

        def take(made: Any) -> None:
            node = self._checked(factory, made)
            self._unmade.remove(factory)
            self._made.append((factory, program, node))
            if self._is_served:
                self._refuse_name(factory, node)
                _serve(program, node)

        def make() -> Any:
            function = imported(factory)
            adopt(function)
            return _called(factory, function, options)

        self._unmade.append(factory)
        with interrupted_after(LONGEST_S), as_default(self._context):
            host.make_node(program, make, take)

    def _run(self, host: ProgramHost, factory: NodeFactory, seed: str, namespace: str) -> None:
        """Run a whole program, whose lines go to the standard error output."""
        try:
            program = find_program(factory.target, factory.file)
        except PythonError as error:
            _refuse(factory, error.message, error.hint, error.code)
        arguments = program.arguments
        if namespace:
            arguments = [*arguments, "--ros-args", "-r", f"__ns:=/{namespace}"]

        def say(time_s: float, line: str) -> None:
            sys.stderr.write(f"{time_s:9.2f} s  {shown}: {escape_lines(line)}\n")

        def end(exit_code: int) -> None:
            say(host.time_s, f"ended with exit code {exit_code}")

        whole = WholeProgram(program.file, arguments, say, end, program.module, program.function)
        shown = factory.name or whole.name
        try:
            self.start(host, whole, seed)
        except BtMissionError as error:
            _refuse(factory, str(error))

    def start(self, host: ProgramHost, whole: WholeProgram, seed: str) -> MainProgram:
        """Run a program until it waits; return it.

        Raises:
            BtMissionError: It computes for too long.
        """
        self._host = host
        program = MainProgram(
            host,
            seed,
            whole.file,
            whole.arguments,
            lambda line: whole.say(host.time_s, line),
            whole.module,
            whole.function,
        )
        if copies := sum(other.file == program.file for other in self.programs):
            program.name = f"{program.name}_{copies + 1}"  # goals are told apart by it
        self.programs.append(program)
        try:
            with interrupted_after(LONGEST_S), as_default(self._context):
                host.run_main(program, lambda: whole.end(program.exit_code or 0))
        except TookTooLong:
            raise BtMissionError(
                f"{whole.file.name} computed for {LONGEST_S:g} s without waiting; it must spin, "
                "sleep or end",
                code="BT-215",
            ) from None
        return program

    def _checked(self, factory: Factory, made: Any) -> Node:
        if not isinstance(made, Node):
            message = f"{name_of(factory)} returned {type(made).__name__}; expected an rclpy Node"
            _refuse(factory, message)
        if made.context is not self._context:
            made.destroy_node()
            message = f"{name_of(factory)} created its node in another rclpy context"
            _refuse(factory, message, KEYWORDS)
        return made


def _is_program(factory: NodeFactory) -> bool:
    try:
        return bool(program_of(factory.target))
    except PythonError as error:
        _refuse(factory, error.message, error.hint, error.code)


def _serve(program: Program, node: Node) -> None:
    """Serve a node as the executor does that its factory has added it to, if there is one."""
    executor = node.executor
    if isinstance(executor, ProgramExecutor):
        executor.keep_spinning()
    else:
        program.executor.add_node(node)


def _called(factory: Factory, function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Call a factory.

    Raises:
        InputError: It raises an exception, or takes too long.
    """
    try:
        return function(**options)
    except TookTooLong:
        message = f"{name_of(factory)} did not return within {LONGEST_S:g} s"
        _refuse(factory, message, "it must create and return the node; it may wait, not compute")
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a user's code raises
        hint = KEYWORDS if isinstance(error, TypeError) else hint_for_commands(error)
        _refuse(factory, f"{name_of(factory)} raised {described(error, function)}", hint)


def imported(factory: Factory) -> Callable[..., Any]:
    """Return the function or class of the user.

    Raises:
        InputError: It does not exist.
    """
    if callable(factory):
        return factory
    try:
        return find_factory(factory.target, factory.file)
    except PythonError as error:
        _refuse(factory, error.message, error.hint, error.code)


def _destroy(factory: Factory, node: Node) -> None:
    """Destroy a node and its actions, which rclpy leaves to the garbage collector.

    Until then the node would stay in the graph, and its end would take the log of the next node of
    its name off ``/rosout``.
    """
    try:
        waitables = tuple(node.waitables)
        node.destroy_node()
        for waitable in waitables:
            if isinstance(waitable, ActionServer | ActionClient):
                waitable.destroy()  # type: ignore[no-untyped-call]  # of rclpy
    except Exception as error:  # noqa: BLE001 - whatever a user's code raises
        _refuse(factory, f"destroy_node() of {name_of(factory)} raised {described(error)}")


def name_of(factory: Factory) -> str:
    """Return what a factory is called, for people."""
    if isinstance(factory, NodeFactory):
        return factory.target
    return str(getattr(factory, "__qualname__", factory))


def _refuse(
    factory: Factory, message: str, hint: str | None = None, code: str = "BT-215"
) -> NoReturn:
    if isinstance(factory, NodeFactory):
        raise InputError([factory.diagnostic(code, message, hint)]) from None
    raise BtMissionError(f"{message}; {hint}" if hint else message, code=code) from None
