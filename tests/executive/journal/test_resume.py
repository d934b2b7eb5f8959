"""A mission whose process dies after any tick ends as one that was never interrupted."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.dds.liveliness import EXECUTIVE_LOST
from bt_mission.base.errors import BtMissionError
from bt_mission.base.verdicts import RequirementResult
from bt_mission.executive.controls import MissionControls
from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.executive.goals.goal import Goal, GoalTrigger, Phase
from bt_mission.executive.journal.recorder import JournalRecorder
from bt_mission.executive.journal.recovery import Recovery
from bt_mission.executive.journal.store import Journal, Unpack
from bt_mission.sessions.load import load
from tests.conftest import ScriptedServer
from tests.support.play import TICK_NS, Play, message
from tests.support.thorough import sample

S = 1_000_000_000


class Life:
    """One process of a mission, and the disk that outlives it."""

    def __init__(
        self,
        text: str,
        path: Path,
        world: World,
        unpack: Unpack = lambda data: data,
        requirements: Callable[[], Iterable[RequirementResult]] = tuple,
    ) -> None:
        mission = load(text)
        world.lives += 1
        self.play = Play(text, lambda name: Server(name, world), goal_seed=str(world.lives))
        self.play.now_ns = world.now_ns
        self.world = world
        is_resumed, state = path.exists(), None
        self.journal = Journal(path)
        if is_resumed:
            state = self.journal.resume(mission, "/")
            self.play.executive.resume_from(Recovery(state, self.play, unpack))
        else:
            self.journal.begin(mission, "/")
        JournalRecorder(
            self.journal, state, self.play.executive, self.play, lambda _: None, requirements
        )

    def tick(self) -> None:
        """One tick; a goal ends when it has run for three."""
        self.world.now_ns += TICK_NS
        self.play.now_ns = self.world.now_ns
        self.world.serve()
        self.play.executive.tick()

    def die(self) -> None:
        """As by ``kill -9``: nothing is written any more."""
        self.journal.close()
        self.world.lose_the_executive()


class World:
    """Servers live on when an executive dies; each goal takes three ticks."""

    def __init__(self, fate: str) -> None:
        self.now_ns = S
        self.fate = fate
        self.ages: dict[bytes, int] = {}
        self.goals: dict[bytes, Goal] = {}
        self.ended: dict[bytes, int] = {}
        self.driven = 0
        self.lives = 0
        self.lasted = 0

    def serve(self) -> None:
        """One tick of every server."""
        for goal_id, goal in tuple(self.goals.items()):
            if goal.phase in (Phase.SENT, Phase.RECALLED):
                goal.on(GoalTrigger.ACCEPTED)
                if goal_id not in self.goals:
                    continue  # it was cancelled at once
            self.ages[goal_id] += 1
            if self.ages[goal_id] >= 3:
                self.driven += 1
                self.end(goal, 4)

    def end(self, goal: Goal, status: int) -> None:
        """A goal ends."""
        del self.goals[goal.id]
        self.ended[goal.id] = status
        goal.on_result(status, None)

    def lose_the_executive(self) -> None:
        """What becomes of the goals then."""
        for goal_id in self.goals:
            if self.fate == "finishes":
                self.driven += 1
                self.ended[goal_id] = 4
            else:
                self.ended[goal_id] = 6 if self.fate == "cut short" else 0
        self.goals.clear()


class Server(ScriptedServer):
    """A server of that world."""

    def __init__(self, name: str, world: World) -> None:
        super().__init__(name)
        self._world = world

    def send(self, goal: Goal, request: Any) -> None:
        self._world.goals[goal.id] = goal
        self._world.ages[goal.id] = 0

    def recover_goal(self, goal: Goal) -> None:
        pass

    def ask_result(self, goal: Goal) -> None:
        if goal.id in self._world.ended:
            goal.on_result(self._world.ended[goal.id], None)

    def send_cancel(self, goal: Goal) -> None:
        if goal.id in self._world.goals and goal.accepted:
            self._world.end(goal, 5)


TREES = {
    "sequence": "sequence: [{log: a}, {turn: {angle: 9}}, {log: b}, {turn: {angle: 8}}, {log: c}]",
    "fallback": "fallback: [{check: false}, {turn: {angle: 9}}, {log: b}]",
    "parallel": "parallel: [{turn: {angle: 9}}, {sequence: [{wait: 0.3}, {log: a}]}, {log: b}]",
    "finish": "parallel: [{log: a}, {sequence: [{wait: 0.4}, {log: b}]}]\n"
    "  succeed_when: any\n  rest: finish",
    "repeat": "repeat: {count: 3}\n  do: {sequence: [{turn: {angle: 9}}, {log: a}]}",
    "until": "sequence:\n    - set: {n: 0}\n    - repeat: {until: n > 2}\n"
    "      do: {sequence: [{turn: {angle: 9}}, {set: {n: n + 1}}, {log: $n}]}",
    "while": "sequence:\n    - set: {n: 0}\n    - repeat: {while: n < 3, count: 9}\n"
    "      do: {sequence: [{set: {n: n + 1}}, {turn: {angle: 9}}, {log: $n}]}",
    "finally": "finally: {timeout: 9}\n  do: {sequence: [{turn: {angle: 9}}, {log: a}]}\n"
    "  then: {sequence: [{log: b}, {turn: {angle: 9}}, {log: c}]}",
    "halted": "sequence:\n    - set: {n: 4}\n    - parallel:\n"
    "        - finally: {timeout: 9}\n          do: {wait: 99}\n"
    "          then: {sequence: [{log: $n}, {turn: {angle: 9}}, {set: {n: n + 1}}, {log: $n}]}\n"
    "        - sequence: [{action: {name: /b, type: a_b/action/Turn}}, {log: b}]\n"
    "      succeed_when: any\n    - {action: {name: /c, type: a_b/action/Turn}}\n    - log: $n",
    "retry": "force: success\n  do:\n    retry: {attempts: 3, pause: 0.2}\n"
    "    do: {sequence: [{log: a}, {turn: {angle: 3}}, {check: false}]}",
    "for_each": "for_each: {x: [1, 2, 3]}\n  do: {sequence: [{log: $x}, {turn: {angle: $x}}]}",
    "timeout": "timeout: 9\n  do: {sequence: [{turn: {angle: 9}}, {log: a}]}",
    "choose": "repeat: {count: 4}\n  do:\n    choose:\n"
    "      - sequence: [{turn: {angle: 9}}, {log: a}]\n"
    "      - sequence: [{log: b}, {wait: 0.1}]\n      - log: c",
    "random": "repeat: {count: 4}\n  do:\n    sequence:\n      - set: {x: 'uniform(0, 1)'}\n"
    "      - log: $x\n      - turn: {angle: 'uniform(1, 2)'}\n      - log: '${x + 1}'",
    "tree": "sequence: [{tree: {name: leg, inputs: {n: 4}}, outputs: {m: got}}, {log: $got}]\n"
    "trees:\n  leg:\n    inputs: {n: 1}\n    outputs: {m: number}\n"
    "    do: {sequence: [{set: {m: 'n + uniform(0, 1)'}}, {turn: {angle: $n}}, {log: $m}]}",
    "fails": "sequence: [{turn: {angle: 9}}, {log: a}, {check: false}]",
    "guard": "sequence:\n    - set: {ok: true}\n    - guard: ok\n"
    "      do: {sequence: [{turn: {angle: 9}}, {wait: 0.2}, {log: a}]}",
    "when": "when: true\n  do: {sequence: [{turn: {angle: 9}}, {log: a}]}\n  else: {log: b}",
}


def run(text: str, path: Path, world: World, deaths: list[int]) -> tuple[str, list[str], int]:
    """Live until the end, dying after these ticks; gives status, all that was said, goals done."""
    life = Life(text, path, world)
    lines: list[str] = []
    for tick in range(1, 400):
        if life.play.executive.is_done:
            break
        life.tick()
        if tick in deaths and not life.play.executive.is_done:
            life.die()
            lines += life.play.logged
            life = Life(text, path, world)
    assert life.play.executive.goals_left_behind == ()
    assert world.goals == {}
    life.die()
    world.lasted = tick
    status = str(life.play.executive.status)
    return f"{status} {life.play.executive.reason}", lines + life.play.logged, world.driven


@pytest.mark.parametrize(
    ("tree", "fate"),
    sample(itertools.product(TREES, ("finishes", "cut short", "restarted")), every=3),
)
def test_death_after_any_tick(tmp_path: Path, tree: str, fate: str) -> None:
    """Nothing is said twice or never; no goal that has ended well is sent again."""
    text = f"mission: m\nseed: 3\ntree:\n  {TREES[tree]}\n"
    quiet = World(fate)
    alone = run(text, tmp_path / "j", quiet, [])
    assert quiet.lasted > 4
    for tick in range(1, quiet.lasted):
        again = run(text, tmp_path / f"j{tick}", World(fate), [tick])
        assert again == alone, f"died after tick {tick}"


def test_dying_again_and_again(tmp_path: Path) -> None:
    """Each life does at least one thing."""
    text = f"mission: m\nseed: 3\ntree:\n  {TREES['random']}\n"
    alone = run(text, tmp_path / "a", World("finishes"), [])
    assert run(text, tmp_path / "b", World("finishes"), list(range(4, 400, 7))) == alone


@pytest.fixture
def begun(tmp_path: Path) -> Callable[[str], tuple[Life, Path]]:
    """A mission that has run for some ticks and died."""

    def begin(tree: str, ticks: int = 3) -> tuple[Life, Path]:
        life = Life(f"mission: m\ntree:\n  {tree}\n", tmp_path / "j", World("finishes"))
        for _ in range(ticks):
            life.tick()
        life.die()
        return life, tmp_path / "j"

    return begin


def test_the_time_of_the_pause_does_not_count(begun: Any) -> None:
    """A wait of 10 s that has run for 4.5 s has 5.5 s to go, a second of inaccuracy apart."""
    life, path = begun("wait: 10", ticks=90)
    life.world.now_ns += 1000 * S
    again = Life("mission: m\ntree:\n  wait: 10\n", path, life.world)
    ticks = 0
    while not again.play.executive.is_done:
        again.tick()
        ticks += 1
    assert 5.5 <= ticks / 20 <= 6.6


def test_a_verdict_is_written_at_once_and_a_margin_at_the_next_heartbeat(tmp_path: Path) -> None:
    """A mission that dies in the tick after a violation resumes as violated."""
    text, path = "mission: m\ntree:\n  wait: 10\n", tmp_path / "j"
    result = RequirementResult("near", "always clearance > 0.1", "open", 0.4)

    def written() -> RequirementResult:
        journal = Journal(path, must_exist=True)
        kept = journal.resume(load(text), "/").requirements["near"]
        journal.close()
        return kept

    life = Life(text, path, World("finishes"), requirements=lambda: [result])
    life.tick()
    before = result
    result = replace(before, margin=0.3)
    life.tick()
    life.journal.close()
    assert written() == before

    again = Life(text, path, life.world, requirements=lambda: [result])
    again.tick()
    result = replace(result, verdict="violated", margin=-0.1)
    again.tick()
    again.die()
    assert written() == result


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("mission: n\ntree:\n  wait: 10\n", "the journal of another mission, 'm'"),
        ("mission: m\ntree:\n  wait: 11\n", "the mission file has changed"),
    ],
)
def test_a_foreign_journal_is_refused(begun: Any, text: str, words: str) -> None:
    """With what is different."""
    life, path = begun("wait: 10")
    with pytest.raises(BtMissionError, match=words):
        Life(text, path, life.world)


def test_other_inputs_and_seeds_are_told(begun: Any) -> None:
    """With the option that gives them."""
    _, path = begun("wait: 10")
    text = "mission: m\ntree:\n  wait: 10\n"
    journal = Journal(path)
    with pytest.raises(BtMissionError, match=r"different seed: 0, not 4 \(--seed\)"):
        journal.resume(load(text, seed=4), "/")
    with pytest.raises(BtMissionError, match=r"different namespace: '/', not '/r' \(--namespace\)"):
        journal.resume(load(text), "/r")
    journal.close()


def test_a_mission_that_has_ended_is_not_resumed(begun: Any) -> None:
    """It says how it ended."""
    life, path = begun("check: false")
    with pytest.raises(
        BtMissionError, match="this mission has ended: failure: 'check false' never holds"
    ):
        Life("mission: m\ntree:\n  check: false\n", path, life.world)


def test_without_the_server_of_a_goal_in_flight_nothing_goes_on(begun: Any) -> None:
    """Nobody knows what the robot does; the journal stays as it is, to be resumed later."""
    life, path = begun("turn: {angle: 9}", ticks=2)
    before = path.read_bytes()
    again = Life("mission: m\ntree:\n  turn: {angle: 9}\n", path, life.world)
    again.play.goal_client("turn", "").ready = False
    for _ in range(300):
        again.tick()
    again.die()
    assert again.play.status == "failure"
    assert again.play.executive.reason == (
        "cannot be resumed: 'turn' had a goal at /turn when its process died, and the server is "
        "not running; start it, then resume again"
    )
    assert path.read_bytes() == before


def test_a_mission_that_recovers_can_be_stopped_only(begun: Any) -> None:
    """Its status says so until the goals in flight have ended; then it runs."""
    life, path = begun("turn: {angle: 9}", ticks=2)
    again = Life("mission: m\ntree:\n  turn: {angle: 9}\n", path, life.world)
    executive, server = again.play.executive, again.play.goal_client("turn", "")
    server.ready = False
    again.tick()
    controls = MissionControls(lambda: executive)
    refused = "the mission is being resumed; try again when it runs"
    assert (executive.mission_state.status, executive.why_not_revisable) == ("recovering", refused)
    assert [controls.perform(ControlRequest(verb)).text for verb in (Verb.PAUSE, Verb.STEP)] == [
        refused,
        "the mission is not paused; pause it first",
    ]
    server.ready = True
    again.tick()
    assert (executive.status, executive.mission_state.status) == ("running", "running")


def test_a_clock_that_leaps_is_no_wait_for_servers(begun: Any) -> None:
    """On a busy machine the graph is not served meanwhile: servers that live are found later."""
    life, path = begun("turn: {angle: 9}", ticks=2)
    again = Life("mission: m\ntree:\n  turn: {angle: 9}\n", path, life.world)
    for looked in range(40):
        again.play.goal_client("turn", "").ready = looked >= 20
        life.world.now_ns += S
        again.tick()
    assert again.play.status == "success", again.play.executive.reason


def test_a_value_that_no_journal_keeps(begun: Any, tmp_path: Path) -> None:
    """The variable is named; the mission does not go on with a wrong value."""
    text = "mission: m\ntree:\n  wait: 10\n"
    life = Life(text, tmp_path / "k", World("finishes"))
    life.play.scope.values["odd"] = object()
    life.tick()
    life.die()
    again = Life(text, tmp_path / "k", life.world)
    again.tick()
    again.die()
    assert again.play.executive.reason == (
        "cannot be resumed: the variable 'odd' was a object, which no journal keeps"
    )


@pytest.mark.parametrize(
    ("kind", "name", "value", "words"),
    [
        ("nodes", "0", {"left_ns": "x"}, "'wait' (0) cannot be restored: TypeError"),
        ("nodes", "0", {}, "'wait' (0) cannot be restored: KeyError: 'left_ns'"),
        ("variables", "/x", {"message": {}}, "the variable 'x' cannot be restored: ValueError"),
        ("variables", "0.1/x", 1, "the variable 'x' cannot be restored: KeyError: '0.1'"),
        ("generators", "0", [3, "zz", None], "the random generator of 0 cannot be restored"),
    ],
)
def test_what_cannot_be_restored_is_named(
    begun: Any, kind: str, name: str, value: Any, words: str
) -> None:
    """The mission does not start; the journal stays as it is."""
    life, path = begun("wait: 10")
    journal = Journal(path)
    saved = {"status": "RUNNING", "memory": value, "saved_ns": 1}
    journal.write({(kind, name): saved if kind == "nodes" else value})
    journal.close()

    def unpack(_: Any) -> None:
        raise ValueError

    again = Life("mission: m\ntree:\n  wait: 10\n", path, life.world, unpack)
    again.tick()
    again.die()
    assert again.play.executive.reason.startswith(f"cannot be resumed: {words}")
    assert again.play.status == "failure"


def test_a_full_disk_ends_the_mission_which_can_be_resumed(tmp_path: Path) -> None:
    """What was written last stays, so it resumes where there is room again."""
    tree = "sequence: [{turn: {angle: 9}}, {turn: {angle: 8}}, {log: a}]"
    path, text = tmp_path / "j", f"mission: m\ntree:\n  {tree}\n"
    life = Life(text, path, World("finishes"))
    life.tick()
    life.journal._database.execute("PRAGMA max_page_count=2")
    life.play.scope.values["large"] = "x" * 9999
    while not life.play.executive.is_done:
        life.tick()
    life.die()
    reason = f"{path}: cannot write the journal: database or disk is full"
    assert (life.play.status, life.play.executive.reason) == ("failure", reason)
    status, output, driven = run(text, path, life.world, [])
    assert (status, life.play.logged + output, driven) == ("success ", ["a"], 2)


def test_a_journal_that_cannot_be_written_ends_the_mission(begun: Any, tmp_path: Path) -> None:
    """Whoever asks for one relies on it."""
    life = Life("mission: m\ntree:\n  wait: 10\n", tmp_path / "j", World("finishes"))
    life.tick()
    life.die()  # its file is closed
    for _ in range(40):
        life.tick()
    assert life.play.status == "failure"
    assert (
        "cannot write the journal: Cannot operate on a closed database."
        in life.play.executive.reason
    )


@pytest.mark.parametrize("shape", ["{}", "retry: {{attempts: 1}}\n  do:\n    {}"])
def test_a_mission_whose_goal_was_cut_off_goes_on(tmp_path: Path, shape: str) -> None:
    """Its servers took its process for dead, which lived: it failed, and can be resumed."""
    tree = shape.format("sequence: [{log: a}, {turn: {angle: 9}}, {log: b}]")
    text, world = f"mission: m\ntree:\n  {tree}\n", World("cut short")
    life = Life(text, tmp_path / "j", world)
    life.tick()
    (goal,) = world.goals.values()
    life.tick()
    del world.goals[goal.id]
    goal.on_result(6, message(error_code=EXECUTIVE_LOST, error_msg="the executive has died"))
    world.ended[goal.id] = 6
    life.tick()
    executive = life.play.executive
    assert (executive.mission_state.status, executive.is_resumable) == ("failure", True)
    assert executive.reason == "'turn' aborted: /turn: the executive has died (code 911)"
    life.die()
    status, output, driven = run(text, tmp_path / "j", world, [])
    assert (status, life.play.logged + output, driven) == ("success ", ["a", "b"], 1)


def test_a_goal_that_was_cut_off_may_be_tried_again(tmp_path: Path) -> None:
    """By the mission itself; when that fails, too, for a reason of its own, it has ended."""
    tree = "retry: {attempts: 2}\n  do:\n    turn: {angle: 9}"
    text, world = f"mission: m\ntree:\n  {tree}\n", World("cut short")
    life = Life(text, tmp_path / "j", world)
    for code in (EXECUTIVE_LOST, 902):
        while not world.goals:
            life.tick()
        life.tick()
        (goal,) = world.goals.values()
        del world.goals[goal.id]
        goal.on_result(6, message(error_code=code))
        life.tick()
    assert (life.play.executive.mission_state.status, life.play.executive.is_resumable) == (
        "failure",
        False,
    )
    life.die()
    with pytest.raises(BtMissionError, match="this mission has ended: failure"):
        Life(text, tmp_path / "j", world)


def test_what_follows_a_topic_is_read_anew(tmp_path: Path) -> None:
    """A journal keeps no value of it, nor that it has none; the rest waits for the first one."""
    text = (
        "mission: m\nfollow:\n"
        "  - {topic: /b, type: a/msg/B, field: x, as: b}\n"
        "  - {topic: /b, type: a/msg/B, field: y, as: c, initial: 1}\n"
        "tree:\n  sequence:\n    - set: {seen: b}\n    - finally: {timeout: 9}\n"
        "      do: {wait: 0.2}\n      then: {wait: 0.2}\n    - log: $seen $b $c\n"
    )
    life = Life(text, tmp_path / "j", World("finishes"))
    life.play.topics["/b"].publish(x=1, y=2)
    life.tick()
    life.play.topics["/b"].publish(x=float("nan"), y=3)
    life.tick()
    life.die()
    again = Life(text, tmp_path / "j", life.world)
    assert set(again.journal.resume(load(text), "/").variables) == {"/seen"}
    for _ in range(30):
        again.tick()
    assert again.play.executive.ticks == 0
    again.play.topics["/b"].publish(x=5, y=6)
    for _ in range(20):
        again.tick()
    again.die()
    assert again.play.logged[1:] == ["1 5 6"]
    assert again.play.status == "success"
