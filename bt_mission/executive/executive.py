"""Runs a mission: ticks its tree, and ends it with every goal accounted for.

The executive is driven by :meth:`Executive.tick`, called at the tick rate by a timer on the ROS
clock. It goes through three stages: it ticks the tree until the root has a final status (or an
exception, or an interruption halts it); it waits until the ledger has seen every goal to its
confirmed end, which is bounded by the ledger's grace period; then it is done.

It can be paused: then the tree is not ticked, or one tick at a time. Goals that are still under way
keep their limits and conditions, and those that nobody wants are still seen to their end. A
breakpoint pauses it in the middle of a tick, just before a node starts.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.errors import BtMissionError, callback_failure, cause_of
from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.follow import FollowedVariables, scopes_of
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.revision import Graft
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.executive.breakpoints import Breakpoints
from bt_mission.executive.cleanups import Cleanups
from bt_mission.executive.events.events import (
    AT_BREAKPOINT,
    EventStream,
    GoalChanged,
    NodeChanged,
    NodesReset,
    NotTested,
    RunStarted,
    StateChanged,
    TreeRevised,
)
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.goals.goal import Goal, state_of
from bt_mission.executive.goals.poses import poses_of
from bt_mission.executive.listeners import Listeners
from bt_mission.executive.numbered_tree import NumberedTree
from bt_mission.executive.status import MissionStatus
from bt_mission.executive.trace import Trace

if TYPE_CHECKING:
    from bt_mission.executive.journal.recovery import Recovery


ENDED = (Status.SUCCESS, Status.FAILURE)


class Executive:
    """Ticks one tree until it ends.

    Everything that happens is emitted as an event. A subscriber that raises an exception gets no
    more events, and the mission fails with the cause.

    Args:
        root: The tree; its nodes' ``setup`` is called here.
        runtime: Time, ledger, variables and clients for the leaves.
        trace: Gets the events first.
        observe_s: The time for which time continues after the end, with no goal under way, s.
        mission: The mission's name.
        details: The details of each node by its path.

    Raises:
        BtMissionError: A node cannot be set up, for example because of an unknown action type.
    """

    def __init__(
        self,
        root: Behaviour,
        runtime: Runtime,
        trace: Trace,
        observe_s: float = 0.0,
        mission: str = "",
        details: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        self.mission = mission
        self.run = secrets.token_hex(8)
        """Identifies the run."""
        self.status = MissionStatus.RUNNING
        self.reason = ""
        """Why it is paused, or has ended."""
        self.ticks = 0
        self.cycles = 0
        self.started_ns = 0
        """ROS time of the first tick, ns; 0 before it."""
        self.ended_ns = 0
        """ROS time of the end, ns; 0 before it. An observation may follow."""
        self.is_resumable = False
        """Whether it failed because a server took this process for dead. A journal can then be
        resumed.
        """
        self.steps = 0
        """The number of calls of :meth:`step`."""
        self.verdict = MissionStatus.FAILURE
        """The verdict of the mission, also while it is ending."""
        self.observe_s = observe_s
        self.flaws: Callable[[], Sequence[str]] = tuple
        """Returns why the run is not valid, however the tree ends; a line each."""
        self.untested: list[Callable[[], Iterable[str]]] = []
        """Each returns what was planned for the run and has not happened, a line each."""
        self.revisions = 0
        """The number of revisions of the mission since its start."""
        self._runtime = runtime
        self._set_tree(NumberedTree.of(root, details or {}))
        self.events = EventStream()
        self.mission_state = MissionState()
        """The state that follows from the events so far."""
        self.after_tick: Listeners[[]] = Listeners()
        self.tick_wrappers: list[Callable[[Iterator[Behaviour]], Iterator[Behaviour]]] = []
        """Wrappers of each tick's walk, for callers that need every node that it visits."""
        self._raised = (self.events.raised, trace.lines.raised)
        self._has_started = self._keep_goals = self._is_step_due = False
        self._known = dict.fromkeys(self.paths, Status.INVALID)
        self._running: dict[Behaviour, None] = {}
        self._reset: list[Behaviour] = []
        """Nodes that had ended and have been reset in this tick."""
        self._walk: Iterator[Behaviour] | None = None
        self._recovery: Recovery | None = None
        self.breakpoints = Breakpoints(self.paths)
        self._known[self.breakpoints.mark] = Status.RUNNING  # never its status, so always noted
        self.cleanups = Cleanups(self.paths, runtime.ledger, self.breakpoints.mark)
        self._follow(trace)
        for node in root.iterate():
            node.setup(runtime=runtime)
        self.followed = FollowedVariables(scopes_of(root, runtime.scope), runtime)

    def _set_tree(self, tree: NumberedTree) -> None:
        self.root, self.paths, self._nodes = tree.root, tree.paths, tree.nodes
        self.indices, self.node_infos = tree.indices, tree.infos

    def _follow(self, trace: Trace) -> None:
        """Have trace and state take the events, and the ledger and the nodes cause them."""
        trace.follow(self.events, self.node_infos)
        self.mission_state.apply(RunStarted(0, self.run, self.mission, self.node_infos))
        self.mission_state.state = self.state_event()
        self.events.subscribe(self.mission_state.apply)
        self._runtime.ledger.on_event = self._on_goal
        for node in self._nodes:
            if isinstance(node, Hooked):
                node.resets = self._reset

    @property
    def is_done(self) -> bool:
        """Whether the mission has ended, with every goal accounted for."""
        return self.status.is_final

    @property
    def now_ns(self) -> int:
        """ROS time, ns; during a tick, the time of its start."""
        return self._runtime.now_ns

    @property
    def goals_sent(self) -> int:
        """The number of goals sent."""
        return self._runtime.ledger.goals_sent

    @property
    def goals_left_behind(self) -> tuple[str, ...]:
        """A line for each goal whose end was not confirmed; empty after a clean end."""
        return self._runtime.ledger.describe_left_behind()

    def tick(self) -> None:
        """Tick the tree once, or wait until the last goals have ended."""
        if self.status.is_final:
            return
        self.cycles += 1
        now_ns = self._runtime.now_ns
        self.followed.update()
        if now_ns and not self._has_started:
            self.announce(self.started_ns or now_ns)
        self._beat(now_ns)
        if self.status is MissionStatus.PAUSED:
            self._note_pause()
        raised, by_lines = self._raised
        raised += self.after_tick.notify()
        if raised or by_lines:
            self._end_by_callbacks()

    def announce(
        self, time_ns: int, world: str | None = None, robot: str = "", seed: int = 0
    ) -> None:
        """Emit that the run has started, unless it was emitted before."""
        if not self._has_started:
            self._has_started = True
            self.events.emit(
                RunStarted(time_ns, self.run, self.mission, self.node_infos, world, robot, seed)
            )

    def _beat(self, now_ns: int) -> None:
        if self.status is MissionStatus.RECOVERING:
            self._recover()
        elif self.status is MissionStatus.RUNNING or self._is_step_due:
            self.started_ns = self.started_ns or now_ns
            self._is_step_due = False
            self._tick_tree()
        elif self.status is MissionStatus.PAUSED:
            self._supervise_goals()
        elif self.cleanups.is_pending:
            for node in self.cleanups.walk():
                if node.status is not self._known[node]:
                    self._note(node)
            self._note_halted()
        self._runtime.ledger.update(now_ns)
        if self.status is MissionStatus.OBSERVING and (
            now_ns - self.ended_ns >= round(self.observe_s * NS)
        ):
            self._close()
        if (
            self.status is MissionStatus.ENDING
            and self._runtime.ledger.is_settled
            and not self.cleanups.is_pending
        ):
            is_whole = self.verdict is not MissionStatus.INTERRUPTED
            self._finish(observe_s=self.observe_s if is_whole else 0.0)

    def resume_from(self, recovery: Recovery) -> None:
        """Begin where another process stood, instead of at the root."""
        self._recovery, self.status = recovery, MissionStatus.RECOVERING
        self.mission_state.state = self.state_event()

    def interrupt(self, reason: str) -> None:
        """Halt the tree and cancel every goal; later ticks wait until they end."""
        if self.status.is_active:
            self._end(MissionStatus.INTERRUPTED, reason)
        elif self.status is MissionStatus.OBSERVING:
            self._cut_observation(reason)

    def fail(self, reason: str) -> None:
        """End the mission as failed for a reason from outside the tree."""
        if self.status.is_active:
            self._end(MissionStatus.FAILURE, reason)

    def abandon(self, reason: str) -> None:
        """End at once, without waiting; the reason names the orphaned goals."""
        if self.status.is_final:
            return
        if self.status is MissionStatus.OBSERVING:
            self._cut_observation(reason)
            return
        if self.status.is_active:
            self._end(MissionStatus.FAILURE, reason)
        else:
            self.reason = "; ".join(filter(None, (self.reason, reason)))
        self.cleanups.skip(reason or "the mission was abandoned")
        self._note_halted()
        self._runtime.ledger.update(self._runtime.now_ns)
        self._finish(observe_s=0.0)

    # ---- pausing -------------------------------------------------------------------------

    @property
    def nodes(self) -> tuple[Behaviour, ...]:
        """Every node, depth first."""
        return self._nodes

    @property
    def running_nodes(self) -> Collection[Behaviour]:
        """The nodes that run, in the order in which they started."""
        return self._running.keys()

    @property
    def running_leaves(self) -> list[Behaviour]:
        """The leaves that run, in the order in which they started."""
        return [node for node in self._running if not node.children]

    def pause(self, reason: str, *, keep_goals: bool = False) -> None:
        """Stop ticking the tree until it is resumed. ROS time, and with it every limit, continues.

        Args:
            keep_goals: Let goals run: their limits and conditions, and each `timeout` and `guard`
                around them, can still cancel them, and the next tick reads the outcome. Otherwise
                they are cancelled now, and their leaves start again after the pause.
        """
        if self.status not in (MissionStatus.RUNNING, MissionStatus.PAUSED):
            return
        self.status, self.reason, self._keep_goals = MissionStatus.PAUSED, reason, keep_goals
        self._emit_state()
        if not keep_goals:
            for leaf in self._goal_leaves:
                if not leaf.has_outcome:
                    leaf.stop(Status.INVALID)
            self._note_halted()

    def resume(self) -> None:
        """Continue after a pause."""
        if self.status is MissionStatus.PAUSED:
            self.status, self.reason, self._is_step_due = MissionStatus.RUNNING, "", False
            self._emit_state()

    def step(self) -> None:
        """While paused: run one tick, or the rest of the tick that a breakpoint stopped."""
        if self.status is MissionStatus.PAUSED:
            self._is_step_due = True
            self.steps += 1

    # ---- revising ------------------------------------------------------------------------

    @property
    def why_not_revisable(self) -> str:
        """Why the tree cannot be exchanged now; empty if it can."""
        if self.status is MissionStatus.RECOVERING:
            return "the mission is being resumed; try again when it runs"
        if not self.status.is_active:
            return f"the mission is {self.status}: only a running mission can change"
        if self._walk is not None:
            return "a breakpoint holds the mission within a tick; step or resume it first"
        return ""

    def revise(self, graft: Graft, tree: NumberedTree, summary: str = "") -> None:
        """Exchange the tree for another one, between two ticks.

        Args:
            graft: The tree with the state of the present one.
            tree: Its nodes.
            summary: What changes, as text.
        """
        pairs, known, indices = graft.pairs, self._known, self.indices
        errors = graft.commit()
        self._note_halted()
        self._set_tree(tree)
        self._runtime.scope = graft.scope
        graft.followed.leave_others(self.followed)
        self.followed = graft.followed
        before = {new: old for old, new in pairs.items()}
        self._known = {
            node: known[before[node]] if node in before else Status.INVALID for node in self._nodes
        }
        self._running = {pairs[node]: None for node in self._running if node in pairs}
        for behaviour in graft.fresh:
            behaviour.resets = self._reset
        self.breakpoints.move(self.paths)
        self._known[self.breakpoints.mark] = Status.RUNNING
        failures, departed = self.cleanups.failures, self.cleanups.departed
        self.cleanups = Cleanups(
            self.paths,
            self._runtime.ledger,
            self.breakpoints.mark,
            (*departed, *graft.departed),
        )
        self.cleanups.failures.update(failures)
        self.revisions += 1
        kept = tuple(indices[before[node]] if node in before else -1 for node in self._nodes)
        self.events.emit(
            TreeRevised(
                self._runtime.now_ns,
                self.run,
                self.mission,
                self.node_infos,
                kept,
                self.revisions,
                summary,
                self.started_ns,
                self.cycles,
                graft.is_kept,
            )
        )
        for node in self._nodes:
            if node.status is not self._known[node]:
                self._note(node)
        if errors:
            self._end(MissionStatus.FAILURE, "; ".join(errors))

    # ---- looking -------------------------------------------------------------------------

    def path_of(self, node: Behaviour) -> str:
        """The place of a node in the tree, such as ``0.1.0``."""
        return self.paths[node]

    # ---- inside --------------------------------------------------------------------------

    def _on_goal(self, time_ns: int, change: str, goal: Goal) -> None:
        if change == "sent":
            goal.targets = tuple(poses_of(goal.request))
        self.events.emit(
            GoalChanged(
                time_ns,
                goal.id.hex(),
                goal.goal_client.name,
                goal.owner,
                goal.sent_ns,
                state_of(goal),
                change,
                goal.targets,
            )
        )

    def state_event(self) -> StateChanged:
        """Return the present state as an event."""
        is_observing = self.status is MissionStatus.OBSERVING
        is_paused = self.status is MissionStatus.PAUSED
        return StateChanged(
            self._runtime.now_ns,
            self.run,
            self.mission,
            str(self.status),
            self.reason,
            self._runtime.ledger.describe_under_way() if is_paused else (),
            is_paused and self._keep_goals,
            str(self.verdict) if is_observing else "",
            self.observe_s if is_observing else 0.0,
        )

    def _emit_state(self, *, is_update: bool = False) -> None:
        self.events.emit(replace(self.state_event(), is_update=is_update))

    def _note_pause(self) -> None:
        """Emit which goals are still under way in a pause, whenever that changes."""
        known = self.mission_state.state
        if known is None or self._runtime.ledger.describe_under_way() != known.under_way:
            self._emit_state(is_update=True)

    def _end_by_callbacks(self) -> None:
        """Fail because of callbacks that raised; after the mission's end, only name them."""
        if self.status is MissionStatus.ENDING:
            return  # `_finish` names them
        broken = "; ".join(self._take_raised())
        if self.status.is_final:
            self.reason = "; ".join(filter(None, (self.reason, broken)))
            self._emit_state()
        self.fail(broken)

    def _take_raised(self) -> list[str]:
        causes = [callback_failure(cause) for some in self._raised for cause in some]
        for some in self._raised:
            some.clear()
        return causes

    @property
    def _goal_leaves(self) -> list[ActionLeaf]:
        return [leaf for leaf in self.running_leaves if isinstance(leaf, ActionLeaf)]

    def _supervise_goals(self) -> None:
        try:
            for node in self._nodes:
                if isinstance(node, Subtree) and node.status is Status.RUNNING:
                    node.take_inputs()
            for leaf in self._goal_leaves:
                leaf.supervise()
        except Exception as error:  # noqa: BLE001 - a condition may raise as in a tick
            self._end(MissionStatus.FAILURE, cause_of(error))

    def _tick_tree(self) -> None:
        try:
            if self._walk is None:
                if not self.followed.are_there():
                    return
                self.ticks += 1
                self._walk = self._begin_walk()
            known = self._known
            for node in self._walk:
                if node.status is not known[node]:
                    if node is self.breakpoints.mark:
                        self._break()
                        return
                    self._note(node)
            self._walk = None
            self._note_halted()
        except Exception as error:  # noqa: BLE001 - a user's leaf may raise anything
            self._end(MissionStatus.FAILURE, cause_of(error))
        else:
            if self.root.status is Status.SUCCESS:
                self._end(MissionStatus.SUCCESS, "")
            elif self.root.status is not Status.RUNNING:
                culprit = self.nodes[self.mission_state.failure_path()[-1]]
                self.is_resumable = isinstance(culprit, ActionLeaf) and culprit.was_cut_off
                message = culprit.feedback_message or "failed"
                self._end(MissionStatus.FAILURE, f"'{culprit.name}' {message}")

    def _begin_walk(self) -> Iterator[Behaviour]:
        walk = self.cleanups.before(self.root.tick())
        for wrap in self.tick_wrappers:
            walk = wrap(walk)
        return walk

    def _break(self) -> None:
        """Stop in the middle of a tick."""
        node = self.breakpoints.reached
        assert node is not None
        self._note_halted()
        self.pause(AT_BREAKPOINT.format(node.name))

    def _recover(self) -> None:
        assert self._recovery is not None, "its status says so"
        try:
            if not self._recovery.is_done():
                return
            self._recovery.finish(self.paths)
        except BtMissionError as error:
            self._end(MissionStatus.FAILURE, f"cannot be resumed: {error}")
            return
        self.status, self._recovery = MissionStatus.RUNNING, None
        self.started_ns = self._runtime.now_ns
        self._emit_state()
        for node in self.paths:
            if node.status is not self._known[node]:
                self._note(node)

    def _note_halted(self) -> None:
        """A node that the tree halts is not visited by the tick, but has changed all the same."""
        running = Status.RUNNING
        for node in [node for node in self._running if node.status is not running]:
            self._note(node)
        if self._reset:
            self._note_reset()

    def _note_reset(self) -> None:
        """Emit the ended nodes that have been reset, and have not ended again in this tick."""
        reset = {node for node in self._reset if node.status is Status.INVALID}
        self._reset.clear()
        indices = sorted(self.indices[node] for node in reset if self._known[node] in ENDED)
        if indices:
            self._known |= dict.fromkeys((self.nodes[index] for index in indices), Status.INVALID)
            self.events.emit(NodesReset(self._runtime.now_ns, tuple(indices)))

    def _note(self, node: Behaviour) -> None:
        self._known[node] = node.status
        if node.status is Status.RUNNING:
            self._running[node] = None
        else:
            self._running.pop(node, None)
        self.events.emit(
            NodeChanged(
                self._runtime.now_ns, self.indices[node], node.status, node.feedback_message
            )
        )

    def _end(self, verdict: MissionStatus, reason: str) -> None:
        """Stop what runs, and wait from now on for the goals that are still open."""
        reason = "; ".join(filter(None, (reason, *self.cleanups.halt_tree(self.root))))
        self.status, self.verdict, self.reason = MissionStatus.ENDING, verdict, reason
        self._walk = self._recovery = None
        self._is_step_due = False
        self._note_halted()
        self._emit_state()

    def _finish(self, observe_s: float) -> None:
        left = self.goals_left_behind
        orphans = [f"orphaned goals: {', '.join(left)}"] if left else []
        self._add_wrong([*self.cleanups.failures, *self._take_raised(), *orphans])
        self.observe_s = observe_s
        self.ended_ns = self._runtime.now_ns
        if not observe_s:
            self._close()
            return
        self.status = MissionStatus.OBSERVING
        self._emit_state()

    def _add_wrong(self, wrong: Sequence[str]) -> None:
        """Add what is wrong to the reason; the mission has then failed."""
        if wrong:
            self.reason = "; ".join(filter(None, (self.reason, *wrong)))
            if self.verdict is MissionStatus.SUCCESS:
                self.verdict = MissionStatus.FAILURE

    def _close(self) -> None:
        for what in (line for lines in self.untested for line in lines()):
            self.events.emit(NotTested(self._runtime.now_ns, what))
        self._add_wrong(self.flaws())
        self.status = self.verdict
        self._emit_state()

    def _cut_observation(self, reason: str) -> None:
        observed_s = (self._runtime.now_ns - self.ended_ns) / NS
        cut = f"observed for {observed_s:g} s of {self.observe_s:g} s: {reason}"
        self.reason = "; ".join(filter(None, (self.reason, cut)))
        self._close()
