"""What action servers and foreign peers answer to a mission: late, twice, wrong, or for others.

A case is a program of bytes. Each says what happens next; what it needs more is read from those
behind it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from unique_identifier_msgs.msg import UUID

from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import MissionFailure, Scope
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.goal import Goal, Phase
from bt_mission.executive.goals.goal import GoalStatus as Final
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load
from tests.support.fuzz.finding import Case, Finding, Verdict, crash
from tests.support.fuzz.graph import Graph, messages
from tests.support.fuzz.peer import Peer
from tests.support.fuzz.program import SHOWN, ProgramPlay
from tests.support.fuzz.targets import Target

MISSIONS = (
    """
  sequence:
    - turn: {angle: 90}
      timeout: 5
      cancel_when: current_angle > 45
      outputs: {final_angle: came_to}
    - check: came_to < 1000
""",
    """
  parallel:
    - turn: {angle: 90}
      timeout: 3
    - turn: {angle: -90}
      feedback_timeout: 1
  succeed_when: any
  fail_when: impossible
""",
    """
  retry: {attempts: 3, pause: 0.1}
  do:
    explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
    cancel_when: current_distance_travelled >= 0.5 or current_distance_travelled < 0
    on_cancel: success
    feedback_timeout: 2
    acceptance_timeout: 1
    cancel_timeout: 1
    outputs: {closest_obstacle: room}
""",
    """
  repeat: {count: 3}
  do:
    timeout: 2
    do:
      turn: {angle: 45}
""",
    """
  finally: {timeout: 2}
  do:
    fallback:
      - guard: true
        do: {turn: {angle: 10}}
      - camera_sweep: {sweep_angle: 90, image_count: 2}
        feedback_timeout: 1
  then: {turn: {angle: 0}}
