"""A mission with the real executive in a world that may answer anything.

One step is what happens between two ticks, and the tick. Where nothing happens, time passes: one
tick where the tree still moves, else up to the next limit.
"""

from __future__ import annotations

import marshal
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from hashlib import blake2b
from types import MappingProxyType
from typing import Any, TypeAlias

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.commands.prove.abstraction import (
    NEVER_NS,
    BoundedRepeat,
    Loose,
    is_between_rounds,
    is_limited,
    keep_open,
    lone_leaves,
    loose_deadlines,
    meet,
    unlimited_leaves,
)
from bt_mission.commands.prove.answers import AnswerSet
from bt_mission.commands.prove.choices import (
    NEVER,
    NOTHING,
    UNBOUNDED,
    Choices,
    OutOfFaultsError,
    Possibility,
    Script,
)
from bt_mission.commands.prove.clients import AnyBehaviour, NamedGenerators, Service
from bt_mission.commands.prove.goal_servers import Question, ServedGoal
from bt_mission.commands.prove.limits import Due, RunningLimits
from bt_mission.commands.prove.memento import Keeper, Memento
from bt_mission.commands.prove.offered import OfferedClients
from bt_mission.commands.prove.requirements import RequirementMonitors
from bt_mission.commands.prove.state_key import (
    ORPHANED,
    StateKeys,
    end_key,
    failed_tip,
    own_reason,
    without_times,
)
from bt_mission.commands.prove.values import ValueCases
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.builder import BEHAVIOURS, build_tree
from bt_mission.executive.behaviours.client_leaves import ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.events.events import NodeChanged, NodesReset
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.goal import Goal
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.status import MissionStatus
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission, Requirement
from bt_mission.language.nodes.decorators import RepeatNode
from bt_mission.language.nodes.leaves import PythonNode
from bt_mission.ros.mission_runner import TICK_RATE_HZ
from bt_mission.ros.mission_runtime import CANCEL_GRACE_NS

TICK_NS = round(NS / TICK_RATE_HZ)
START_NS = NS
INTERRUPT = "Ctrl-C"


Asked: TypeAlias = tuple[list[Question], list[tuple[Due, Question]]]
"""What may happen before the next tick: events, and limits that may be over."""


class _Moment:
    """What of the environment changes from step to step."""

    def __init__(self, *, may_interrupt: bool) -> None:
        self.now_ns = START_NS
        self.may_interrupt = may_interrupt
        self.untimed: Any = None
        """The last key without times and delays."""
        self.delays: tuple[int, ...] = ()
        """How often each answer that is owed was not there yet."""
        self.limits: tuple[Due, ...] = ()
        """The limits that were running behind the last tick."""
        self.open: tuple[Due, ...] = ()
        """Those that may be over at any tick."""


