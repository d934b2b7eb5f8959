"""An executive that tells what the test says, without ROS: a source for a watcher's view."""

from __future__ import annotations

from typing import Any

from py_trees.common import Status

from bt_mission.events import events, messages
from bt_mission.events.source import ControlRequest, ControlResponse, FoundExecutive, Heard

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


def tree(outline: str = EXPLORE, *, run: str = "run", time_ns: int = S) -> events.MissionStarted:
    """A tree, from names indented by two blanks a level."""
    nodes: list[events.NodeInfo] = []
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
        nodes.append(events.NodeInfo(line.strip(), "ActionLeaf", path, parent))
    return events.MissionStarted(time_ns, run, nodes[0].name, tuple(nodes))


def requirement(
    name: str, verdict: str, margin: str = "", *, run: str = "run", time_ns: int = S
) -> events.RequirementChanged:
    """What a requirement of speed has come to, half a second after the start."""
    return events.RequirementChanged(
        time_ns=time_ns,
        run=run,
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
        self.run = ""
        self.now_ns = S
        self.commands: list[ControlRequest] = []
        self.asked = 0
        self.closed = False
        self.has_camera = False
        self.image: messages.CameraImage | None = None
        self._sequence = 0
        self._statuses: list[messages.NodeStatus] = []
        self._told: list[messages.Told] = []
        self._robot: list[messages.Robot] = []
        self._answers: list[ControlResponse] = []

    # ---- what the test has it tell -------------------------------------------------------

    def begin(self, run: str = "run") -> events.MissionStarted:
        """A mission starts."""
        self.run, self._sequence = run, 0
        found = tree(self.outline, run=run, time_ns=self.now_ns)
        self.names = [node.name for node in found.nodes]
        self._statuses = [
            messages.NodeStatus(index, Status.INVALID, "") for index in range(len(found.nodes))
        ]
        self._told.append(found)
        self.stand("running")
        return found

    def change(self, after_s: float = 0.0, /, **statuses: str) -> messages.Changes:
        """Nodes change: ``change(1.0, drive="success: canceled")``; ``_`` stands for a blank."""
        self.now_ns += round(after_s * S)
        self._sequence += 1
        changes = []
        for name, words in statuses.items():
            status, _, message = words.partition(": ")
            index = self.names.index(name.replace("_", " "))
            changes.append(messages.NodeStatus(index, WORDS[status], message))
            self._statuses[index] = changes[-1]
        found = messages.Changes(self.now_ns, self.run, self._sequence, tuple(changes))
        self._told.append(found)
        return found

    def stand(self, status: str, reason: str = "") -> None:
        """The mission's state changes."""
        self._told.append(
            events.MissionStateChanged(self.now_ns, self.run, "explore", status, reason)
        )

    def say(self, text: str) -> None:
        """The mission says something."""
        self._told.append(events.LogLine(self.now_ns, self.run, text))

    def judge(self, after_s: float = 0.0, /, **verdicts: str) -> messages.Requirements:
        """Requirements have come to this: ``judge(is_slow="violated -0.1")``."""
        self.now_ns += round(after_s * S)
        found = messages.Requirements(
            self.now_ns,
            self.run,
            tuple(
                requirement(
                    name.replace("_", " "), *words.split(), run=self.run, time_ns=self.now_ns
                )
                for name, words in verdicts.items()
            ),
        )
        self._told.append(found)
        return found

    def detail(self, after_s: float = 0.0, **fields: Any) -> messages.DetailsUpdate:
        """Details, with nothing in them but what is given."""
        self.now_ns += round(after_s * S)
        empty: dict[str, Any] = {
            "ticks": 1,
            "goals_sent": 0,
            "running": (),
            "goals": (),
            "variables": (),
            "breakpoints": (),
        }
        found = messages.DetailsUpdate(self.now_ns, self.run, **{**empty, **fields})
        self._told.append(found)
        return found

    def progress(
        self, name: str, value: float, limit: float, message: str = ""
    ) -> events.NodeProgress:
        """How far a node has come, for :meth:`detail`."""
        index = self.names.index(name)
        return events.NodeProgress(index, self.now_ns, message, "travelled", value, limit)

    def show(self, *robot: messages.Robot) -> None:
        """The robot tells of itself."""
        self._robot += robot

    def answer(self, text: str, *, is_done: bool = True) -> None:
        """What became of a wish."""
        self._answers.append(ControlResponse(is_done, text))

    def forget(self) -> None:
        """What was told so far is lost on its way."""
        self._told.clear()

    @property
    def statuses(self) -> messages.Statuses:
        """What the service for latecomers answers."""
        return messages.Statuses(self.run, self._sequence, tuple(self._statuses))

    # ---- a source ------------------------------------------------------------------------

    def take(self, *, needs_statuses: bool) -> Heard:
        if needs_statuses and self.is_there:
            self.asked += 1
            self._told.append(self.statuses)
        image, self.image = self.image, None
        heard = Heard(tuple(self._told), tuple(self._robot), tuple(self._answers), image)
        for queue in (self._told, self._robot, self._answers):
            queue.clear()
        return heard

    def send(self, command: ControlRequest) -> None:
        self.commands.append(command)

    def watch_camera(self, *, is_on: bool) -> None:
        self.has_camera = is_on

    def close(self) -> None:
        self.closed = True


class ScriptedGraph:
    """A graph with executives that the test plays."""

    where = "a test"

    def __init__(self, *executives: ScriptedExecutive) -> None:
        self.executives = list(executives)
        self.faults: dict[str, FoundExecutive] = {}
        self.served = 0

    def serve(self) -> None:
        self.served += 1

    def find(self) -> tuple[FoundExecutive, ...]:
        there = [one.name for one in self.executives if one.is_there]
        return tuple(self.faults.get(name, FoundExecutive(name)) for name in there)

    def attach(self, name: str) -> ScriptedExecutive:
        for one in self.executives:
            if one.name == name:
                one.closed = False
                return one
        raise AssertionError(name)
