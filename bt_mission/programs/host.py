"""Runs the code of programs on a virtual clock: each callback until it ends or waits."""

from __future__ import annotations

import signal
from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from dis import opmap
from itertools import count
from types import CoroutineType, coroutine
from typing import Any
from weakref import WeakSet

from greenlet import GreenletExit, getcurrent
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.node import Node
from rclpy.task import Future, Task

from bt_mission.base.stamps import NS
from bt_mission.programs import replaced, signals
from bt_mission.programs.calls import Call, CallWait, Life, Over, Program, current_call
from bt_mission.programs.events import call_event_callbacks
from bt_mission.programs.executors import (
    ENDLESS,
    ExecutorSpin,
    FreeExecutor,
    ProgramExecutor,
    Waker,
)
from bt_mission.programs.goals import ServedGoals
from bt_mission.programs.idle import is_idle
from bt_mission.programs.mains import MainProgram
from bt_mission.programs.stuck import find_stuck, refuse_standstill
from bt_mission.programs.waiting_requests import Remarks
from bt_mission.ros.executors.coroutines import awaited_by
from bt_mission.ros.virtual_time import VirtualTimeExecutor

ROUNDS_PER_INSTANT = 200
"""Rounds of a loop or readings of a clock within an instant, by one call, after which time moves by
a step: 5 us of a robot for each."""

STEP_NS = 1_000_000
"""That step."""

LOOPS = "loops"

_RAISE = opmap["RAISE_VARARGS"]

_REAL_THREADS = 1 << 48
"""Numbers of the threads of programs begin here."""


@coroutine
def _turn() -> Iterator[None]:
    """Wait for the next turn of coroutines."""
    yield


async def _thread_of(executor: ProgramExecutor, number: int) -> ExecutorSpin:
    """Wait until a thread of an executor is free, and it is the turn of a task.

    As in rclpy of Jazzy, of the tasks that can go on, the newest does first. Those that come
    meanwhile wait for the others.

    Args:
        number: Of the task, in the order of their making.
    """
    waiting, turn = executor.waiting, executor.turn
    waiting.setdefault(number)
    try:
        while True:
            if not turn:
                turn += sorted(waiting)
            if turn[-1] == number and (spin := executor.free()) is not None:
                return spin
            for other in [other for other in turn if _is_cancelled(waiting[other])]:
                turn.remove(other)
                del waiting[other]
            await _turn()
    finally:
        del waiting[number]
        if number in turn:
            turn.remove(number)


def _is_cancelled(task: Task | None) -> bool:
    return task is not None and task.cancelled()


