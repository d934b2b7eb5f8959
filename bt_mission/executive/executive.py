"""Carries a mission out: ticks its tree, and ends it with every goal accounted for.

The executive is driven by :meth:`Executive.tick`, called at the tick rate by a timer on the ROS
clock. It goes through three stages: it ticks the tree until the root has a final status (or an
exception, or an interruption halts it); it waits until the ledger has seen every goal to its
confirmed end, which is bounded by the ledger's grace period; then it is done.

It can be paused: then the tree is not ticked, or one tick at a time. Goals that are still under way
keep their limits and conditions, and those that nobody wants are still seen to their end. A
breakpoint pauses it in the middle of a tick, just before a node starts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, ParamSpec

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.follow import FollowedVariables
from bt_mission.behaviours.runtime import Runtime
from bt_mission.core.errors import BtMissionError, cause_of
from bt_mission.core.listeners import Listeners
from bt_mission.core.stamps import NS
from bt_mission.executive.breakpoints import Breakpoints
from bt_mission.executive.cleanups import Cleanups
from bt_mission.executive.node_states import NodeStates
from bt_mission.executive.status import Change, MissionStatus, failed_node, node_paths
from bt_mission.executive.trace import Trace
from bt_mission.goals.goal import Goal

if TYPE_CHECKING:
    from bt_mission.executive.journal.recovery import Recovery


FINAL = (MissionStatus.SUCCESS, MissionStatus.FAILURE, MissionStatus.INTERRUPTED)

P = ParamSpec("P")


class Executive:
    """Ticks one tree to its end.

    A listener that raises an exception is called no more, and the mission fails with the cause.

    Args:
        root: The tree; its nodes' ``setup`` is called here.
        runtime: Time, ledger, variables and clients for the leaves.
        trace: Told of every change of status and every event of a goal.
        observe_s: For so long time goes on after the end, with no goal under way.

    Raises:
        BtMissionError: When a node cannot be set up, such as an unknown action type.
    """

    def __init__(
        self, root: Behaviour, runtime: Runtime, trace: Trace, observe_s: float = 0.0
    ) -> None:
        self.root = root
        self.status = MissionStatus.RUNNING
        self.reason = ""
        self.ticks = 0
        self.cycles = 0
        self.started_ns = 0
        """ROS time of the first tick, ns; 0 before it."""
        self.ended_ns = 0
        """ROS time of the end, ns; 0 before it. An observation may follow."""
        self.is_resumable = False
        """Did it fail because a server took this process for dead? A journal can go on then."""
        self.paused: str | None = None
        """Why it is paused; None while it is not."""
        self.steps = 0
        """How often :meth:`step` was called."""
        self.node_states = NodeStates(root, lambda: self.status is MissionStatus.RUNNING)
        self.listeners: Listeners[[Change]] = Listeners([self.node_states.on_change])
        self.goal_listeners: Listeners[[str, Goal]] = Listeners()
        runtime.ledger.on_event = self._on_goal
        self.after_tick: Listeners[[]] = Listeners()
        self.tick_wrappers: list[Callable[[Iterator[Behaviour]], Iterator[Behaviour]]] = []
        """Put around each tick's walk, by who wants to see every node that it visits."""
        self._runtime = runtime
        self._trace = trace
        self.verdict = MissionStatus.FAILURE
        """How the mission has ended, or is about to."""
        self.observe_s = observe_s
        self._raised = trace.raised
        self._paths = node_paths(root)
        self._known = dict.fromkeys(self._paths, Status.INVALID)
        self._running: dict[Behaviour, None] = {}
        self._walk: Iterator[Behaviour] | None = None
        self._steps = 0
        self._recovery: Recovery | None = None
        self.breakpoints = Breakpoints(self._paths)
        self._known[self.breakpoints.mark] = Status.RUNNING  # never its status, so always noted
        self.cleanups = Cleanups(self._paths, runtime.ledger, self.breakpoints.mark)
        for node in root.iterate():
            node.setup(runtime=runtime)
        self._followed = FollowedVariables(root, runtime)

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""
        return self.status in FINAL

    @property
    def now_ns(self) -> int:
        """ROS time, ns; during a tick that of its start."""
        return self._runtime.now_ns

    @property
    def goals_sent(self) -> int:
        """How many goals were sent so far."""
        return self._runtime.ledger.goals_sent

    @property
    def goals_left_behind(self) -> tuple[str, ...]:
        """A line for each goal that nobody confirmed as ended; empty after a clean end."""
        return self._runtime.ledger.describe_left_behind()

    def tick(self) -> None:
        """Tick the tree once, or see the last goals to their end."""
        if self.is_done:
            return
        self.cycles += 1
        self._followed.update()
        self._beat()
        self._notify(self.after_tick)
        if self._raised:
            self._end_by_listeners()

    def _beat(self) -> None:
        if self._recovery is not None:
            self._recover(self._recovery)
        elif self.status is MissionStatus.RUNNING:
            self.started_ns = self.started_ns or self._runtime.now_ns
            if self.paused is None or self._steps > 0:
                self._steps = 0
                self._tick_tree()
            else:
                self._supervise_goals()
        elif self.cleanups.is_pending:
            for node in self.cleanups.walk():
                if node.status is not self._known[node]:
                    self._note(node)
            self._note_halted()
        self._runtime.ledger.update(self._runtime.now_ns)
        observed_ns = self._runtime.now_ns - self.ended_ns
        if self.status is MissionStatus.OBSERVING and observed_ns >= round(self.observe_s * NS):
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
        self._recovery = recovery

    def interrupt(self, reason: str) -> None:
        """Halt the tree and cancel every goal; later ticks see them to their end."""
        if self.status is MissionStatus.RUNNING:
            self._end(MissionStatus.INTERRUPTED, reason)
        elif self.status is MissionStatus.OBSERVING:
            self._cut_observation(reason)

    def fail(self, reason: str) -> None:
        """End the mission as failed for a reason from outside the tree."""
        if self.status is MissionStatus.RUNNING:
            self._end(MissionStatus.FAILURE, reason)

    def abandon(self, reason: str) -> None:
        """End at once, without waiting for anybody; the goals left behind stand in the reason."""
        if self.is_done:
            return
        if self.status is MissionStatus.OBSERVING:
            self._cut_observation(reason)
            return
        if self.status is MissionStatus.RUNNING:
            self._end(MissionStatus.FAILURE, reason)
        else:
            self.reason = "; ".join(filter(None, (self.reason, reason)))
        self.cleanups.skip(reason or "the mission was left")
        self._note_halted()
        self._runtime.ledger.update(self._runtime.now_ns)
        self._finish(observe_s=0.0)

    # ---- pausing -------------------------------------------------------------------------

    @property
    def state(self) -> str:
        """The status in one word for people; ``paused`` is one, too."""
        is_paused = self.paused is not None and self.status is MissionStatus.RUNNING
        return "paused" if is_paused else str(self.status)

    @property
    def explanation(self) -> str:
        """Why it is paused, with the goals that are still under way; else the reason."""
        if self.status is MissionStatus.OBSERVING:
            found = ": ".join(filter(None, (str(self.verdict), self.reason)))
            return f"{found}; observing for {self.observe_s:g} s"
        if self.paused is None:
            return self.reason
        under_way = ", ".join(self._runtime.ledger.describe_under_way())
        return self.paused + (f"; still under way: {under_way}" if under_way else "")

    @property
    def nodes(self) -> tuple[Behaviour, ...]:
        """Every node, depth first."""
        return tuple(self._paths)

    @property
    def running_leaves(self) -> list[Behaviour]:
        """The leaves that run, in the order in which they started."""
        return [node for node in self._running if not node.children]

    def pause(self, reason: str, *, keep_goals: bool = False) -> None:
        """Tick the tree no more until resumed. ROS time, and with it every limit, goes on.

        Args:
            keep_goals: Let goals run on: their limits and conditions, and each `timeout` and
                `guard` around them, still cancel them, and the next tick tells the outcome. Else
                they are cancelled now, and their leaves start anew after the pause.
        """
        if self.status is not MissionStatus.RUNNING:
            return
        self.paused = reason
        self._trace.record(self._runtime.now_ns, "paused", reason=reason, keep_goals=keep_goals)
        if not keep_goals:
            for leaf in self._goal_leaves:
                if not leaf.has_outcome:
                    leaf.stop(Status.INVALID)
            self._note_halted()

    def resume(self) -> None:
        """Go on after a pause."""
        if self.paused is not None and self.status is MissionStatus.RUNNING:
            self.paused = None
            self._trace.record(self._runtime.now_ns, "resumed")

    def step(self) -> None:
        """While paused: let one tick pass, or the rest of the one that a breakpoint stopped."""
        self._steps = 1
        self.steps += 1

    # ---- looking -------------------------------------------------------------------------

    def path_of(self, node: Behaviour) -> str:
        """The place of a node in the tree, such as ``0.1.0``."""
        return self._paths[node]

    # ---- inside --------------------------------------------------------------------------

    def _on_goal(self, time_ns: int, what: str, goal: Goal) -> None:
        self._trace.record_goal(time_ns, what, goal)
        self._notify(self.goal_listeners, what, goal)

    def _end_by_listeners(self) -> None:
        """Fail because of listeners that raised; once the mission has ended, only name them."""
        if self.status is MissionStatus.ENDING:
            return  # `_finish` names them
        broken = "; ".join(self._take_raised())
        if self.is_done:
            self.reason = "; ".join(filter(None, (self.reason, broken)))
        self.fail(broken)

    def _take_raised(self) -> list[str]:
        raised = [f"a callback failed: {cause_of(error)}" for error in self._raised]
        self._raised.clear()
        return raised

    def _notify(self, listeners: Listeners[P], *arguments: P.args, **named: P.kwargs) -> None:
        self._raised += listeners.notify(*arguments, **named)

    @property
    def _goal_leaves(self) -> list[ActionLeaf]:
        return [leaf for leaf in self.running_leaves if isinstance(leaf, ActionLeaf)]

    def _supervise_goals(self) -> None:
        try:
            for leaf in self._goal_leaves:
                leaf.supervise()
        except Exception as error:  # noqa: BLE001 - a condition may raise as in a tick
            self._end(MissionStatus.FAILURE, cause_of(error))

    def _tick_tree(self) -> None:
        try:
            if self._walk is None:
                if not self._followed.are_there():
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
                culprit = failed_node(self.root)
                self.is_resumable = isinstance(culprit, ActionLeaf) and culprit.was_cut_off
                said = culprit.feedback_message or "failed"
                self._end(MissionStatus.FAILURE, f"'{culprit.name}' {said}")

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
        self.pause(f"breakpoint at '{node.name}'")

    def _recover(self, recovery: Recovery) -> None:
        try:
            if not recovery.is_done():
                return
            recovery.finish(self._paths)
        except BtMissionError as error:
            self._end(MissionStatus.FAILURE, f"cannot be resumed: {error}")
            return
        self._recovery = None
        self.started_ns = self._runtime.now_ns
        for node in self._paths:
            if node.status is not self._known[node]:
                self._note(node)

    def _note_halted(self) -> None:
        """A node that the tree halts is not visited by the tick, but has changed all the same."""
        running = Status.RUNNING
        for node in [node for node in self._running if node.status is not running]:
            self._note(node)

    def _note(self, node: Behaviour) -> None:
        self._known[node] = node.status
        if node.status is Status.RUNNING:
            self._running[node] = None
        else:
            self._running.pop(node, None)
        change = Change(
            self._runtime.now_ns, node, self._paths[node], node.status, node.feedback_message
        )
        self._trace.record_status(
            change.time_ns, node.name, change.path, node.status.value, change.message
        )
        self._notify(self.listeners, change)

    def _end(self, verdict: MissionStatus, reason: str) -> None:
        """Stop what runs, and wait from now on for the goals that are still open."""
        reason = "; ".join(filter(None, (reason, *self.cleanups.halt_tree(self.root))))
        self.status, self.verdict, self.reason = MissionStatus.ENDING, verdict, reason
        self.paused = self._walk = self._recovery = None
        self._note_halted()

    def _finish(self, observe_s: float) -> None:
        left = self.goals_left_behind
        orphans = [f"orphaned goals: {', '.join(left)}"] if left else []
        wrong = [*self.cleanups.failures, *self._take_raised(), *orphans]
        if wrong:
            self.reason = "; ".join(filter(None, (self.reason, *wrong)))
            if self.verdict is MissionStatus.SUCCESS:
                self.verdict = MissionStatus.FAILURE
        """How the mission has ended, or is about to."""
        self.observe_s = observe_s
        self.ended_ns = self._runtime.now_ns
        if not observe_s:
            self._close()
            return
        self.status = MissionStatus.OBSERVING
        told = {"status": str(self.verdict), "reason": self.reason, "seconds": observe_s}
        self._trace.record(self.ended_ns, "observing", **told)

    def _close(self) -> None:
        self.status = self.verdict
        now_ns = self._runtime.now_ns
        self._trace.record(now_ns, "mission", status=str(self.status), reason=self.reason)

    def _cut_observation(self, reason: str) -> None:
        observed_s = (self._runtime.now_ns - self.ended_ns) / NS
        cut = f"observed for {observed_s:g} s of {self.observe_s:g} s: {reason}"
        self.reason = "; ".join(filter(None, (self.reason, cut)))
        self._close()