class _Tip:
    """Says which node has failed, in place of the state that follows from the events."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment

    def failure_path(self) -> tuple[int, ...]:
        """The failed nodes from the root down."""
        executive = self._environment.executive
        node, path = failed_tip(executive.root), [0]
        while node.parent is not None:
            path.insert(1, executive.indices[node])
            node = node.parent
        return tuple(path)


class Environment(OfferedClients):
    """A mission, its executive and everything that answers them; implements ``Runtime``.

    Args:
        mission: What to run.
        answers: Which answers are considered.
        faults: How many faults may happen on a way; infinite for no bound.
        has_interrupts: May Ctrl-C come at any time, once?
        rounds: Counts of `repeat` above it are cut to it; 0 for no bound and exact deadlines.
            None opens those above 10.
        requirements: What is evaluated behind each tick.
        is_untimed: May every limit be over at any tick? So all orders of instants are among those
            that are explored, and some that no run has.
        are_extremes_free: Do extreme numbers cost no fault?
    """

    def __init__(
        self,
        mission: Mission,
        answers: AnswerSet | None = None,
        faults: float = UNBOUNDED,
        *,
        has_interrupts: bool = False,
        rounds: int | None = None,
        requirements: Sequence[Requirement] = (),
        is_untimed: bool = False,
        are_extremes_free: bool = False,
    ) -> None:
        cases = ValueCases(
            mission,
            requirements,
            has_bound=faults != UNBOUNDED,
            are_extremes_free=are_extremes_free,
        )
        super().__init__(mission, answers or AnswerSet(), Choices(faults), cases)
        self.rounds = rounds
        self.cut: dict[str, int] = {}
        """The counts that were cut, by the name of the node."""
        self.opened: dict[str, int] = {}
        """The counts that are open, by the name of the node."""
        self._moment = _Moment(may_interrupt=has_interrupts)
        self.is_stuck = self.is_quiet = self.has_lost = False
        """Did nothing happen in the last step; is no limit running; is a goal lost for ever?"""
        self.has_answered = False
        """Did something happen in the last step that might have happened at another instant?"""
        self.ticked_ns = START_NS
        """The instant of the last tick, ns. Where it was quiet, time has passed since."""
        self.entered: set[int] = set()
        """Indices of the nodes that have changed their status in the last step."""
        self.scope = Scope(dict(mission.inputs), mission.seed, NamedGenerators(self.draw))
        self.ledger = Ledger(0, CANCEL_GRACE_NS, retry_ns=NEVER_NS, server_check_ns=0)
        behaviours = MappingProxyType(
            {**BEHAVIOURS, PythonNode: AnyBehaviour, RepeatNode: BoundedRepeat}
        )
        root = build_tree(mission, self.scope, behaviours)
        self.executive = Executive(root, self, Trace(), 0.0, mission.name)
        self.requirements = RequirementMonitors(
            requirements, self.executive, self.ledger, self.scope.values
        )
        self._see_events()
        nodes = self.executive.nodes
        self._evaluators = {
            node: self.scope.evaluators[self.executive.path_of(node)] for node in nodes
        }
        self._action_leaves = [node for node in nodes if isinstance(node, ActionLeaf)]
        self._any_behaviours = [node for node in nodes if isinstance(node, AnyBehaviour)]
        self._alone = lone_leaves(nodes)
        self._unlimited = unlimited_leaves(nodes, self._evaluators)
        self._limits = RunningLimits(
            self.executive,
            self.ledger,
            self._goal_servers,
            self._services,
            self._topics,
            self.answers,
            () if rounds == 0 or is_untimed else loose_deadlines(nodes, self._evaluators),
            are_all_open=is_untimed,
        )
        self._loose = self._limits.loose
        self._services_called = [node for node in nodes if isinstance(node, ServiceLeaf)]
        for client in self._answering:
            client.is_untimed = is_untimed
        for topic in self._topics.values():
            topic.is_age_loose = rounds != 0 and not is_untimed
        self._waits = [node for node in nodes if isinstance(node, WaitFor)]
        self.keys = StateKeys(self.executive, self.ledger, self._evaluators, self)
        """The parts of a state that count."""
        self._present: Memento | None = None
        """The state that was put back, until its next step."""
        self._asked: tuple[Memento | None, Asked] = (None, ([], []))
        """The state that was asked last, and what may happen in it."""
        self._owing: list[tuple[ServedGoal | Service, int]] = []
        """Goals and services that owed an answer when the step began, with their delays then."""
        self._visited: list[Behaviour] = []
        """The nodes that the last tick has visited."""
        self._inner_of: dict[Any, Scope] = {
            node: node.inner
            for node, finals in self.keys.subtrees
            if not finals and not node.inner.followed
        }
        """The variables that change only where a step visits their node."""
        self.executive.tick_wrappers.append(self._note_visited)
        self._keeper = Keeper(self._changing(), self._changing_by_use(), self._dynamic)

    def _see_events(self) -> None:
        """Hand events to nobody but :attr:`entered`: traces are no part of a state."""
        self.ledger.on_event = self._ignore
        self.executive.events.unsubscribe_all()
        self.executive.events.subscribe(self._note_entered, NodeChanged)
        self.executive.events.subscribe(self._note_reset, NodesReset)
        self.executive.mission_state = _Tip(self)  # type: ignore[assignment]

    def _ignore(self, time_ns: int, change: str, goal: Goal) -> None:
        """Emit nothing about a goal."""

    def _note_entered(self, event: NodeChanged) -> None:
        if event.status is Status.INVALID:
            self._visited.append(self.executive.nodes[event.node])
        else:
            self.entered.add(event.node)
        self.requirements.take(event)

    def _note_reset(self, event: NodesReset) -> None:
        self._visited += [self.executive.nodes[number] for number in event.nodes]

    def _note_visited(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        visit = self._visited.append
        for node in walk:
            visit(node)
            yield node

    @property
    def now_ns(self) -> int:
        """The time, ns."""
        return self._moment.now_ns

    @property
    def any_behaviours(self) -> tuple[AnyBehaviour, ...]:
        """The leaves that stand for classes of the user's."""
        return tuple(self._any_behaviours)

    @property
    def abstracted(self) -> Iterator[str]:
        """The loops and deadlines that are abstract, as text."""
        for name, count in self.opened.items():
            yield f"'{name}' may end after any of its {count:,} rounds"
        for node in self._loose:
            yield f"'{node.name}' may be over at any tick"
        for topic in self._topics.values():
            if topic.is_aged:
                yield f"the last message of {topic.name} may be too old at any tick"

    @property
    def has_loose_deadlines(self) -> bool:
        """Is a deadline abstract, so that some explored runs may not exist?"""
        return bool(self._loose) or any(topic.is_aged for topic in self._topics.values())

    @property
    def reason(self) -> str:
        """Why the mission has ended; goals that it leaves behind are named only without others."""
        return own_reason(self.executive) or without_times(self.executive.reason)[: len(ORPHANED)]

    # ---- one step ---------------------------------------------------------------------------

    @property
    def is_done(self) -> bool:
        """Has the mission ended?"""
        return self.executive.is_done

    def step(self, script: Script) -> bool:
        """Take one step by a script; return whether it is within the bound on faults."""
        self.choices.begin(script)
        self.entered.clear()
        self._visited.clear()
        self._used.clear()
        self._used += [server for server in self._goal_servers.values() if server.goals]
        self._used += [service for service in self._services.values() if service.calls]
        self._keeper.begin()
        self.is_stuck = self.is_quiet = self.has_answered = False
        before, lost = self._moment.limits, self.keys.lost_goals
        executive, running = self.executive, MissionStatus.RUNNING
        was_running = executive.status is running
        is_settled = not was_running and not executive.cleanups.is_pending
        is_allowed = self._step(before)
        if was_running and executive.status is running:
            self._note_changed(is_allowed=is_allowed)
        elif is_settled:
            self._keeper.touch(self._used)
        else:
            self._keeper.touch_all()
        self.has_lost = not self.keys.lost_goals <= lost
        return is_allowed

    def wait(self, ticks: int) -> int:
        """Have ticks pass between two steps as far as no limit is over; return how many."""
        free = [(due.at_ns - self.now_ns - 1) // TICK_NS - 1 for due in self.limits]
        waited = max(0, min([ticks, *free]))
        self._moment.now_ns += waited * TICK_NS
        return waited

    def _note_changed(self, *, is_allowed: bool) -> None:
        """Note what the step has changed; a tick may have been cut short by the bound on faults."""
        touch, inner_of = self._keeper.touch, self._inner_of
        touch(self._visited)
        touch(self._used)
        if not is_allowed:
            running = Status.RUNNING
            touch([node for node in self.executive.nodes if node.status is running])
            touch(inner_of.values())
        elif inner_of:
            touch([inner_of[node] for node in self._visited if node in inner_of])

    def _step(self, before: tuple[Due, ...]) -> bool:
        try:
            if self.now_ns == START_NS:
                self._publish_first()
                self._tick(before)  # random choices of this tick are part of the script
            elif self._answer():
                self._note_limits()
                self._tick(before)
            else:
                self._let_time_pass()
        except OutOfFaultsError:
            return False
        return True

    def _publish_first(self) -> None:
        """Have messages come before the first tick, or not."""
        for topic in self._topics.values():
            for question in topic.questions():
                option = question[self.choices.choose(question)]
                if option.act is not None:
                    option.act()

    def _answer(self) -> bool:
        """Have everything that may happen before the next tick happen, or not."""
        has_happened = False
        for server in self._goal_servers.values():
            server.refuse_again()
        self._owing = [(entry, entry.delays) for entry in self.owing]
        questions, open_limits = self._all_questions()
        for question in questions:
            option = question[self.choices.choose(question)]
            if option.act is not None:
                option.act()
                has_happened |= bool(option.words)
                self.has_answered |= option.is_event and bool(option.words)
        for due, question in open_limits:
            if not self._limits.is_moot(due):
                option = question[self.choices.choose(question)]
                if option.act is not None:
                    option.act()
                    has_happened = True
        return has_happened

    def _all_questions(self) -> Asked:
        """Return what may happen; a state that is put back several times is asked once."""
        present, self._present = self._present, None
        state, asked = self._asked
        if present is None or state is not present:
            asked = list(self.questions()), list(self._open_limits())
            self._asked = present, asked
        return asked

    def _open_limits(self) -> Iterator[tuple[Due, Question]]:
        """Yield the limits that may be over with the next tick."""
        for due in self._moment.open:
            faults = self._limits.faults_of(due)
            if faults != NEVER and not self._limits.is_renewed(due):
                words = due.words or "a limit is over"
                yield due, (NOTHING, Possibility(words, int(faults), partial(self._end, due)))

    def questions(self) -> Iterator[Question]:
        """Yield what may happen before the next tick, in a fixed order."""
        for server in self._goal_servers.values():
            yield from server.questions()
        for service in self._services.values():
            yield from service.questions()
        for topic in self._topics.values() if self._reads_topics else ():
            yield from topic.questions()
        for leaf in self._any_behaviours:
            yield from leaf.questions()
        for node, words in self._loose.items():
            if is_limited(node) and self._may_be_late(node):
                late = int(isinstance(node, ActionLeaf))
                yield NOTHING, Possibility(words, late, partial(self._meet, node))
        if self._moment.may_interrupt and self.executive.status is MissionStatus.RUNNING:
            yield NOTHING, Possibility(INTERRUPT, 0, self._interrupt)

    @property
    def _reads_topics(self) -> bool:
        """May a node or a requirement still read a message?"""
        executive = self.executive
        is_over = executive.status is not MissionStatus.RUNNING
        return not is_over or executive.cleanups.is_pending or self.requirements.is_used

    def _meet(self, node: Loose) -> None:
        """Have an abstract deadline met by the next tick."""
        meet(node, self.now_ns + TICK_NS)

    def _end(self, due: Due) -> None:
        """Have a limit be over with the next tick, unless it is not running any more."""
        running = {(entry.owner, entry.node) for entry in self._limits.running(self.now_ns)}
        if (due.owner, due.node) in running:
            self._limits.move(due, self.now_ns + TICK_NS)

    def _may_be_late(self, node: Loose) -> bool:
        if not isinstance(node, ActionLeaf):
            return True
        server = self._limits.working_for(node)
        return bool(server) and self.answers.is_ever_late(server)

    def _interrupt(self) -> None:
        self._moment.may_interrupt = False
        self.executive.interrupt("interrupted by Ctrl-C")

    def _let_time_pass(self) -> None:
        """Tick; where that changes nothing, go to the last tick before the next limit.

        So an answer may come long before a limit, and in the very tick in which it is over. It is
        not late then: nothing has come before it.
        """
        moment = self._moment
        before, limits = moment.untimed, moment.limits
        self._tick(limits)
        self.is_quiet = moment.untimed == before
        if not self.is_quiet:
            return
        for entry, delays in self._owing:
            entry.delays = delays
        moment.delays = tuple([delays for _, delays in self._owing])
        due = moment.limits
        if not due and self._all_questions() != ([], []):
            self.choices.meet((), (), NEVER)  # somebody has to answer
        if self._owing:
            self._wait_for_answers(limits)
        if not due:
            self.is_stuck = True
            return
        ticks = -(-(min([entry.at_ns for entry in due]) - self.now_ns) // TICK_NS)
        self._moment.now_ns += max(0, ticks - 1) * TICK_NS

    def _wait_for_answers(self, before: tuple[Due, ...]) -> None:
        """Let answers come behind the next limit, unless that is over for want of them.

        Args:
            before: The limits that were running before the tick.
        """
        running = {(due.owner, due.at_ns) for due in self._moment.limits}
        kept = [index for index, due in enumerate(before) if (due.owner, due.at_ns) in running]
        first_ns = min([before[index].at_ns for index in kept], default=0)
        are_first = tuple([before[index].at_ns <= first_ns for index in kept])
        firsts = [before[index] for index in kept if before[index].at_ns <= first_ns]
        is_owed = all(self._limits.faults_of(due) == NEVER for due in firsts)
        self.choices.meet(tuple(kept), are_first, NEVER if is_owed else 0, is_order=True)

    def _tick(self, before: tuple[Due, ...]) -> None:
        """Let a tick pass.

        Args:
            before: The limits that were running when the step began.
        """
        until_ns = self.now_ns + TICK_NS
        self._meet_limits(before, until_ns)
        self.ticked_ns = self._moment.now_ns = until_ns
        for topic in self._topics.values():
            topic.beat()
        self._limits.age(until_ns)
        for server in self._goal_servers.values():
            server.beat()
        self.executive.tick()
        self.requirements.step(self.now_ns)
        for node in self._loose:
            keep_open(node)
        for server in self._goal_servers.values():
            server.adopt(self._action_leaves)
        for service in self._services.values():
            service.is_seen = False
        if self._limits.are_all_open:
            self._moment.open = self._limits.open(until_ns)
        self._moment.untimed = self._untimed_key()
        owing = () if self.executive.is_done else self.owing
        self._moment.delays = tuple([entry.delays for entry in owing])
        self._note_limits()

    def _note_limits(self) -> None:
        if not self._limits.are_all_open:
            self._moment.limits = self._limits.running(self.now_ns)

    def _meet_limits(self, before: tuple[Due, ...], until_ns: int) -> None:
        """Count the faults of the limits that are over with the next tick."""
        limits = self._moment.limits
        if not limits:
            return
        met = [due for due in limits if due.at_ns <= until_ns]
        indices: Sequence[int] = range(len(before))
        if limits is not before:
            began = {(due.owner, due.at_ns): index for index, due in enumerate(before)}
            kept = [began.get((due.owner, due.at_ns)) for due in limits]
            indices = [index for index in kept if index is not None]
        self.choices.meet(
            tuple(indices),
            tuple([before[index].at_ns <= until_ns for index in indices]),
            max(map(self._limits.faults_of, met), default=0),
        )
        names = ", ".join(dict.fromkeys(due.words for due in met if due.words))
        if names:
            self.choices.words.append(f"time passes: {names}")

    # ---- the state --------------------------------------------------------------------------

    @property
    def moved_parts(self) -> set[str]:
        """The parts that the goals of the mission are known to move."""
        return {part for leaf in self._action_leaves for part in self._moved_parts(leaf)}

    @property
    def unaccounted(self) -> list[tuple[str, str]]:
        """Goals that a server works on and that the ledger does not hold: actions and leaves."""
        held = self.ledger.open_goals
        return [
            (server.name, served.goal.owner)
            for server in self._goal_servers.values()
            for served in server.goals
            if served.is_live and not any(goal is served.goal for goal in held)
        ]

    @property
    def skipped_cleanups(self) -> list[str]:
        """Clean-ups that are due and have not ended; none may be when the mission has ended."""
        return [node.name for node in self.keys.finals if node.limit_s > 0]

    @property
    def silent_leaves(self) -> list[Behaviour]:
        """The leaves that wait for a server for which no limit is set at all."""
        if self._moment.limits or self._moment.open or any(map(is_limited, self._loose)):
            return []
        if any(topic.ages_left for topic in self._topics.values()):
            return []
        if any(map(is_between_rounds, self.executive.nodes)):
            return []
        waiting: list[Behaviour] = [
            leaf
            for leaf in self._action_leaves
            if leaf.status is Status.RUNNING and self._limits.has_working_server(leaf)
        ]
        waiting += self._any_behaviours_running
        waiting += [node for node in self._waits if node.status is Status.RUNNING]
        return waiting

    @property
    def endless_leaves(self) -> list[Behaviour]:
        """The leaves that may wait for ever, if other limits run and begin again for ever."""
        return [leaf for leaf in self._unlimited if self._limits.may_run_for_ever(leaf)]

    @property
    def _any_behaviours_running(self) -> list[AnyBehaviour]:
        return [leaf for leaf in self._any_behaviours if leaf.status is Status.RUNNING]

    @property
    def shape(self) -> bytes:
        """The state without its times, as a hash, with the names of the limits."""
        moment = self._moment
        names = [due.words for due in self.limits]
        whole = marshal.dumps((moment.untimed, moment.delays, names), 2)
        return blake2b(whole, digest_size=16).digest()

    @property
    def limits(self) -> tuple[Due, ...]:
        """The limits that are running."""
        return self._moment.limits

    @property
    def is_timed(self) -> bool:
        """May it make a difference when the last answer came?"""
        executive, limits = self.executive, self.limits
        is_over = executive.status is not MissionStatus.RUNNING
        if not self.has_answered or (is_over and not executive.cleanups.is_pending):
            return False
        return len(limits) > 1 or not all(map(self.is_alone, limits))

    def is_alone(self, due: Due) -> bool:
        """Is it of a leaf beside which nothing else runs?"""
        return due.node in self._alone

    def _untimed_key(self) -> Any:
        requirements = self.requirements.key
        if self.executive.is_done:
            return (*end_key(self.executive), requirements)
        return (self._moment.may_interrupt, *self.keys.untimed(), requirements)

    # ---- taking and putting back ------------------------------------------------------------

    def save(self) -> Memento:
        """Return everything that a step may change."""
        return self._keeper.take()

    def restore(self, memento: Memento, faults_left: float) -> None:
        """Put it back."""
        self._keeper.put_back(memento)
        self.choices.faults_left = faults_left
        self._present = memento

    def _changing(self) -> Iterable[Any]:
        """Return the objects that any step may change."""
        executive = self.executive
        return (
            self._moment,
            executive,
            executive.cleanups,
            executive.followed,
            *executive.followed.variables,
            self.ledger,
            *self.keys.finals,
            self.scope,
            *(node.inner for node, _ in self.keys.subtrees if node not in self._inner_of),
            *self._topics.values(),
            *self._speeches.values(),
            *self.requirements.kept,
        )

    def _changing_by_use(self) -> Iterable[Any]:
        """Return the objects that change only where a step uses them."""
        return (
            *self.executive.nodes,
            *self._inner_of.values(),
            *self._goal_servers.values(),
            *self._services.values(),
        )

    def _dynamic(self) -> Iterator[Any]:
        for leaf in self._action_leaves:
            if leaf.attempt is not None:
                yield leaf.attempt
                if leaf.attempt.goal is not None:
                    yield leaf.attempt.goal
        yield from self.ledger.open_goals
        for server in self._goal_servers.values():
            for served in server.goals:
                yield served
                yield served.goal
