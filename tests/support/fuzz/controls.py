"""Services, goals of execute_mission and parameters by which others hold our executive and servers.

A case is a program of bytes: calls of services in any order, with any values, while a mission runs
or none does; missions as goals; parameters that are set.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Coroutine, Iterator
from functools import cache
from inspect import iscoroutine
from pathlib import Path
from random import Random
from typing import Any

from bt_mission_interfaces.action import ExecuteMission
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from action_servers.driving.turn import TURNING
from action_servers.navigation.path import NAVIGATION
from action_servers.server.node import declare_server_parameters, limited
from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.controls import MOST_BREAKPOINTS, MissionControls
from bt_mission.executive.executive import Executive
from bt_mission.executive.revision import RevisionPlan
from bt_mission.executive.trace import Trace
from bt_mission.language.mission import Mission
from bt_mission.language.revision import Revision
from bt_mission.robots.model import load_robot
from bt_mission.ros.control_services import ControlServices
from bt_mission.ros.executors.process import RobotNode, RobotNodeOptions
from bt_mission.sessions.served_missions import ServedMissions
from tests.support.fuzz.finding import Case, Verdict
from tests.support.fuzz.goals import missions
from tests.support.fuzz.graph import Graph
from tests.support.fuzz.program import ProgramPlay
from tests.support.fuzz.targets import Target
from tests.support.project import ROOT

S = 1_000_000_000
NAMES = (
    *("turn", "sequence", "m", "0", "0.0", "0.1.0", "check", "retry", "", "nobody", "tur", "TURN"),
    *("x" * 2_000, "é", "\x1b[2J", "a\nb", "0.0.0.0.0", "explore_forward", "../..", "\x00", "wait"),
)
PATHS = (
    *("square", "square.yaml", "missions/square.yaml", "", "../../etc/passwd", "/dev/zero", "."),
    *("/", "loop.yaml", "folder.yaml", "outside.yaml", "m.xml", "x" * 5_000, "a\x00b", "é.yaml"),
    *("~", "*"),
)
TEXTS = (
    "mission: m\ntree: {wait: 1}\n",
    "mission: m\ninputs: {angle: 90}\ntree: {turn: {angle: $angle}, timeout: 5}\n",
    "mission: m\ninclude: [parts.yaml]\ntree: {wait: 1}\n",
    "mission: m\ntree: {python: 'os:system'}\n",
    "mission: m\ntree: {sequence: [{log: $x}]}\n",
    "\x00",
    "mission: " + "[" * 500,
    "&a [*a]",
    "x" * 10_000,
)
INPUTS = (
    *("angle=45", "angle=", "=", "angle", "angle=.nan", "x=1", "angle=[1, 2]"),
    "angle=" + "9" * 400,
)
SEEDS = (-1, 0, 7, -2, 2**31 - 1, -(2**31), 2**62)
VALUES: tuple[Any, ...] = (
    *(0, 1, -1, 2**62, -(2**62), 0.0, 0.5, -0.5, 1e308, float("nan"), float("inf"), -float("inf")),
    *(True, False, "", "refuse", "replace", "x" * 5_000, "é", None),
    *([1, 2], [0.5], ["a"], [True], [b"\xff"]),
)
SETTLING_TICKS = 200
LONGEST = 80


def _result_of(answer: Coroutine[Any, Any, Any]) -> Any:
    """Return the result of a coroutine that awaits nothing."""
    try:
        answer.send(None)
    except StopIteration as end:
        return end.value
    raise AssertionError("a service that waits for a tick")


class _Node:
    """As much of a node as offers services."""

    def __init__(self) -> None:
        self.services: dict[str, tuple[Any, Callable[[Any, Any], Any]]] = {}

    def create_service(
        self, kind: Any, name: str, callback: Callable[[Any, Any], Any], **_: Any
    ) -> str:
        self.services[name.removeprefix("~/")] = kind, callback
        return name

    def destroy_service(self, name: str) -> None:
        del self.services[name.removeprefix("~/")]


@cache
def _parameters() -> RobotNode:
    """Return a node with the parameters of the action servers."""
    from tests.support.fuzz.peer import node  # noqa: PLC0415 - starts ROS

    made = RobotNode("fuzzed_servers", RobotNodeOptions(context=node().context))
    robot = limited(made, load_robot("waffle"))
    declare_server_parameters(made, robot, Path("images"))
    made.declare_all(TURNING)
    made.declare_all(NAVIGATION)
    return made


class Play(ProgramPlay):
    """An executive's services, and who uses them."""

    def __init__(self, contents: bytes) -> None:
        super().__init__(contents)
        self.node = _Node()
        self.executive: Executive | None = None
        self.graph: Graph | None = None
        self.mission: Mission | None = None
        self.controls = MissionControls(lambda: self.executive)
        self.services = ControlServices(
            self.node,  # type: ignore[arg-type]
            self.controls,
            self._revise,
        )
        self.served = ServedMissions(
            (Path("served").resolve(),) if self.program.chance(0.8) else (),
            allow_text=self.program.chance(0.8),
        )

    def run(self) -> None:
        acts = (
            *(self._begin, self._tick, self._tick, self._tick, self._call, self._call),
            *(self._call, self._call, self._call, self._goal, self._set),
        )
        while self.program:
            self.log.append(self.program.pick(acts)())
        self._settle()
        self.services.close()
        assert not self.node.services, "services are left"

    def _begin(self) -> str:
        self._settle()
        mission = self.mission = self.program.pick(missions())
        self.graph = Graph(Scope(dict(mission.inputs), 1), Random(self.program.byte()))
        self.executive = Executive(build_tree(mission, self.graph.scope), self.graph, Trace())
        self.controls.begin(self.executive)
        return "a mission begins"

    async def _revise(self, request: Any) -> Revision:
        assert self.executive is not None
        assert self.graph is not None
        assert self.mission is not None

        def accept(mission: Mission) -> None:
            self.mission = mission

        version = self.program.pick(missions())
        plan = RevisionPlan(
            self.executive, self.graph, self.mission, version, keep_goals=request.keep_goals
        )
        plan.build()
        return plan.preview() if request.dry_run else plan.apply(lambda _: None, accept)

    def _tick(self) -> str:
        if self.executive is None or self.graph is None:
            return "no mission"
        self.graph.move()
        self.executive.tick()
        return f"tick: {self.executive.mission_state.status}"

    def _settle(self) -> None:
        executive, self.executive = self.executive, None
        if executive is None or self.graph is None:
            return
        executive.interrupt("enough")
        self.graph.stop_delaying()
        for _ in range(SETTLING_TICKS):
            if executive.is_done:
                return
            self.graph.move()
            executive.tick()
        raise AssertionError("the mission does not end")

    def _call(self) -> str:
        name = self.program.pick(sorted(self.node.services))
        kind, callback = self.node.services[name]
        request = kind.Request()
        for part in request.get_fields_and_field_types():
            if isinstance(getattr(request, part), list):
                continue
            is_text = isinstance(getattr(request, part), str)
            value = self.program.pick(NAMES) if is_text else self.program.chance(0.5)
            setattr(request, part, value)
        answer = callback(request, kind.Response())
        if iscoroutine(answer):
            answer = _result_of(answer)
        serialize_message(answer)
        assert answer.message, "an answer without words"
        assert "Traceback" not in answer.message
        if hasattr(answer, "breakpoints"):
            assert len(answer.breakpoints) <= MOST_BREAKPOINTS, "more breakpoints than may be"
        self._check(name, is_done=answer.success)
        return f"{name}: {answer.success}, {answer.message[:100]}"

    def _check(self, name: str, *, is_done: bool) -> None:
        if not is_done or name == "breakpoint":
            return
        executive = self.executive
        assert executive is not None, f"{name} of no mission has succeeded"
        if name == "pause":
            assert executive.status == "paused", "a pause that pauses nothing"
        if name == "resume":
            assert executive.status == "running", "paused after a resume"
        if name == "stop":
            assert not executive.status.is_active, "runs after a stop"

    def _goal(self) -> str:
        goal = ExecuteMission.Goal()
        if self.program.chance(0.5):
            goal.path = self.program.pick(PATHS)
        if self.program.chance(0.5):
            goal.text = self.program.pick(TEXTS)
        goal.seed = max(min(self.program.pick(SEEDS), _most_seed()), -_most_seed() - 1)
        goal.inputs = [self.program.pick(INPUTS) for _ in range(self.program.byte() % 3)]
        try:
            mission = self.served.load(goal)
        except BtMissionError as error:
            text = error.on_one_line if isinstance(error, InputError) else str(error)
            assert text, "a goal is refused without words"
            return f"goal refused: {text[:100]}"
        return f"goal taken: {mission.name}"

    def _set(self) -> str:
        node = _parameters()
        names = sorted(node._parameters)
        name = self.program.pick((*names, "nobody", ""))
        value = self.program.pick(VALUES)
        before = dict(node._parameters)
        asked = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        service: Any = node._parameter_service
        (result,) = service._set_parameters_callback(asked, SetParameters.Response()).results
        serialize_message(result)
        if result.successful:
            # rclpy takes a parameter without a name that nobody has declared; nobody reads it.
            kept = node._parameters[name] if name in before else None
            is_number = kept is None or kept.value == kept.value
            assert is_number, f"{name} is no number"
            node._parameters.clear()
            node._parameters.update(before)
        else:
            assert result.reason, "a parameter is refused without words"
        return f"{name} = {str(value)[:40]}: {result.successful} {result.reason[:100]}"


