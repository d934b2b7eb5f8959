"""One run of a mission, whose servers, services, topics and classes answer at random.

Tree, executive, attempts, ledger and the monitors of requirements are those of a run. The clients
and the clock are the oracle's own: answers have any value and come at any instant, also between two
ticks. A fault is an answer of the table in ``docs/how-to/prove-a-mission.md``; a run has at most so
many, and one that turns out to have more is void.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from itertools import count
from random import Random
from types import SimpleNamespace
from typing import Any

from py_trees.common import Status

from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.control import Timeout
from bt_mission.executive.behaviours.python_leaf import PythonLeaf
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.events.events import NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.goal import Goal, GoalStatus, GoalTrigger
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.status import MissionStatus
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.nodes.interfaces import ServiceNode
from bt_mission.language.outcome import Outcome
from bt_mission.language.trees import all_steps
from bt_mission.requirements.monitor import Monitors
from bt_mission.ros.interface_types import action_type, fill, service_type, topic_type
from bt_mission.ros.mission_runtime import CANCEL_GRACE_NS
from bt_mission.ros.signals import LiveSignals
from tests.commands.prove.oracle.leaf import Answering
from tests.commands.prove.oracle.values import Values

S = 1_000_000_000
TICK_NS = S // 20
TICK_S = 0.05
NOTICED_S = 0.35
"""A server that is away for so long is noticed."""
LONGEST_S = 40.0
MOST_LINES = 400
"""A longer history has no more messages."""
RAISED = "raised by the oracle"
NOT_A_NUMBER = "expected a number, got NaN"
"""An output of a Python leaf is NaN: a fault of the class, as an exception is."""
ANSWERED = (ActionLeaf, PythonLeaf, ServiceLeaf, WaitFor)
"""The leaves that wait for somebody."""
QUIET_S = 15.0
"""A mission whose nodes do not change for so long, at the end of a long run, has no end."""


class Served:
    """A goal at its server."""

    def __init__(self, client: GoalServer, goal: Goal) -> None:
        self.client, self.goal = client, goal
        self.is_accepted = self.is_over = False
        self.is_canceling = self.refuses = self.ignores = False
        self.is_silent = False


class GoalServer:
    """The client of an action, and its server."""

    def __init__(self, world: World, name: str, type_name: str) -> None:
        self.world, self.name, self.type_name = world, name, type_name
        self.type = action_type(type_name)
        self.goals: list[Served] = []
        self.back_ns = 0

    def is_ready(self) -> bool:
        world = self.world
        if world.now_ns < self.back_ns:
            return False
        if not self.goals and world.has_fault(f"{self.name} has no server"):
            self.back_ns = world.now_ns + world.absence_ns()
            return False
        return True

    def obstacle(self) -> str:
        return ""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fill(self.type.Goal(), fields)

    def recover_goal(self, goal: Goal) -> None:
        """No run is resumed."""

    def ask_result(self, goal: Goal) -> None:
        """The result comes by itself."""

    def send(self, goal: Goal, _request: Any) -> None:
        served, world = Served(self, goal), self.world
        self.goals.append(served)
        if not world.has_fault(f"{self.name} does not take the goal"):
            world.after(
                world.delay_s(world.limit_of(goal, "acceptance_timeout", 2.0)), self._accept, served
            )
        elif world.draw.random() < 0.5:
            world.after(
                world.delay_s(world.limit_of(goal, "acceptance_timeout", 2.0)), self._reject, served
            )

    def _reject(self, served: Served) -> None:
        if not served.is_over:
            self._leave(served, "rejects")
            served.goal.on(GoalTrigger.REJECTED)

    def _accept(self, served: Served) -> None:
        world, goal = self.world, served.goal
        if served.is_over:
            return
        world.note(f"{self.name} accepts the goal of '{goal.owner}'")
        served.is_accepted = True
        world.note_live(served)
        self._plan(served)
        goal.on(GoalTrigger.ACCEPTED)

    def _plan(self, served: Served) -> None:
        world = self.world
        end = partial_end(self, served)
        if world.has_fault(f"{self.name} aborts, is lost, or never ends"):
            way = world.draw.random()
            if way < 0.4:
                world.after(world.delay_s(), end, GoalStatus.ABORTED)
            elif way < 0.7:
                world.after(world.delay_s(), self._lose)
        else:
            world.after(world.delay_s(), end, GoalStatus.SUCCEEDED)
        silence = world.limit_of(served.goal, "feedback_timeout", None)
        if silence is not None and world.has_fault(f"{self.name} falls silent"):
            served.is_silent = True
            world.after(world.delay_s(silence), self._feed, served, None)
        elif silence is not None or world.draw.random() < 0.7:
            world.after(world.delay_s(silence), self._feed, served, silence)

    def _feed(self, served: Served, silence: float | None) -> None:
        if served.is_over:
            return
        world = self.world
        served.goal.on_feedback(world.values.fill(self.type.Feedback()))
        if not served.is_silent:
            world.after(max(0.02, world.delay_s(silence)), self._feed, served, silence)

    def _lose(self) -> None:
        world = self.world
        if not self.goals:
            return
        world.note(f"{self.name} loses its server")
        for served in tuple(self.goals):
            self._leave(served, "")
        self.back_ns = world.now_ns + max(round(NOTICED_S * S), world.absence_ns())

    def end(self, served: Served, status: GoalStatus) -> None:
        if served.is_over or (served.is_canceling and status is not GoalStatus.CANCELED):
            return
        self._leave(served, f"ends, {status.name}")
        result = self.world.values.fill(self.type.Result())
        self.world.note(f"  result {result}"[:300])
        served.goal.on_result(status, result)

    def _leave(self, served: Served, how: str) -> None:
        served.is_over = True
        self.goals.remove(served)
        if how:
            self.world.note(f"{self.name} goal of '{served.goal.owner}' {how}")

    def send_cancel(self, goal: Goal) -> None:
        world = self.world
        served = next((entry for entry in self.goals if entry.goal is goal), None)
        if served is None or not served.is_accepted or served.is_canceling or served.ignores:
            return
        if served.refuses:
            world.after(world.delay_s(0.3), self._refuse, served)
            return
        limit_s = world.limit_of(goal, "cancel_timeout", 3.0)
        if goal.orphaned_ns is not None:
            left_s = (goal.orphaned_ns + goal.grace_ns - world.now_ns) / S
            limit_s = left_s if 0 < left_s < limit_s else limit_s
        if not world.has_fault(f"{self.name} does not cancel"):
            served.is_canceling = True
            world.after(world.delay_s(limit_s), self.end, served, GoalStatus.CANCELED)
        elif world.draw.random() < 0.5:
            served.refuses = True
            world.after(world.delay_s(limit_s), self._refuse, served)
        else:
            served.ignores = True

    def _refuse(self, served: Served) -> None:
        if not served.is_over:
            self.world.note(f"{self.name} refuses to cancel")
            served.goal.on(GoalTrigger.CANCEL_REFUSED)


def partial_end(client: GoalServer, served: Served) -> Callable[[GoalStatus], None]:
    """Return what ends a goal."""
    return lambda status: client.end(served, status)


class Service:
    """The client of a service, and its server."""

    def __init__(self, world: World, name: str, type_name: str) -> None:
        self.world, self.name = world, name
        self.type = service_type(type_name)
        self.back_ns = 0

    def is_ready(self) -> bool:
        world = self.world
        if world.now_ns >= self.back_ns and world.has_fault(f"{self.name} has no server"):
            self.back_ns = world.now_ns + world.absence_ns()
        return world.now_ns >= self.back_ns

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fill(self.type.Request(), fields)

    def call(self, _request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        world, response = self.world, self.world.values.fill(self.type.Response())
        has_success = hasattr(response, "success")
        calls = [True]
        is_bad = world.has_fault(f"{self.name} does not serve")
        if has_success:
            response.success = not is_bad
        if not is_bad or (has_success and world.draw.random() < 0.6):

            def answer() -> None:
                if calls[0]:
                    world.note(f"{self.name} answers {response}"[:200])
                    on_answer(response)

            world.after(world.delay_s(world.service_limit_of(self.name)), answer)

        def forget() -> None:
            calls[0] = False

        return forget


class Topic:
    """A topic with its publisher."""

    def __init__(self, world: World, name: str, type_name: str) -> None:
        self.world, self.name = world, name
        self.type = topic_type(type_name)
        self.listeners: list[Callable[[Any], None]] = []
        self.pace_s = world.draw.choice((0.04, 0.15, 0.4, 1.0))
        follows = [
            f.settings for f in world.follows if f.settings.topic.strip("/") == name.strip("/")
        ]
        limits = [f.timeout for f in follows if f.timeout is not None]
        self.limit_s = min(limits, default=None)
        is_awaited = any(f.initial is None for f in follows)
        if is_awaited and world.has_fault(f"{name} is silent"):
            return
        first_s = world.delay_s(4.5)
        if is_awaited:
            world.after(min(first_s, 4.5), self.send)
        elif world.draw.random() < 0.85:
            world.after(first_s, self.send)

    def send(self) -> None:
        world = self.world
        if self.limit_s is not None and world.has_fault(f"{self.name} falls silent"):
            return
        message = world.values.fill(self.type())
        world.note_message(self.name, message)
        for listener in tuple(self.listeners):
            listener(message)
        if self.limit_s is None and world.draw.random() < 0.03:
            return
        world.after(max(0.01, world.delay_s(self.limit_s or self.pace_s * 4)), self.send)

    def listen(self, listener: Callable[[Any], None]) -> None:
        self.listeners.append(listener)

    def leave(self, listener: Callable[[Any], None]) -> None:
        self.listeners = [known for known in self.listeners if known != listener]

    def look_around(self) -> None:
        """Nothing is latched."""

    def why_silent(self) -> str:
        return "its publisher is silent"


class Publisher:
    """A topic on which the mission publishes."""

    def __init__(self, world: World, name: str, type_name: str) -> None:
        self.world, self.name = world, name
        self.type = topic_type(type_name)
        self.back_ns = 0

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return fill(self.type(), fields)

    def count_readers(self) -> int:
        world = self.world
        if world.now_ns >= self.back_ns and world.has_fault(f"{self.name} has no subscriptions"):
            self.back_ns = world.now_ns + world.absence_ns()
        return 100 if world.now_ns >= self.back_ns else 0

    def publish(self, _message: Any) -> None:
        """Nobody reads it."""


class World:
    """A mission and everything that answers it; implements ``Runtime``.

    Attributes:
        void: Why the run shows nothing; "" where it does.
        broken: What it shows, by the name of the property.
        entered: The names of the nodes that were entered.
        history: What happened, with its time.
    """

    def __init__(self, mission: Mission, text: str, seed: int, faults: float) -> None:
        self.mission, self.faults = mission, faults
        self.draw = draw = Random(seed)
        self.values = Values(draw, text)
        self._fault_rate = draw.choice((0.0, 0.1, 0.4))
        self._pace = draw.choice(("any", "any", "any", "fast", "slow"))
        self.now_ns = S
        self._queue: list[tuple[int, int, Callable[..., None], tuple[Any, ...]]] = []
        self._number = count()
        self.void = ""
        self.broken: dict[str, str] = {}
        self.entered: set[str] = set()
        self.history: list[str] = []
        steps = list(all_steps(mission))
        self._goal_nodes = {node.label: node for node in steps if isinstance(node, GoalNode)}
        self._service_nodes = [node for node in steps if isinstance(node, ServiceNode)]
        self.follows = [follow for tree in mission.all_trees for follow in tree.follow]
        self._clients: dict[tuple[type, str], Any] = {}
        self._live: list[Served] = []
        self.scope = Scope(dict(mission.inputs), seed)
        self.ledger = Ledger(str(seed), CANCEL_GRACE_NS)
        Answering.source = self
        self.executive = Executive(
            build_tree(mission, self.scope), self, Trace(), mission.observe, mission.name
        )
        self.executive.events.subscribe(self._take, NodeChanged)
        self._finals = [node for node in self.executive.nodes if isinstance(node, Finally)]
        self._due_cleanups: set[Any] = set()
        self._running: set[Any] = set()
        self._at_tick: set[Any] = set()
        self.changed_ns = S
        self.node = SimpleNamespace(resolve_topic_name=lambda name: name)
        self._monitors: Monitors | None = None
        if mission.requirements:
            self.signals = LiveSignals(self)  # type: ignore[arg-type]
            self._monitors = Monitors(mission.requirements, self.signals, lambda *_: None)
            self.executive.after_tick.append(self._monitor)

    # ---- the runtime ------------------------------------------------------------------------

    def goal_client(self, action: str, type_name: str) -> GoalServer:
        return self._client(GoalServer, action, type_name)

    def service_client(self, service: str, type_name: str) -> Service:
        return self._client(Service, service, type_name)

    def subscriber(self, topic: str, type_name: str) -> Topic:
        return self._client(Topic, topic, type_name)

    def publisher(self, topic: str, type_name: str) -> Publisher:
        return self._client(Publisher, topic, type_name)

    def _client(self, kind: Any, name: str, type_name: str) -> Any:
        full = f"/{name.removeprefix('/')}"
        if (kind, full) not in self._clients:
            self._clients[kind, full] = kind(self, full, type_name)
        return self._clients[kind, full]

    def log(self, text: str) -> None:
        self.note(f"log: {text}")

    def warn(self, text: str) -> None:
        """Nobody watches."""

    # ---- draws ------------------------------------------------------------------------------

    def has_fault(self, what: str) -> bool:
        """Draw whether this fault happens, as long as one is left."""
        if self.faults < 1 or self.draw.random() >= self._fault_rate:
            return False
        self.faults -= 1
        self.note(f"fault: {what}")
        return True

    def charge(self, what: str) -> None:
        """Count a fault that follows from late answers."""
        self.faults -= 1
        self.note(f"fault: {what}")
        if self.faults < 0:
            self.void = self.void or "more faults than allowed"

    def absence_ns(self) -> int:
        """Draw how long a server is away, ns."""
        return round(self.draw.choice((0.1, 0.5, 3.0, 1000.0)) * S)

    def delay_s(self, limit_s: float | None = None) -> float:
        """Draw how long an answer takes, s, not longer than a limit."""
        draw, numbers = self.draw, self.values.numbers
        way = draw.random()
        if self._pace == "fast":
            drawn = draw.uniform(0, 0.1)
        elif self._pace == "slow" or way < 0.2:
            drawn = draw.uniform(0, 3 if limit_s is None else limit_s)
        elif way < 0.5:
            drawn = draw.uniform(0, 0.12)
        elif way < 0.75:
            drawn = draw.expovariate(2)
        else:
            drawn = abs(draw.choice(numbers or [1.0])) + draw.choice(
                (0, -0.05, 0.05, 0.001, -0.001)
            )
        if limit_s is not None and drawn > limit_s:
            drawn = limit_s if way > 0.95 else draw.uniform(0, limit_s)
        return min(max(drawn, 0.0), 30.0)

    def limit_of(self, goal: Goal, name: str, usual: float | None) -> Any:
        """Return a limit of the node that has sent a goal, s."""
        value = getattr(self._goal_nodes.get(goal.owner), name, None)
        return float(value) if isinstance(value, int | float) else usual

    def service_limit_of(self, name: str) -> float:
        """Return the shortest limit of the nodes that call a service, s."""
        limits = [
            node.timeout
            for node in self._service_nodes
            if node.ros_name.strip("/") == name.strip("/")
        ]
        return min(
            (float(limit) for limit in limits if isinstance(limit, int | float)), default=5.0
        )

    def answer_of_leaf(self) -> Status:
        """Draw the status of a Python leaf. Raises RuntimeError as a fault."""
        way = self.draw.random()
        if way < 0.4:
            return Status.SUCCESS
        if way < 0.6:
            return Status.FAILURE
        if way > 0.9 and self.has_fault("a Python leaf raises"):
            raise RuntimeError(RAISED)
        return Status.RUNNING

    # ---- time -------------------------------------------------------------------------------

    def after(self, delay_s: float, call: Callable[..., None], *arguments: Any) -> None:
        """Have something happen after some time."""
        at_ns = self.now_ns + round(delay_s * S)
        heapq.heappush(self._queue, (at_ns, next(self._number), call, arguments))

    def run(self) -> World:
        """Run the mission to its end, or for the longest time."""
        executive, queue = self.executive, self._queue
        tick_ns, end_ns = self.now_ns, self.now_ns + round(LONGEST_S * S)
        while not executive.is_done and not self.void and tick_ns < end_ns:
            tick_ns += TICK_NS
            while queue and queue[0][0] <= tick_ns:
                self.now_ns, _, call, arguments = heapq.heappop(queue)
                call(*arguments)
            self.now_ns = tick_ns
            self._at_tick = set(self._running)
            executive.tick()
            if self._live:
                self._look_at_goals()
        self._look_at_end()
        return self

    # ---- what it shows ----------------------------------------------------------------------

    def note(self, text: str) -> None:
        """Note what happens."""
        self.history.append(f"{(self.now_ns - S) / S:.3f} s: {text}")

    def note_message(self, topic: str, message: Any) -> None:
        """Note the fields of a message that the mission may read."""
        if len(self.history) < MOST_LINES:
            read = self.values.read_of(message)
            self.note(f"{topic}: {', '.join(f'{name} = {value}' for name, value in read)}"[:200])

    def note_live(self, served: Served) -> None:
        """Note a goal on which its server works from now on."""
        self._live.append(served)
        parts: dict[str, list[str]] = {}
        for entry in self._live:
            if entry.is_over:
                continue
            for part in self._goal_nodes[entry.goal.owner].known_parts or ():
                parts.setdefault(part, []).append(entry.goal.owner)
        for part, owners in parts.items():
            if len(owners) > 1:
                self.show(f"one_goal_at_the_{part}", f"{owners} have open goals at the {part}")

    def show(self, name: str, why: str) -> None:
        """Note that a property is broken."""
        if name not in self.broken:
            self.broken[name] = f"{(self.now_ns - S) / S:.3f} s: {why}"

    def _look_at_goals(self) -> None:
        held = {goal.id for goal in self.ledger.open_goals}
        self._live = [served for served in self._live if not served.is_over]
        for served in self._live:
            if served.goal.id not in held:
                self.show(
                    "goals_accounted", f"the goal of '{served.goal.owner}' is not in the ledger"
                )

    def _take(self, event: NodeChanged) -> None:
        node, status = self.executive.nodes[event.node], event.status
        self.changed_ns = self.now_ns
        if status is Status.RUNNING:
            self._running.add(node)
        else:
            self._running.discard(node)
        if status is Status.INVALID:
            return
        self.note(f"'{node.name}' {status.value.lower()} {node.feedback_message}"[:160])
        self.entered.add(node.name)
        for final in self._finals:
            if node is final.body:
                self._due_cleanups.add(final)
            elif node is final.cleanup:
                self._due_cleanups.discard(final)
        if isinstance(node, ActionLeaf):
            self._charge_goal(node)
        elif status is Status.FAILURE and self._is_late(node):
            self.charge(f"'{node.name}' is over before its servers are done")

    def _is_late(self, node: Any) -> bool:
        """Has a node failed because something below it was late?"""
        if isinstance(node, WaitFor):
            return True
        if not isinstance(node, Timeout | Finally):
            return False
        is_cut = any(child.status is not Status.FAILURE for child in node.children)
        below = [each for each in node.iterate() if isinstance(each, ANSWERED)]
        return is_cut and any(leaf in self._at_tick for leaf in below)

    def _charge_goal(self, leaf: ActionLeaf) -> None:
        attempt = leaf.attempt
        if attempt is None or attempt.ending is None:
            return
        outcome = attempt.ending.outcome
        served = next((s for s in self._live if s.goal is attempt.goal), None)
        if outcome is Outcome.CANCELED_BY_TIMEOUT or attempt.cause == "timeout":
            self.charge(f"'{leaf.name}' is late")
        if outcome is Outcome.SILENT and not (served and served.is_silent):
            self.void = self.void or f"'{leaf.name}' was silent without a fault"
        if outcome is Outcome.UNCONFIRMED and not (served and served.ignores):
            self.void = self.void or f"'{leaf.name}' was unconfirmed without a fault"

    def _monitor(self) -> None:
        executive = self.executive
        if not executive.started_ns or self._monitors is None:
            return
        self._monitors.step(self.now_ns - executive.started_ns)
        self.signals.forget()

    def _look_at_end(self) -> None:
        executive = self.executive
        if self.void:
            return
        if executive.is_done:
            self._look_at_ending()
        elif self.now_ns - self.changed_ns > QUIET_S * S and not self._is_awaiting:
            self.show("ends", f"nothing changes since {(self.changed_ns - S) / S:.3f} s")
        if self._monitors is None:
            return
        self._monitors.finish(is_complete=executive.is_done)
        for result in self._monitors.results:
            if result.verdict == "violated":
                self.show(f"requirement {result.name}", str(result))
            elif result.verdict == "holds":
                self.show(f"exercised {result.name}", str(result))

    @property
    def _is_awaiting(self) -> bool:
        """May the message that a node waits for still come? It is usual, and seldom drawn."""
        return any(isinstance(node, WaitFor) for node in self._running)

    def _look_at_ending(self) -> None:
        executive = self.executive
        for _ in executive.cleanups.failures:
            self.charge("a clean-up is not done")
        if NOT_A_NUMBER in executive.reason:
            self.charge("a Python leaf gives NaN")
        if self.void:
            return
        for final in self._due_cleanups:
            if any(f"'{node.name}'" in executive.reason for node in final.cleanup.iterate()):
                continue  # it has run, and has raised the error that ends the mission
            self.show("cleanup", f"the clean-up of '{final.name}' has not run")
        is_error = executive.root.status is Status.INVALID
        if executive.verdict is not MissionStatus.FAILURE or not is_error:
            return
        if "has no value" in executive.reason:
            self.show("unset_variable", executive.reason)
        elif RAISED not in executive.reason and NOT_A_NUMBER not in executive.reason:
            self.show("unhandled", executive.reason)
