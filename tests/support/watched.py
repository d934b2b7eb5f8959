"""An executive that tells what the test says, without ROS: a source for a watcher's view."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping

from py_trees.common import Status

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.executive.events import events, messages
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.messages import Batch
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import (
    ControlRequest,
    ControlResponse,
    ListedExecutive,
    Received,
)
from bt_mission.executive.goals.poses import NamedPose
from bt_mission.executive.report import Report

S = 1_000_000_000

EXPLORE = """\
explore
  look around
  repeat
    drive
    turn away
"""

WORDS = {
    "running": Status.RUNNING,
    "success": Status.SUCCESS,
    "failure": Status.FAILURE,
    "invalid": Status.INVALID,
}


def known(executive: ScriptedExecutive) -> MissionState:
    """What follows from all that an executive has sent, and nobody has taken."""
    feed = MissionFeed(MissionState())
    for batch in executive.take(needs_statuses=False).messages:
        feed.take(batch)
    return feed.mission


def tree(
    outline: str = EXPLORE,
    *,
    run: str = "run",
    time_ns: int = S,
    details: Mapping[str, tuple[str, ...]] | None = None,
) -> events.RunStarted:
    """A tree, from names indented by two blanks a level."""
    nodes: list[events.NodeInfo] = []
    details = details or {}
    above: list[int] = []
    counts: dict[int, int] = {}
    lines = outline.rstrip("\n").split("\n")
    for index, line in enumerate(lines):
        depth = (len(line) - len(line.lstrip())) // 2
        parent = above[depth - 1] if depth else 0
        del above[depth:]
        above.append(index)
        path = "0"
        if depth:
            path = f"{nodes[parent].path}.{counts.get(parent, 0)}"
            counts[parent] = counts.get(parent, 0) + 1
        name, asked = line.strip(), details.get(path, ())
        nodes.append(events.NodeInfo(name, "ActionLeaf", path, parent, asked))
    return events.RunStarted(time_ns, run, nodes[0].name, tuple(nodes))


def state_of(outline: str = EXPLORE) -> MissionState:
    """The state of a mission that has just started with this tree."""
    mission = MissionState()
    mission.apply(tree(outline))
    return mission


def goal_in(
    state: str = "sent",
    *targets: tuple[float, float],
    goal_id: str = "ab",
    action: str = "/turn",
    owner: str = "turn away",
    at_s: float = 1.0,
    sent_s: float = 1.0,
) -> events.GoalChanged:
    """A goal that is in this state since ``at_s``."""
    places = tuple(NamedPose(x, y, 0.0, "map") for x, y in targets)
    at_ns, sent_ns = round(at_s * S), round(sent_s * S)
    return events.GoalChanged(at_ns, goal_id, action, owner, sent_ns, state, targets=places)


def requirement(
    name: str, verdict: str, margin: str = "", *, time_ns: int = S
) -> events.RequirementChanged:
    """What a requirement of speed has come to, half a second after the start."""
    return events.RequirementChanged(
        time_ns=time_ns,
        name=name,
        requirement="always speed < 0.3",
        verdict=verdict,
        margin=float(margin) if margin else None,
        unit="m/s",
        at=0.5,
        violated_at=0.5 if verdict == "violated" else None,
        on_violation="report",
        sources=("speed by odometry",),
        why="",
        outcome=f"{verdict} at 0.50 s",
    )


class ScriptedExecutive:
    """Tells of a mission, and takes wishes; what the view has not yet taken waits."""

    def __init__(self, outline: str = EXPLORE, name: str = "/bt_mission") -> None:
        self.name = name
        self.is_there = True
        self.outline = outline
        self.details: dict[str, tuple[str, ...]] = {}
        """What nodes are asked to do, by their paths."""
        self.run = ""
        self.now_ns = S
        self.commands: list[ControlRequest] = []
        self.asked = 0
        self.closed = False
        self.has_camera = False
        self.image: messages.CameraImage | None = None
        self._sequence = 0
        self._statuses: list[events.NodeChanged] = []
        self._batches: list[Batch] = []
        self._robot: list[messages.Robot] = []
        self._answers: list[ControlResponse] = []

    # ---- what the test has it tell -------------------------------------------------------

    def begin(self, run: str = "run") -> Batch:
        """A mission starts."""
        self.run, self._sequence = run, 0
        started = tree(self.outline, run=run, time_ns=self.now_ns, details=self.details)
        self.names = [node.name for node in started.nodes]
        self._statuses = [
            events.NodeChanged(None, index, Status.INVALID, "")
            for index in range(len(started.nodes))
        ]
        batch = self._send(started)
        self.stand("running")
        return batch

    def change(self, after_s: float = 0.0, /, **statuses: str) -> Batch:
        """Nodes change: ``change(1.0, drive="success: canceled")``; ``_`` stands for a blank.

        ``"reset"`` takes back the status of a node that has ended.
        """
        self.now_ns += round(after_s * S)
        self._sequence += 1
        changes: list[events.Event] = []
        reset: list[int] = []
        for name, words in statuses.items():
            index = self.names.index(name.replace("_", " "))
            if words == "reset":
                reset.append(index)
                self._statuses[index] = events.NodeChanged(None, index, Status.INVALID, "")
                continue
            status, _, message = words.partition(": ")
            changes.append(events.NodeChanged(self.now_ns, index, WORDS[status], message))
            self._statuses[index] = events.NodeChanged(None, index, WORDS[status], message)
        if reset:
            changes.append(events.NodesReset(self.now_ns, tuple(reset)))
        return self._send(*changes, sequence=self._sequence)

    def stand(self, status: str, reason: str = "") -> None:
        """The mission's state changes."""
        self._send(events.StateChanged(self.now_ns, self.run, "explore", status, reason))

    def say(self, text: str) -> None:
        """The mission says something."""
        self._send(events.LogLine(self.now_ns, text))

    def judge(self, after_s: float = 0.0, /, **verdicts: str) -> Batch:
        """Requirements have these verdicts: ``judge(is_slow="violated -0.1")``."""
        self.now_ns += round(after_s * S)
        return self._send(
            *(
                requirement(name.replace("_", " "), *words.split(), time_ns=self.now_ns)
                for name, words in verdicts.items()
            )
        )

    def detail(
        self,
        after_s: float = 0.0,
        *,
        ticks: int = 1,
        goals_sent: int = 0,
        running: Iterable[events.NodeProgressed] = (),
        goals: Iterable[events.GoalChanged] = (),
        variables: Iterable[tuple[str, str]] = (),
        breakpoints: tuple[str, ...] = (),
    ) -> Batch:
        """Details, with nothing in them but what is given."""
        self.now_ns += round(after_s * S)
        return self._send(
            events.CountsChanged(self.now_ns, ticks, goals_sent),
            events.BreakpointsChanged(self.now_ns, breakpoints),
            *running,
            *goals,
            *(events.VariableChanged(self.now_ns, *variable) for variable in variables),
        )

    def progress(
        self, name: str, value: float, limit: float, message: str = ""
    ) -> events.NodeProgressed:
        """How far a node has come, for :meth:`detail`."""
        index, now_ns = self.names.index(name), self.now_ns
        return events.NodeProgressed(now_ns, index, now_ns, message, "travelled", value, limit)

    def _send(self, *happened: events.Event, sequence: int = 0) -> Batch:
        self._batches.append(Batch(self.run, happened, sequence))
        return self._batches[-1]

    def show(self, *robot: messages.Robot) -> None:
        """The robot tells of itself."""
        self._robot += robot

    def answer(self, text: str, *, is_done: bool = True) -> None:
        """What became of a wish."""
        self._answers.append(ControlResponse(is_done, text))

    def forget(self) -> None:
        """What was told so far is lost on its way."""
        self._batches.clear()

    @property
    def statuses(self) -> Batch:
        """What the service for latecomers answers."""
        return Batch(self.run, tuple(self._statuses), self._sequence, is_complete=True)

    # ---- a source ------------------------------------------------------------------------

    def take(self, *, needs_statuses: bool) -> Received:
        if needs_statuses and self.is_there:
            self.asked += 1
            self._batches.append(self.statuses)
        image, self.image = self.image, None
        received = Received(tuple(self._batches), tuple(self._robot), tuple(self._answers), image)
        for queue in (self._batches, self._robot, self._answers):
            queue.clear()
        return received

    def send(self, command: ControlRequest) -> None:
        self.commands.append(command)

    def watch_camera(self, *, is_on: bool) -> None:
        self.has_camera = is_on

    def close(self) -> None:
        self.closed = True


