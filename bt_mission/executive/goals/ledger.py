"""Every goal sent, by UUID, until its server confirms a terminal status.

A leaf that is halted, interrupted or timed out releases its goal to the ledger, which keeps it
until it ends. No tick blocks. A mission ends with "0 orphaned", or names the orphaned goals.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable
from typing import Any

from bt_mission.executive.goals.goal import Goal, GoalClient, GoalTrigger, Phase

RETRY_NS = 1_000_000_000
"""The delay before a cancel request that is refused or not answered is repeated."""

SERVER_CHECK_NS = 250_000_000
"""The server of a goal under way is looked up in the graph at this interval."""

FOUND_GRACE_NS = 10_000_000_000
"""The grace period of a goal of another process, whose server has only just been discovered."""

NEWEST = 100
"""The number of goals that :meth:`Ledger.has_sent` knows."""

WANTED = (Phase.SENT, Phase.ACTIVE)
"""Phases of a goal for which no end was requested."""

GoalListener = Callable[[int, str, Goal], None]
"""Takes the ROS time, ns, of an event of a goal, the event, and the goal."""


class Ledger:
    """Keeps goals until their confirmed end.

    Args:
        seed: Goal UUIDs derive from it, so that a run can be repeated.
        grace_ns: The time that an abandoned goal may take to end before it counts as orphaned, ns,
            unless its sender sets another.
        on_event: Called for every goal that is sent, released, given up or ended; the text is empty
            if only the phase has changed.
        retry_ns: The delay before a cancel request without an effect is repeated, ns.
        server_check_ns: The interval at which an attempt looks for the server of its goal, ns.
    """

    def __init__(
        self,
        seed: int | str,
        grace_ns: int,
        on_event: GoalListener = lambda *_: None,
        *,
        retry_ns: int = RETRY_NS,
        server_check_ns: int = SERVER_CHECK_NS,
    ) -> None:
        self._seed = seed
        self._grace_ns = grace_ns
        self._delay_ns = retry_ns
        self.server_check_ns = server_check_ns
        self.on_event = on_event
        self._open: dict[bytes, Goal] = {}
        self._retry_ns: dict[bytes, int] = {}
        self._given_up: set[bytes] = set()
        self._unwanted: dict[bytes, Goal] = {}
        """Those of the open goals whose end was requested."""
        self._seen: dict[GoalClient, tuple[int, bool]] = {}
        self.goals_sent = 0
        self.others: Callable[[], str] = str
        """Returns who else sends goals to the servers, as text; empty if that is not known."""
        self.is_held = False
        """Whether leaves of the tree must not send goals, while a clean-up after a halt is under
        way.
        """

    def awaited(
        self, goal_client: GoalClient, uses: Collection[str], halted: Iterable[Goal] = ()
    ) -> str:
        """Return which goal a leaf has to wait for before it sends its own; empty for none.

        That is a goal at the same server, or one that moves the same part of the robot, whose end
        was requested and is not confirmed. A goal that is given up is not awaited.

        Args:
            goal_client: Of the goal that is to be sent.
            uses: The parts of the robot that this goal moves.
            halted: Goals that the tree halts in this tick, once the leaf runs.
        """
        for goal in (*(goal for goal in self._unwanted.values() if goal.is_ending), *halted):
            is_there = goal.goal_client is goal_client
            if goal.is_live and (is_there or not goal.uses.isdisjoint(uses)):
                end = "end" if is_there else f"free the {min(goal.uses & set(uses))}"
                return f"waiting for {goal.goal_client.name} of '{goal.owner}' to {end}"
        return ""

    @property
    def open_goals(self) -> tuple[Goal, ...]:
        """Goals not confirmed as ended, in the order sent."""
        return tuple(self._open.values())

    def find(self, goal_id: str) -> Goal:
        """Return the open goal with this UUID, in hexadecimal.

        Raises:
            KeyError: There is no such goal.
        """
        return self._open[bytes.fromhex(goal_id)]

    @property
    def is_settled(self) -> bool:
        """Return whether every goal has ended, as far as that can still be determined."""
        return not any(goal.is_live for goal in self._open.values())

    def send(
        self,
        goal_client: GoalClient,
        owner: str,
        request: Any,
        now_ns: int,
        grace_ns: int | None = None,
        uses: frozenset[str] = frozenset(),
    ) -> Goal:
        """Send ``request`` as a new goal and keep it until it ends.

        Args:
            goal_client: Sends it to its server.
            owner: The name of its sender, for messages.
            request: The goal, in the client's form.
            now_ns: ROS time, ns.
            grace_ns: Replaces the grace period of the ledger, ns.
            uses: The parts of the robot that the goal moves.
        """
        self.goals_sent += 1
        grace_ns = self._grace_ns if grace_ns is None else grace_ns
        goal = Goal(
            self._id(self.goals_sent),
            goal_client,
            owner,
            grace_ns,
            request,
            sent_ns=now_ns,
            uses=uses,
        )
        self._open[goal.id] = goal
        self._report(now_ns, "sent", goal)
        try:
            goal_client.send(goal, request)
        except Exception:  # any exception is passed to the caller
            del self._open[goal.id]  # the goal was not sent
            raise
        return goal

    def _id(self, number: int) -> bytes:
        """Return the UUID of the goal of this number."""
        digest = bytearray(hashlib.sha256(f"{self._seed}/{number}".encode()).digest()[:16])
        digest[6] = digest[6] & 0x0F | 0x80  # RFC 9562: version 8, made by the application
        digest[8] = digest[8] & 0x3F | 0x80  # RFC 9562: variant
        return bytes(digest)

    def has_sent(self, short_id: str) -> bool:
        """Return whether one of the newest goals begins with these digits."""
        numbers = range(max(1, self.goals_sent - NEWEST), self.goals_sent + 1)
        return any(self._id(number).hex().startswith(short_id) for number in numbers)

    def recover_goal(
        self, goal_id: bytes, goal_client: GoalClient, owner: str, now_ns: int
    ) -> Goal:
        """Take over a goal that another process has sent: ask for its result, and cancel it."""
        goal = Goal(goal_id, goal_client, owner, FOUND_GRACE_NS, phase=Phase.LOST, sent_ns=now_ns)
        goal.orphaned_ns = now_ns
        self._open[goal.id] = self._unwanted[goal.id] = goal
        self._retry_ns[goal.id] = now_ns + self._delay_ns
        self._report(now_ns, "found again", goal)
        goal_client.recover_goal(goal)
        goal.on(GoalTrigger.ACCEPTED)
        return goal

    def cancel_goal(self, goal: Goal) -> None:
        """Request the end of a goal whose leaf waits for it."""
        self._unwanted[goal.id] = goal
        goal.on(GoalTrigger.UNWANTED)

    def release_goal(self, goal: Goal, now_ns: int) -> None:
        """Keep a goal that is not wanted any more until it has ended."""
        if not goal.is_live or goal.orphaned_ns is not None:
            return
        goal.orphaned_ns = now_ns
        self._retry_ns[goal.id] = now_ns + self._delay_ns
        self._report(now_ns, "released", goal)
        self.cancel_goal(goal)

    def is_there(self, goal_client: GoalClient, now_ns: int) -> bool:
        """Return whether this server is in the graph. The graph is asked once at each instant."""
        seen = self._seen.get(goal_client)
        if seen is None or seen[0] != now_ns:
            seen = self._seen[goal_client] = now_ns, goal_client.is_ready()
        return seen[1]

    @property
    def limits_due(self) -> tuple[tuple[tuple[str, bytes], int], ...]:
        """What it does with a goal, the goal's UUID, and the instant: it gives up, or repeats."""
        return tuple(
            ((name, goal.id), due_ns)
            for goal in self._open.values()
            if goal.is_live and goal.orphaned_ns is not None and goal.id not in self._given_up
            for name, due_ns in (
                ("give up", goal.orphaned_ns + goal.grace_ns),
                ("repeat", self._retry_ns[goal.id]),
            )
        )

    def has_given_up(self, goal: Goal) -> bool:
        """Is the time over in which an orphaned goal may end?"""
        return goal.id in self._given_up

    def update(self, now_ns: int) -> None:
        """Close ended goals, repeat unconfirmed cancels, give up goals after their grace."""
        ended = Phase.ENDED
        for goal in tuple(self._open.values()):
            if goal.phase is ended:
                del self._open[goal.id]
                self._retry_ns.pop(goal.id, None)
                self._given_up.discard(goal.id)
                self._unwanted.pop(goal.id, None)
                self._report(now_ns, "ended", goal)
            elif goal.orphaned_ns is None or not goal.is_live:
                continue
            elif goal.id in self._given_up:
                # A message about it has arrived: it has as much time to end as if it were released
                # now.
                self._given_up.discard(goal.id)
                goal.orphaned_ns = now_ns
                self._retry_ns[goal.id] = now_ns + self._delay_ns
            elif now_ns >= goal.orphaned_ns + goal.grace_ns:
                self._given_up.add(goal.id)
                goal.on(GoalTrigger.GIVEN_UP)
                self._report(now_ns, "abandoned", goal)
            elif now_ns >= self._retry_ns[goal.id]:
                self._retry_ns[goal.id] = now_ns + self._delay_ns
                goal.on(GoalTrigger.UNWANTED)
        for goal in self._open.values():
            if goal.phase is not goal.reported:
                self._report(now_ns, "", goal)

    def _report(self, now_ns: int, change: str, goal: Goal) -> None:
        goal.reported = goal.phase
        self.on_event(now_ns, change, goal)

    def describe_under_way(self) -> tuple[str, ...]:
        """Name the sender of each goal that may be worked on; "cancelling" is in brackets."""
        return tuple(
            f"'{goal.owner}'" + ("" if goal.phase in WANTED else " (canceling)")
            for goal in self._open.values()
            if goal.is_live
        )

    def describe_left_behind(self) -> tuple[str, ...]:
        """Return one line for each goal whose end was not confirmed."""
        return tuple(
            f"{goal.goal_client.name} goal {goal.short_id} of '{goal.owner}' ({goal.phase})"
            for goal in self._open.values()
            if goal.phase is not Phase.ENDED
        )