class ProgramHost:
    """Runs the calls of the programs of a clock.

    Args:
        clock: Serves their nodes.
        start_ns: What :attr:`time_s` counts from, ns; None is the present.
    """

    def __init__(self, clock: VirtualTimeExecutor, start_ns: int | None = None) -> None:
        self.clock = clock
        self._start_ns = clock.now_ns if start_ns is None else start_ns
        self.is_over = False
        self.executors: WeakSet[ProgramExecutor] = WeakSet()
        self.switches = 0
        """How often code of programs was resumed."""
        self.remarks = Remarks(clock)
        self.goals = ServedGoals(self)
        self._advanced = self._has_begun_task = False
        self._changed = False
        self._numbers = count(_REAL_THREADS)
        self._tasks = count()
        self._executors: dict[Node, list[ProgramExecutor]] = {}
        self._programs: dict[Node, Program] = {}
        self._always: set[int] = set()
        self._woken: dict[ProgramExecutor, Call | None] = {}
        self.calls: dict[Call, None] = {}
        """The calls that have begun and not ended, in that order."""
        self.polls: dict[CallWait, Callable[[], bool]] = {}
        """Waits that end when a function returns true, after code of programs has run."""
        self.stuck: set[Call] = set()
        """Those that can never continue, and were named."""
        clock.host = self
        self._uninstall = replaced.install()

    # ---- nodes ---------------------------------------------------------------------------

    def program(self, name: str, seed: str, context: Context) -> Program:
        """Return a program whose nodes nothing of it spins."""
        program = Program(self, name, seed, context)
        program.executor = FreeExecutor(context=context, program=program)
        return program

    def new_life(self) -> Life:
        """Return a new thread of a program."""
        return Life(next(self._numbers))

    def serve(self, node: Node, executor: ProgramExecutor) -> None:
        """Let an executor of a program serve a node."""
        self._executors.setdefault(node, []).append(executor)
        self._programs.setdefault(node, executor.program)
        self.clock.take_node(node)

    def unserve(self, node: Node, executor: ProgramExecutor) -> None:
        """Let an executor serve a node no longer."""
        self._executors[node].remove(executor)

    def serve_always(self, node: Node, entity: Any) -> None:
        """Serve an entity also while no thread is free."""
        self._always.add(id(entity))
        self._executors.setdefault(node, [])
        call = current_call()
        if call is not None:
            self._programs.setdefault(node, call.program)
        self.clock.take_node(node)
        self.clock.wake()

    def serve_as_others(self, entity: Any) -> None:
        """End :meth:`serve_always`."""
        self._always.discard(id(entity))

    def remark_on_sleep(self, call: Call) -> None:
        """Note that a call sleeps on ROS time in the only thread of its executor."""
        self.remarks.sleep_on_ros_time(call.spin.executor.get_nodes())

    def wake(self, executor: ProgramExecutor) -> None:
        """Note that entities came or went, or that a context was shut down."""
        self._woken[executor] = current_call()
        self.clock.wake()

    def admits(self, entity: Any, node: Node | None) -> bool:
        """Return whether a thread is free for an entity of a node."""
        if node is None or node not in self._executors or id(entity) in self._always:
            return True
        if self._spin_for(node) is None:
            holders = [call for each in self._executors[node] for call in each.blocked]
            self.remarks.refuse(entity, node, holders, by_group=False)
            return False
        if not entity.callback_group.can_execute(entity):
            holders = self.holders_of(entity.callback_group)
            self.remarks.refuse(entity, node, holders, by_group=True)
            return False
        return True

    def has_begun_task(self) -> bool:
        """Return once whether code of a program has made a task."""
        has_begun, self._has_begun_task = self._has_begun_task, False
        return has_begun

    def owns(self, waitable: Any) -> bool:
        """Return whether a waitable is of a program."""
        return getattr(waitable, "_node", None) in self._programs

    def holders_of(self, group: Any) -> list[Call]:
        """Return the calls that hold a callback group."""
        if getattr(group, "_active_entity", None) is None:
            return []
        return [
            call
            for call in self.calls
            if call.entity is not None and call.entity.callback_group is group
        ]

    def waiting_of(self, node: Node) -> list[Call]:
        """Return the calls that wait in callbacks of a node which nothing of a program spins."""
        own = getattr(self._programs[node].executor, "own", None)
        return [call for call in own.busy if call.node is node] if own else []

    def executors_of(self, program: Program) -> list[ProgramExecutor]:
        """Return the executors that serve nodes of a program."""
        return [
            *([program.executor] if isinstance(program.executor, FreeExecutor) else []),
            *(
                executor
                for node, executors in self._executors.items()
                if self._programs[node] is program
                for executor in executors
            ),
        ]

    def took(self, waitable: Any, parts: Any) -> None:
        """Note what was taken for a waitable."""
        self.goals.took(waitable, parts)
        self.remarks.took(waitable, parts)

    def _spin_for(self, node: Node) -> ExecutorSpin | None:
        for executor in self._executors[node]:
            if (spin := executor.free()) is not None:
                return spin
        return None

    # ---- callbacks and tasks -------------------------------------------------------------

    def call(
        self, entity: Any, node: Node | None, function: Callable[..., Any], *args: Any
    ) -> Coroutine[Any, Any, None] | None:
        """Serve an entity. Return the rest as a coroutine, if it waits or awaits something."""
        if node is None or node not in self._executors:
            rest: Coroutine[Any, Any, None] | None = function(*args)
            return rest
        program = self._programs[node]
        spin = self._spin_for(node) or ExecutorSpin(program.serving(), None, ENDLESS)
        self.remarks.serve(entity, node, self.waiting_of(node))
        call = self._begin(spin, program, entity, node, _serve, function, *args)
        if self._advance(call) and call.outcome is None:
            return None
        return self._rest(call)

    def _begin(
        self,
        spin: ExecutorSpin,
        program: Program,
        entity: Any,
        node: Node | None,
        function: Callable[..., Any],
        *args: Any,
    ) -> Call:
        life = spin.executor.life_for(spin)
        call = Call(program, life, spin, entity, node, function, *args)
        spin.begin(call)
        return call

    async def _rest(self, call: Call) -> Any:
        """Run the rest of a call, and of the coroutine that it has returned as (coroutine,)."""
        await self._to_its_end(call)
        outcome = call.outcome
        while isinstance(outcome, _Awaiting):
            if outcome.awaited is None:
                await _turn()
            else:
                with suppress(Exception):  # the coroutine itself raises it
                    await outcome.awaited
            call = await self._part(call, _send, outcome.coroutine)
            outcome = call.outcome
        return outcome

    async def _to_its_end(self, call: Call) -> None:
        while not call.dead:
            assert call.wait is not None, "it has been suspended"
            over = call.wait.over
            await over
            if call.waits_for(over):  # no signal has ended the wait
                self._advance(call)

    async def _part(self, before: Call, function: Callable[..., Any], *args: Any) -> Call:
        """Call a function as soon as a thread is free, for what an earlier call has begun."""
        assert before.spin is not None, "a callback or a task"
        spin = await _thread_of(before.spin.executor, before.number)
        call = self._begin(spin, before.program, before.entity, before.node, function, *args)
        call.number = before.number
        self._advance(call)
        await self._to_its_end(call)
        return call

    def create_task(
        self,
        executor: ProgramExecutor,
        callback: Callable[..., Any] | Coroutine[Any, Any, Any],
        args: Sequence[Any],
        kwargs: dict[str, Any],
    ) -> Task:
        """Run a function or a coroutine of a program as a task of an executor."""
        if isinstance(callback, Waker):
            callback(*args)

        number = next(self._tasks)
        self._has_begun_task = True

        async def run() -> Any:
            if isinstance(callback, Waker):
                return None
            spin = await _thread_of(executor, number)
            owner = getattr(callback, "__self__", None)
            node = owner._node if isinstance(owner, ActionServer) else None
            start = self.clock.start_task
            program = executor.program
            show = program.show if isinstance(program, MainProgram) else None
            call = self._begin(
                spin, program, None, node, _serve, start, callback, args, kwargs, show
            )
            call.number = number
            self._advance(call)
            return await self._rest(call)

        task = executor.waiting[number] = self.clock.begin_task(run)
        if isinstance(callback, Waker):
            del executor.waiting[number]
        return task

    def task_of_call(
        self, callback: Any, args: Sequence[Any], kwargs: dict[str, Any]
    ) -> Task | None:
        """Make a task of the code of a program, if that asks for one; else return None."""
        call = current_call()
        if call is None:
            return None
        executor = call.program.serving() if call.spin is None else call.spin.executor
        return self.create_task(executor, callback, args, kwargs)

    def start(self, call: Call) -> None:
        """Run a call that serves no entity, such as a thread."""

        async def run() -> None:
            self._advance(call)
            await self._to_its_end(call)

        self.clock.begin_task(run)

    def run_main(self, program: MainProgram, then: Callable[[], None]) -> None:
        """Run a whole program; `then` is called at its end, when its nodes are destroyed."""
        call = program.main_call = Call(program, program.life, None, None, None, program.run)
        if self._advance(call):
            self._end(program)
            then()
            return

        async def go_on() -> None:
            await self._to_its_end(call)
            self._end(program)
            then()

        self.clock.begin_task(go_on)

    def leave(self, call: Call, status: int) -> None:
        """End the program of a call, whose code runs, at once: nothing of it runs any more."""
        program = call.program
        if not isinstance(program, MainProgram):
            raise SystemExit(status)
        program.exit_code = status
        program.output.close()

        def end() -> None:
            if program.main_call is not None:
                self._kill(program.main_call)

        self.clock.call_at(self.clock.now_ns, end)
        call.park(CallWait("has left", is_timed=True))

    def interrupt(self, program: Program, number: int = signal.SIGINT) -> None:
        """Send a signal to a program: its handler runs where the main thread waits."""
        own = [call for call in self.calls if call.life is program.life and call.wait is not None]
        handle = signals.action_of(program, own[-1], number) if own else None
        if handle is None:
            return
        if program.ends_with_signal:
            for context in program.contexts:
                context.end()
            for executor in self.executors:
                if executor.program is program:
                    self._woken[executor] = None
        call = own[-1]
        assert call.wait is not None, "it waits"
        before, call.wait.over = call.wait.over, Over()
        if before.is_over:
            call.wait.over.set_result(before._result)
        call.handler = handle
        program.was_interrupted = True
        self._advance(call)
        before.set_result(None)

    def _end(self, program: Program) -> None:
        """End the rest of a program: daemon threads, callbacks, nodes, executors.

        What they print then is not shown: the end of a process runs none of their code.
        """
        if isinstance(program, MainProgram):
            program.output.close()
        for call in [call for call in self.calls if call.program is program]:
            self._kill(call)
        for executor in [each for each in self.executors if each.program is program]:
            executor.shutdown()
        for node in [node for node, owner in self._programs.items() if owner is program]:
            for waitable in tuple(node.waitables):
                if isinstance(waitable, ActionClient | ActionServer):
                    waitable.destroy()  # type: ignore[no-untyped-call]  # of rclpy
            node.destroy_node()
            del self._programs[node], self._executors[node]
        if isinstance(program, MainProgram):
            program.close_loops()
            program.main_call = None
        self.clock.wake()

    @property
    def nodes(self) -> list[Node]:
        """The nodes of all programs, in the order in which they were first served."""
        return list(self._programs)

    def make_node(
        self, program: Program, function: Callable[[], Node], then: Callable[[Node], None]
    ) -> None:
        """Have a program make a node; it is passed on at once, or when a wait of it has ended."""
        call = Call(program, program.life, None, None, None, function)
        self._advance(call)
        if call.dead:
            then(call.outcome)
            return

        async def go_on() -> None:
            await self._to_its_end(call)
            then(call.outcome)

        self.clock.begin_task(go_on)

    # ---- waiting, called by the code of programs -----------------------------------------

    def wait(self, wait: CallWait, timeout_ns: int | None = None) -> bool:
        """Suspend the call whose code runs. Return the result of the wait, False after a time."""
        call = current_call()
        assert call is not None, "only the code of a program waits"
        call.loops_since_ns = None
        if timeout_ns is None:
            return bool(call.park(wait))
        time_ns = self.clock.now_ns + max(timeout_ns, 0)
        alarm = self.clock.call_at(time_ns, wait.run_out)
        try:
            return bool(call.park(wait))
        finally:
            if wait.over._result is not False:  # of the alarm
                self.clock.cancel_call(alarm)

    def take_time(self, call: Call) -> int:
        """Return the present, ns. A loop that only reads it, or does not wait, makes time move."""
        now_ns = self.clock.now_ns
        if call.round_ns != now_ns:
            call.round_ns, call.rounds = now_ns, 0
        call.rounds += 1
        if call.rounds > ROUNDS_PER_INSTANT:
            call.rounds = 0
            since_ns = now_ns if call.loops_since_ns is None else call.loops_since_ns
            self.remarks.loop(call, now_ns - since_ns)
            self.wait(CallWait(LOOPS, is_timed=True), STEP_NS)
            call.loops_since_ns = since_ns
        return self.clock.now_ns

    # ---- inside --------------------------------------------------------------------------

    def _advance(self, call: Call) -> bool:
        """Run a call until it ends or waits. Return whether it has ended.

        An exception is raised where the program spins; here, if it spins nothing.
        """
        self.switches += 1
        self._advanced = self._changed = True
        self.calls[call] = None
        program = call.program
        call.parent = getcurrent()
        former = replaced.enter(call)
        program.swap_in()
        try:
            call.switch()
        except BaseException as failure:
            is_own = isinstance(failure, Exception | SystemExit) or (
                isinstance(failure, KeyboardInterrupt)
                and (program.was_interrupted or _is_raised(failure))
            )
            if not is_own or call.spin is None:
                raise
            if not call.spin.fail(failure):
                raise
        finally:
            program.swap_out()
            replaced.leave(call, former)
            if call.dead:
                self.calls.pop(call, None)
                if call.spin is not None:
                    call.spin.end(call)
            if self._woken:
                self._stop_spinning()
        return bool(call.dead)

    def _stop_spinning(self) -> None:
        woken, self._woken = self._woken, {}
        for executor, by in woken.items():
            if not executor.context.ok():
                executor.stop(from_within=by)

    @property
    def time_s(self) -> float:
        """Virtual time since the start, s."""
        return (self.clock.now_ns - self._start_ns) / NS

    def name_of(self, node: Node) -> str:
        """Return the name of the program of a node; empty for others."""
        program = self._programs.get(node)
        return "" if program is None else program.name

    def action_of(self, server: ActionServer) -> str:
        """Return the full name of the action of a server."""
        return self.clock.actions_of(server)[0]

    def is_idle(self, *, only_serves: bool = False) -> bool:
        """Return whether nothing is due for programs: see :func:`.idle.is_idle`."""
        busy = {goal.server for goal in self.goals.all if goal.ended_s is None}
        serves = (lambda program: program.name not in busy) if only_serves else None
        return is_idle(self.calls, self._programs, serves)

    def compare_qos(self, nodes: Sequence[Node]) -> None:
        """Say which publishers and subscriptions of programs do not match, since some are new."""
        self.remarks.compare_qos(nodes, self._programs)
        call_event_callbacks(self.clock, self._programs, self.remarks.say)

    def take_advanced(self) -> bool:
        """Return once whether code of programs has run."""
        advanced, self._advanced = self._advanced, False
        if advanced:
            for wait, is_ready in tuple(self.polls.items()):
                if is_ready():
                    wait.over.set_result(True)
        return advanced

    def check(self) -> None:
        """Look for calls that wait for each other, once nothing is ready.

        Raises:
            DeadlockError: With what each of them waits for.
        """
        if self._changed:
            self._changed = False
            for call in self.calls:
                if call.wait is not None and not call.wait.is_timed:
                    find_stuck(self.calls, self.stuck, self.holders_of, self.executors_of)
                    return

    def refuse_standstill(self) -> None:
        """Name the calls that wait while nothing will ever be due.

        Raises:
            DeadlockError: With what each of them waits for.
        """
        refuse_standstill(self.calls)

    def close(self) -> None:
        """End all calls: their code runs ``finally`` and no more; and all whole programs."""
        self.remarks.close()
        self.is_over = True
        running = [*self._programs.values(), *(call.program for call in self.calls)]
        mains = dict.fromkeys(each for each in running if isinstance(each, MainProgram))
        for program in mains:
            program.output.end()
            program.output.close()
        for call in tuple(self.calls):
            self._kill(call)
        for program in mains:
            self._end(program)
        for executor in tuple(self.executors):
            executor.shutdown()
        self._uninstall()

    def _kill(self, call: Call) -> None:
        """Have a call run `finally`, and no more."""
        call.is_over = True
        over = Over() if call.wait is None else call.wait.over
        former = replaced.enter(call)
        call.program.swap_in()
        try:
            with suppress(BaseException):  # whatever its code raises; it may be of another thread
                call.parent = getcurrent()
                call.throw(GreenletExit)
        finally:
            call.program.swap_out()
            replaced.leave(call, former)
            self.calls.pop(call, None)
            over.set_result(None)  # what has awaited it ends, too


def _is_raised(error: BaseException) -> bool:
    """Return whether a ``raise`` has raised an exception, and not the handler of a signal."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and trace.tb_frame.f_code.co_code[trace.tb_lasti] == _RAISE


@dataclass(frozen=True)
class _Awaiting:
    """A coroutine that has not ended, and the future that it awaits, if that is known."""

    coroutine: Any
    awaited: Future | None


def _send(coroutine: Any) -> Any:
    """Run a coroutine up to its next wait. Return its result, or that it awaits something."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        return end.value
    return _Awaiting(coroutine, awaited_by(coroutine))


def _serve(function: Callable[..., Any], *args: Any) -> Any:
    """Call a function; run the coroutine that it may return up to its first wait."""
    outcome = function(*args)
    return _send(outcome) if isinstance(outcome, CoroutineType) else outcome