@cache
def _most_seed() -> int:
    kind = ExecuteMission.Goal.get_fields_and_field_types()["seed"]
    return int(2 ** (int(kind.removeprefix("int")) - 1) - 1)


def prepare(folder: Path) -> None:
    """Put missions that are served into a folder."""
    served = folder / "served"
    served.mkdir()
    shutil.copy(ROOT / "missions/square.yaml", served)
    (served / "folder.yaml").mkdir()
    (served / "loop.yaml").symlink_to("loop.yaml")
    (served / "outside.yaml").symlink_to(ROOT / "missions/patrol.yaml")
    (served / "m.xml").write_text("<root/>", encoding="utf-8")


def judge(path: Path) -> Verdict:
    """Play a program: no exception, and every answer has words and is true."""
    play = Play(path.read_bytes())
    finding = play.finding()
    is_accepted = finding is None and any(": True" in line for line in play.log)
    return Verdict(is_accepted, finding=finding, inputs=max(len(play.log), 1))


def samples(_: None) -> Iterator[Case]:
    """Yield programs in which everything happens once."""
    for number in range(0, 256, 8):
        yield Case("m.controls", bytes((0, 0, 0, number, 1, *range(number, 255, 3))))


def case(_: None, seed: int, number: int) -> Case:
    """Return a program."""
    rng = Random(f"{seed}/{number}")
    begin = bytes((rng.randrange(256), 0, 0, rng.randrange(256), 1))
    return Case("m.controls", begin + rng.randbytes(rng.randint(5, LONGEST)))


TARGET = Target(lambda: None, samples, case, judge, prepare)