""",
)
STEPS_NS = (0, 10**7, 10**8, 10**9, 10**10, -(10**9))
STATUSES = (4, 4, 5, 6, 0, 1, 2, 3, 7, -1, 127, -128)
CODES = (0, 0, 1, 2, 3, -1, 100)
EMPTY = bytes(16)
SETTLING_TICKS = 100
LONGEST = 120


@cache
def missions() -> tuple[Mission, ...]:
    """Return the missions whose goals are answered."""
    return tuple(load(f"mission: m\ntree:{text}") for text in MISSIONS)


@cache
def peer(name: str, type_name: str) -> Peer:
    """Return the client of an action; there is one of each in a process."""
    return Peer(name, type_name)


class PeerGraph(Graph):
    """The runtime of a mission whose actions are clients of rclpy."""

    def __init__(self, mission: Mission) -> None:
        super().__init__(Scope(dict(mission.inputs), 1), Random(1))
        self.peers: list[Peer] = []

    def goal_client(self, action: str, type_name: str) -> Any:
        client = peer(action, type_name)
        if client not in self.peers:
            client.forget()
            self.peers.append(client)
        return client


class Play(ProgramPlay):
    """A mission, and what happens to it."""

    def __init__(self, contents: bytes) -> None:
        super().__init__(contents)
        mission = self.program.pick(missions())
        self.graph = PeerGraph(mission)
        self.executive = Executive(build_tree(mission, self.graph.scope), self.graph, Trace())
        self.succeeded: set[bytes] = set()
        """Goals whose success was told by somebody who answered the right request."""
        self.accepted: set[bytes] = set()
        self.ends = False

    def run(self) -> None:
        acts: tuple[Callable[[], str], ...] = (
            *(self._tick, self._tick, self._answer, self._answer, self._feedback, self._feedback),
            *(self._result, self._result, self._cancel, self._status, self._vanish, self._hold),
        )
        while self.program:
            self.log.append(self.program.pick(acts)())
            self._look()
        self.executive.interrupt("enough")
        for _ in range(SETTLING_TICKS):
            if self.executive.is_done:
                self.ends = True
                return
            self.graph.now_ns += 5 * 10**8
            for client in self.graph.peers:
                client.tasks.run()
            self.executive.tick()

    # ---- what can happen -----------------------------------------------------------------

    def _tick(self) -> str:
        self.graph.now_ns = max(self.graph.now_ns + self.program.pick(STEPS_NS), 10**9)
        for client in self.graph.peers:
            client.tasks.run()
        self.executive.tick()
        return f"tick at {self.graph.now_ns / 1e9} s: {self.executive.mission_state.status}"

    def _request(self, client: Peer, kind: str) -> tuple[int, Any]:
        """A request that was sent, or one that never was."""
        sent = client.requests.sent[kind]
        byte = self.program.byte()
        if not sent or byte > 240:
            return byte + 1_000_000, None
        return sent[-1 - byte % min(len(sent), 4)]

    def _answer(self) -> str:
        client, flag = self.program.pick(self.graph.peers), self.program.byte()
        number, asked = self._request(client, "goal")
        answer = client.types.Impl.SendGoalService.Response(accepted=flag % 4 != 0)
        answer.stamp.sec = self.program.pick((0, 5, -(2**31), 2**31 - 1))
        if asked is not None and answer.accepted:
            self.accepted.add(bytes(asked.goal_id.uuid))
        client.deliver("goal", (number, answer))
        return f"answer to goal request {number}: accepted {answer.accepted}"

    def _goal_id(self, client: Peer) -> bytes:
        byte = self.program.byte()
        known = list(client.goals)
        if byte % 4 == 3 or not known:
            return self.program.pick((EMPTY, b"\xff" * 16, hashlib.md5(bytes([byte])).digest()))  # noqa: S324 - no secret
        return bytes(known[-1 - byte // 4 % min(len(known), 4)])

    def _feedback(self) -> str:
        client = self.program.pick(self.graph.peers)
        goal_id, content = self._goal_id(client), self.program.pick(messages(client.types.Feedback))
        message = client.types.Impl.FeedbackMessage(
            goal_id=UUID(uuid=list(goal_id)), feedback=content
        )
        before = {key: goal.feedback for key, goal in client.goals.items() if key != goal_id}
        client.deliver("feedback", message)
        for key, feedback in before.items():
            assert client.goals[key].feedback is feedback, "feedback of another goal was taken"
        return f"feedback for {goal_id.hex()[:8]}"

    def _result(self) -> str:
        client, status = self.program.pick(self.graph.peers), self.program.pick(STATUSES)
        number, asked = self._request(client, "result")
        result = self.program.pick(messages(client.types.Result))
        answer = client.types.Impl.GetResultService.Response(status=status, result=result)
        if asked is not None and status == Final.SUCCEEDED:
            self.succeeded.add(bytes(asked.goal_id.uuid))
        client.deliver("result", (number, answer))
        return f"result for request {number}: status {status}"

    def _cancel(self) -> str:
        client, code = self.program.pick(self.graph.peers), self.program.pick(CODES)
        number, asked = self._request(client, "cancel")
        answer = client.types.Impl.CancelGoalService.Response(return_code=code)
        ids = [self._goal_id(client) for _ in range(self.program.byte() % 4)]
        if asked is not None:
            ids += [bytes(asked.goal_info.goal_id.uuid)] * (self.program.byte() % 3)
        answer.goals_canceling = [_info(goal) for goal in ids]
        if asked is not None and (ids or code == 3):
            self.accepted.add(bytes(asked.goal_info.goal_id.uuid))
        client.deliver("cancel", (number, answer))
        return f"answer to cancel {number}: code {code}, {len(ids)} goals"

    def _status(self) -> str:
        client = self.program.pick(self.graph.peers)
        ids = [self._goal_id(client) for _ in range(self.program.byte() % 6)]
        statuses = [
            GoalStatus(goal_info=_info(goal), status=self.program.pick(STATUSES)) for goal in ids
        ]
        client.deliver("status", GoalStatusArray(status_list=statuses))
        return f"status of {len(statuses)} goals"

    def _vanish(self) -> str:
        client = self.program.pick(self.graph.peers)
        client.requests.is_there = self.program.byte() % 3 != 0
        return f"the server is {'there' if client.requests.is_there else 'gone'}"

    def _hold(self) -> str:
        match self.program.byte() % 6:
            case 0:
                self.executive.interrupt("stopped")
                return "interrupt"
            case 1 if self.executive.status == "paused":
                self.executive.resume()
                return "resume"
            case 2 if self.executive.status == "paused":
                self.executive.step()
                return "step"
            case 3 | 4 as how if self.executive.status.is_active:
                self.executive.pause("fuzz", keep_goals=how == 3)
                return "pause"
        return "nothing"

    # ---- whether all is well -------------------------------------------------------------

    def _look(self) -> None:
        for client in self.graph.peers:
            for goal in client.goals.values():
                assert goal.status is not Final.SUCCEEDED or goal.id in self.succeeded, (
                    "a goal has succeeded of which nobody said so"
                )
                assert not goal.accepted or goal.id in self.accepted, (
                    "a goal counts as accepted, and nobody has accepted it"
                )

    def goals(self) -> Iterator[Goal]:
        """Every goal that was sent."""
        for client in self.graph.peers:
            yield from client.goals.values()


def _info(goal_id: bytes) -> GoalInfo:
    return GoalInfo(goal_id=UUID(uuid=list(goal_id)))


def judge(path: Path) -> Verdict:
    """Play a program: no exception, an end, and each goal that did not end is named."""
    play = Play(path.read_bytes())
    finding = play.finding()
    if finding is not None:
        return Verdict(False, finding=finding)
    executive = play.executive
    lines = "\n".join(play.log[-SHOWN:])
    if not play.ends:
        return Verdict(True, finding=Finding("the mission does not end", lines))
    alive = sum(1 for goal in play.goals() if goal.phase is not Phase.ENDED)
    if alive != len(executive.goals_left_behind):
        counts = f"{alive} have not ended, {len(executive.goals_left_behind)} are named"
        return Verdict(True, finding=Finding("goals are left behind unnamed", f"{counts}\n{lines}"))
    cause = getattr(executive, "error", None)
    if cause is not None and not isinstance(cause, MissionFailure):
        return Verdict(True, finding=crash(cause))
    is_sound = str(executive.status) == "interrupted"
    return Verdict(is_sound, executive.reason, inputs=len(play.log))


def samples(_: None) -> Iterator[Case]:
    """Yield one program for each mission."""
    for number in range(len(MISSIONS)):
        yield Case("m.goals", bytes((number, 0, 1, 2, 0, 1, 0, 0, 0, 1, 4, 0, 0, 1, 6, 0, 0, 0)))


def case(_: None, seed: int, number: int) -> Case:
    """Return a program."""
    rng = Random(f"{seed}/{number}")
    begin = bytes((rng.randrange(256), 0, 1, *((2, 0, 1, 0, 0) if rng.random() < 0.7 else ())))
    return Case("m.goals", begin + rng.randbytes(rng.randint(1, LONGEST)))


TARGET = Target(lambda: None, samples, case, judge)
