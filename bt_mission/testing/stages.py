"""What the fixture ``stage`` is: a stage for one run after another, and what takes part in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from pydantic_core import PydanticCustomError
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.base.clock_watch import UNATTENDED_S
from bt_mission.base.dds.discovery import isolate
from bt_mission.base.diagnostics import InputError
from bt_mission.base.files import find
from bt_mission.base.nature import NO_NATURE, Nature
from bt_mission.base.nature_field import read_nature
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.expressions.values import Plain
from bt_mission.language.inputs import named_inputs
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission
from bt_mission.ros.graph import SharedContext
from bt_mission.scenarios.faults import Faults, PlannedFault, parse_fault
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.located import planned_in
from bt_mission.scenarios.faults.plan import FaultPlan
from bt_mission.scenarios.faults.targets import scripted_on
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import attend
from bt_mission.scenarios.scenario import Scenario, ScenarioResult
from bt_mission.sessions.check import examine
from bt_mission.sessions.playing import MISSION as ALONE
from bt_mission.sessions.scripted_server import ScriptedServer
from bt_mission.testing.failure_recording import FailureRecording
from bt_mission.testing.moment import Condition, Moment
from bt_mission.testing.options import MOST_RUNS
from bt_mission.testing.programs import ProgramRun
from bt_mission.testing.run import Run


class Stages:
    """Runs missions in separate simulations, one after another.

    They are isolated from other processes. Runs that a test does not end, end with it.

    Args:
        folder: For worlds, pictures, and what failed runs leave.
        seed: Of every run without a seed; None for the mission's.
        nature: Of every run for which neither the test nor its files say it.
        records: Record every run, in the folder.
        replay: Gives what to type to see a run again, if the test fails.
    """

    def __init__(
        self,
        folder: Path,
        seed: int | None = None,
        *,
        nature: Nature = NO_NATURE,
        records: bool = False,
        replay: Callable[[Run], str] | None = None,
    ) -> None:
        self.folder = folder
        self.seed = seed
        self.nature = nature
        self._records = records
        self._replay = replay
        self.runs: list[Run] = []
        self.left_behind: list[str] = []
        self.failing: list[str] = []
        """Requirements that fail, and that no test expected to be violated."""
        self.not_violated: list[str] = []
        """Requirements that a test expected to be violated."""
        self.unread: list[str] = []
        """A line for each check that does not hold and that the test has not looked at."""
        self.untested: list[str] = []
        """A line for each thing that the test has prepared and that has not happened."""
        self.faults = Faults()
        self.spawn_box = self.faults.spawn_box
        self.spawn_cylinder = self.faults.spawn_cylinder
        self.move_box = self.faults.move_box
        self.remove_box = self.faults.remove_box
        self._plans: list[FaultPlan] = []
        self._idle: set[ScriptedServer] = set()
        """Servers that need get no goal."""
        self.scripted: dict[str, ScriptedServer] = {}
        """The servers that the test plays, by the full names of their actions."""
        self._exit = ExitStack()
        self._is_closed = False
        self._context: Context | None = None

    def run(
        self,
        mission: str | Path | Mission,
        *,
        world: str | Path | None = None,
        robot: str | None = None,
        seed: int | None = None,
        inputs: Mapping[str, Plain] | None = None,
        observe: float | None = None,
        nature: str | Mapping[str, float] | Nature | None = None,
        **options: Any,
    ) -> Run:
        """Put a mission on the stage, ready for its first step.

        Args:
            mission: A file, the name of a shipped mission, or a mission as text (of several lines).
            world: A file, the name of a shipped world, or a world as text; instead of the
                mission's.
            robot: Instead of the mission's.
            seed: Of everything random; instead of the test's (``@pytest.mark.scenario``), and of
                the mission's.
            inputs: Values of the mission's inputs.
            observe: How long the run continues after the mission's end, s; instead of the
                mission's.
            nature: A profile, or a mapping with numbers (`docs/reference/nature.md`); instead of
                the mission's or the world's.
            options: For :class:`bt_mission.sessions.stage_robot.StageOptions`.

        Raises:
            InputError: With every fault of the mission, world or robot.
            ScenarioError: While another run is on the stage, and for an invalid nature.
        """
        self._clear()
        if nature is not None:
            options["nature"] = _nature(nature)
        changes: dict[str, Any] = {
            "set": dict(inputs or {}),
            "seed": self.seed if seed is None else seed,
            "world": None if world is None else str(self.world(world)),
            "robot": robot,
        }
        chosen = self.mission(mission, **changes)
        if observe is not None:
            chosen = replace(chosen, observe=observe)
        return self._begin(chosen, options)

    def program(
        self,
        file: str | Path,
        *,
        arguments: Sequence[str] = (),
        world: str | Path | None = None,
        robot: str | None = None,
        seed: int | None = None,
        **options: Any,
    ) -> ProgramRun:
        """Start a program, unchanged, beside the run on the stage, or alone.

        ``client = stage.program("client.py", arguments=["--speed", "0.2"])``

        Args:
            file: A Python file, a module, or a console script of an installed package.
            arguments: After its name on the command line.
            world: A file, name or text, if it is alone; so are `robot` and `seed`.
            options: If it is alone, for
                :class:`bt_mission.sessions.stage_robot.StageOptions`: ``without=["turn"]``.

        Raises:
            PythonError: The file does not exist, or is no program.
            ScenarioError: There is a run, and a world, robot, seed or option is given.
        """
        given = {"world": world, "robot": robot, "seed": seed, **options}
        run = self._present
        if run is None:
            run = self.run(ALONE, **given)
        elif any(value is not None for value in given.values()):
            names = ", ".join(name for name, value in given.items() if value is not None)
            raise ScenarioError(f"{names}: there is a stage already; pass it to the first program")
        return ProgramRun(file, arguments, run)

    def until(self, condition: Condition, *, within: float = 60.0) -> Moment:
        """Run what is on the stage until a condition holds: see :meth:`Run.until`.

        Raises:
            NeverHeldError: It has not held after `within` seconds.
            ScenarioError: Nothing is on the stage.
        """
        if self._present is None:
            raise ScenarioError("nothing is on the stage: call stage.run or stage.program first")
        return self._present.until(condition, within=within)

    @property
    def _present(self) -> Run | None:
        """The run that is on the stage."""
        return self.runs[-1] if self.runs and not self.runs[-1].is_done else None

    def plan(self, run: Run, *faults: str | PlannedFault) -> FaultPlan:
        """Have faults begin in a run at their times or on their conditions.

        ``stage.plan(run, "at 5.0: drop scan lasting 2")``

        Args:
            faults: As text, or as strategies draw them.

        Raises:
            ExpressionError: For a text that is not a fault.
        """
        planned = [parse_fault(fault) if isinstance(fault, str) else fault for fault in faults]
        plan = FaultPlan(run, planned)
        self._plans.append(plan)
        return plan

    def run_scenario(self, scenario: str | Path | Scenario) -> ScenarioResult:
        """Run a scenario; return its result. :attr:`runs` has the run.

        Raises:
            InputError: With every error of the file, and of names that its faults find nothing of.
        """
        if not isinstance(scenario, Scenario):
            scenario = load_scenario(scenario)
        self._clear()
        with scenario.at_its_start():
            run = self._begin(scenario.mission, scenario_options(scenario))
        run.expect_violation(*scenario.expect.violated)
        with planned_in([run], scenario.faults) as with_outcomes:
            attend(run.stage, scenario)
            while not run.is_done:
                run.step()
            return scenario.judge(with_outcomes(run.stage.report()))

    def mission(self, mission: str | Path | Mission, **changes: Any) -> Mission:
        """A valid mission; servers can still refuse its goals.

        Raises:
            InputError: With all its faults.
        """
        if isinstance(mission, Mission):
            seed = changes.pop("seed", None)
            given = {name: value for name, value in changes.items() if value}
            if given:
                names = ", ".join(given)
                raise ScenarioError(f"{names}: give the mission as file or text to change them")
            return mission if seed is None else replace(mission, seed=seed)
        text = str(mission)
        source = text if "\n" in text else mission_file(mission)
        try:
            return required(examine(source, servers=None, **changes))
        except InputError as error:
            raise InputError(map(named_inputs, error.diagnostics)) from None

    def world(self, world: str | Path) -> str | Path:
        """A world's name or file; a world as text is written to a file."""
        text = str(world)
        if "\n" not in text:
            return world
        number = sum(1 for _ in self.folder.glob("world_*.yaml")) + 1
        path = self.folder / f"world_{number}.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    def scripted_server(
        self,
        name: str,
        type_name: str | None = None,
        *,
        may_not_be_asked: bool = False,
        **habits: Any,
    ) -> ScriptedServer:
        """An action server that the test plays, in place of the shipped one.

        Args:
            name: Of the action; a short name of the mission language will do.
            type_name: Such as ``bt_mission_interfaces/action/Turn``; known for short names.
            may_not_be_asked: If not, a test fails in which it gets no goal.
            habits: Of :class:`ScriptedServer`.

        Raises:
            ScenarioError: When the type is not known, and while a run is on the stage.
        """
        self._clear()
        if type_name is None:
            if name not in ACTION_NAMES:
                raise no_such("short name of an action", name, sorted(ACTION_NAMES))
            short = ACTION_NAMES[name]
            name, type_name = short.name, short.type
        server = ScriptedServer(self.node(f"scripted_{name}"), type_name, name, **habits)
        self.scripted[server.node.resolve_topic_name(name)] = server
        if may_not_be_asked:
            self._idle.add(server)
        return server

    def node(self, name: str) -> Node:
        """A bare node, which goes with the stage."""
        node = Node(
            name.replace("/", "_"),
            context=self.context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._exit.callback(node.destroy_node)
        return node

    @property
    def context(self) -> Context:
        """The rclpy context of everything on this stage; made when it is first needed."""
        if self._context is None:
            isolate(visible=False)
            self._context = SharedContext()
            rclpy.init(context=self._context)
            self._exit.callback(self._context.shutdown)
        return self._context

    def close(self) -> None:
        """End what runs, and take everything down; once is enough."""
        if self._is_closed:
            return
        self._is_closed = True
        try:
            for run in self.runs:
                self.left_behind += run.close()
                self.failing += run.failing_requirements
                self.not_violated += run.missing_violations
                self.unread += run.unread_checks
            self.untested += self._untested()
        finally:
            self._exit.close()

    def _untested(self) -> Iterator[str]:
        for run in self.runs:
            yield from run.untested
        for plan in self._plans:
            yield from (f"fault {outcome}" for outcome in plan.outcomes() if outcome.fails)
        planned = {id(fault) for plan in self._plans for fault in plan.faults}
        for run in self.runs:
            planned |= {id(action) for pending in run.pending for action in pending.actions}
        for fault in self.faults.made:
            if not fault.was_applied and id(fault) not in planned:
                yield f"{fault!r} was never begun: pass it to run.do, run.at or run.when"
        for name, server in self.scripted.items():
            if not server.goals and server not in self._idle:
                yield (
                    f"the scripted server of {name} got no goal: remove it, or allow it by "
                    "may_not_be_asked=True"
                )

    def _begin(self, mission: Mission, options: Mapping[str, Any]) -> Run:
        """Put a mission on the stage."""
        options = dict(options)
        without = options.pop("without", ())
        made = Run(
            mission,
            self.folder,
            context=self.context,
            without=(*(name.strip("/") for name in self.scripted), *without),
            **{
                "props": MOST_OBSTACLES,
                "default_nature": self.nature,
                "hold_limit_s": UNATTENDED_S,
                **options,
            },
        )
        made.scripted = {**self.scripted, **scripted_on(made.stage)}
        made.make_node = self.node
        for server in self.scripted.values():
            made.stage.add_node(server.node)
        if self._replay is not None:
            made.replay_command = partial(self._replay, made)
        self.runs.append(made)
        if self._records:
            self._record(made)
        return made

    def _record(self, run: Run) -> None:
        run.recording = FailureRecording(
            run.stage, self.folder / f"recording_{len(self.runs)}.mcap"
        )
        for old in self.runs[-MOST_RUNS - 1 : -MOST_RUNS]:
            if old.recording is not None:
                old.recording.discard()

    def _clear(self) -> None:
        """Take a run that has ended off the stage."""
        for run in self.runs:
            if not run.is_done:
                raise ScenarioError(
                    f"'{run.mission.name}' is still on the stage: call run.until_done() or "
                    f"run.close() before the next one, or use separate stages"
                )
            self.left_behind += run.close()


def scenario_options(scenario: Scenario) -> dict[str, Any]:
    """Return what a scenario says of its stage."""
    options = scenario.stage_options
    return {
        name: getattr(options, name) for name in ("world", "simulator", "start", "nature", "nodes")
    }


def _nature(written: str | Mapping[str, float] | Nature) -> Nature:
    try:
        return read_nature(written)
    except PydanticCustomError as error:
        raise ScenarioError(f"nature: {error.message()}") from None


def mission_file(name: str | Path) -> Path:
    """Return the path of a mission: a file, or a shipped one by its name."""
    path = Path(name)
    if not path.suffix and len(path.parts) == 1 and not path.exists():
        return find("missions", path)
    return path