def begun(outline: str = EXPLORE, name: str = "/bt_mission") -> ScriptedExecutive:
    """An executive whose mission has begun."""
    executive = ScriptedExecutive(outline, name)
    executive.begin()
    return executive


class ScriptedRun:
    """A session of so many steps, which ends when it is interrupted."""

    def __init__(self, count: int) -> None:
        self.executive = ScriptedExecutive()
        self.graph = ScriptedGraph(self.executive)
        self.interrupts = InterruptSignals()
        self.taken = 0
        self._count = count

    def steps(self) -> Generator[float, None, Report]:
        """Take the steps; return the report."""
        self.executive.begin()
        while self.taken < self._count and not self.interrupts.count:
            self.taken += 1
            self.executive.change(0.05, drive="running")
            yield 0.0 if self.taken % 2 else 0.001
        self.executive.stand("success")
        facts = ("explore", "success", self.interrupts.name, None, "waffle", 7, 1.0, 1.0, 1.0)
        return Report(*facts, 1, 0, 0, None, None, "hash")

    def broken_steps(self) -> Generator[float, None, Report]:
        """Take the steps, and fail."""
        yield from self.steps()
        raise ValueError("a defect")


class ScriptedGraph:
    """A graph with executives that the test plays."""

    where = "a test"

    def __init__(self, *executives: ScriptedExecutive) -> None:
        self.executives = list(executives)
        self.faults: dict[str, ListedExecutive] = {}
        self.served = 0

    @property
    def name(self) -> str:
        """The name of the first executive."""
        return self.executives[0].name

    def serve(self) -> None:
        self.served += 1

    def close(self) -> None:
        """Leave."""

    def find(self) -> tuple[ListedExecutive, ...]:
        there = [executive.name for executive in self.executives if executive.is_there]
        return tuple(self.faults.get(name, ListedExecutive(name)) for name in there)

    def attach(self, name: str) -> ScriptedExecutive:
        for executive in self.executives:
            if executive.name == name:
                executive.closed = False
                return executive
        raise AssertionError(name)
