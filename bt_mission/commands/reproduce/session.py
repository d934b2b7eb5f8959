"""From recordings to a case: read, derive, run, compare, and search what had to be guessed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find
from bt_mission.base.output import make_folder, write_file
from bt_mission.base.text import counted
from bt_mission.base.yaml.document import read
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.cli.recorded_scenario import record_scenario
from bt_mission.commands.falsify.strategies import OptunaStrategy, RandomStrategy, Strategy
from bt_mission.commands.reproduce.case import MISSION, WORLD, CaseFiles, write_mission_files
from bt_mission.commands.reproduce.comparison import (
    RunComparison,
    RunEnd,
    compare,
    differences,
    outcome_of,
)
from bt_mission.commands.reproduce.diagnosed import DiagnosedFault
from bt_mission.commands.reproduce.diagnosis import diagnose
from bt_mission.commands.reproduce.evidence import Evidence, EvidenceReader
from bt_mission.commands.reproduce.guesses import Guesses
from bt_mission.commands.reproduce.joined import (
    files_in,
    is_whole,
    join,
    refuse_jumps,
    renamed,
    required,
)
from bt_mission.commands.reproduce.matching import matched
from bt_mission.commands.reproduce.mission import mission_data
from bt_mission.commands.reproduce.picture import picture
from bt_mission.commands.reproduce.surroundings import StaticSurroundings, pose_data, world_data
from bt_mission.executive.report import Report
from bt_mission.recording.facts import RunFacts
from bt_mission.recording.model import RecordedRun
from bt_mission.recording.reader import read_run
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.verification import RecordedRequirements
from bt_mission.requirements.checks import RequirementNames, read_requirements
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.scenarios.concrete.base_scenario import requirements_in_files
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.sessions.pose_checks import PoseChecker
from sim.world.loader import load_world

LONGER_S = 5.0
BATCH = 4

Say = Callable[[str], None]


@dataclass(frozen=True)
class ReproduceOptions:
    """The options of a reproduction.

    Attributes:
        topics: Texts such as ``scan:=/front/scan``.
        requirements: Files.
        violated: Requirements that are known to be violated, though the recording cannot show it.
        robot: The name or file of the robot's model; None is that of the recording.
        budget: The most runs of the simulation.
        seed: Of the search.
    """

    topics: Sequence[str] = ()
    requirements: Sequence[Path] = ()
    violated: Sequence[str] = ()
    robot: str | None = None
    name: str | None = None
    budget: int = 12
    seed: int = 0


@dataclass
class Reproduction:
    """The result."""

    case: CaseFiles
    diagnosed: Sequence[DiagnosedFault]
    faults: Sequence[PlannedFault]
    """Those of the scenario, after the search."""
    comparison: RunComparison
    report: Report
    runs: int
    unexplained: Sequence[str]
    picture: Path
    notes: Sequence[str] = ()
    world_shapes: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        comparison = self.comparison
        chosen = {fault.name for fault in self.faults}
        return {
            "name": self.case.name,
            "faults": [each.as_dict() for each in self.diagnosed],
            "scenario_faults": [fault.text for fault in self.faults],
            "left_out": sorted({each.name for each in self.diagnosed} - chosen),
            "path_error_m": {"mean": comparison.mean, "largest": comparison.largest},
            "verdict_recorded": comparison.wanted.as_dict(),
            "verdict_simulated": comparison.got.as_dict(),
            "repeated": comparison.is_repeated,
            "goals_recorded": list(comparison.recorded),
            "goals_simulated": list(comparison.simulated),
            "events": [
                {"what": event.what, "recorded": event.recorded, "simulated": event.simulated}
                for event in comparison.events
            ],
            "unexplained": list(self.unexplained),
            "runs": self.runs,
            "scenario": str(self.case.scenario_file),
            "picture": str(self.picture),
        }


@dataclass
class _Recorded:
    """What was read of the recordings."""

    path: Path
    file: RecordedFile
    evidence: Evidence
    run: RecordedRun | None
    """The mission's own run, if the recording has it."""
    robot: RobotModel
    robot_name: str
    notes: list[str] = field(default_factory=list)


def reproduce(
    paths: Sequence[Path], folder: Path, options: ReproduceOptions, say: Say = lambda _: None
) -> Reproduction:
    """Reproduce a recorded run; write the case into a folder.

    Raises:
        RecordingError: A file is not a recording.
        ReproduceError: A recording lacks what is needed.
        InputError: A requirement or a robot is wrong.
    """
    files, roles = files_in(paths), renamed(options.topics)
    with TemporaryDirectory() as place:
        path = files[0]
        if not is_whole(files, roles):
            path = Path(place) / "joined.mcap"
            join(files, roles, path)
        recorded = _read(path, files[0], options)
        say(f"read {recorded.evidence.end_s:.1f} s; looking for what went wrong")
        return _Reproducer(recorded, folder, options, Path(place), say).run()


def _read(path: Path, shown: Path, options: ReproduceOptions) -> _Recorded:
    file = RecordedFile(path)
    reader = EvidenceReader.of(file)
    facts = RunFacts(file.notes, file.node)
    run = None
    with suppress(RecordingError):
        run = read_run(path) if facts.node else None
    start_ns = None if run is None else run.start_ns
    first_ns = file.first_ns or 0
    refuse_jumps(shown, reader.largest_back_ns, max(file.last_ns - first_ns, 0))
    evidence = reader.evidence(shown, start_ns)
    required(shown, evidence.counts, tracks=len(evidence.track))
    evidence = matched(evidence)
    name = options.robot or facts.texts.get("robot") or "waffle"
    try:
        robot = load_robot(find("robots", name))
    except InputError:
        if options.robot:
            raise
        name = "waffle"
        robot = load_robot(find("robots", name))
    notes = []
    if file.why_cut:
        notes.append(f"the recording is cut: {file.why_cut}")
    if file.missing:
        notes.append(f"it lacks {file.missing}")
    if evidence.ignored:
        notes.append(f"other robots are left out: {', '.join(evidence.ignored[:4])}")
    if not evidence.is_localised:
        notes.append("nothing places the robot on a map: poses follow from odometry and scans")
    return _Recorded(path, file, evidence, run, robot, name, notes)


class _Reproducer:
    """Makes the case of what was read."""

    def __init__(
        self, recorded: _Recorded, folder: Path, options: ReproduceOptions, place: Path, say: Say
    ) -> None:
        self._recorded, self._folder = recorded, folder
        self._options, self._place, self._say = options, place, say
        self._runs = 0
        self._simulated: dict[tuple[str, ...], tuple[RunComparison, Report, Evidence]] = {}
        self._first_error: BtMissionError | None = None

    def run(self) -> Reproduction:
        evidence = self._recorded.evidence
        diagnosis = diagnose(evidence, self._recorded.robot)
        diagnosed, around, things = diagnosis.faults, diagnosis.around, diagnosis.things
        name = self._options.name or _name(evidence.path)
        make_folder(self._folder)
        case = self._case(name, around)
        faults = self._nearest(case, Guesses(diagnosed))
        comparison, report, simulated = self._simulated[_key(faults)]
        unexplained = [*differences(comparison), *self._open_questions(comparison)]
        sentence = _sentence(evidence.path, comparison)
        notes = [sentence, *(str(each) for each in diagnosed)]
        case.write(faults, notes)
        image = self._folder / f"{name}.png"
        write_file(image, picture(sentence, evidence, around, things, simulated))
        return Reproduction(
            case,
            diagnosed,
            faults,
            comparison,
            report,
            self._runs,
            unexplained,
            image,
            self._recorded.notes,
            len(around.shapes),
        )

    # ---- the case ------------------------------------------------------------------------

    def _case(self, name: str, around: StaticSurroundings) -> CaseFiles:
        recorded, folder = self._recorded, self._folder
        evidence, run = recorded.evidence, recorded.run
        start = evidence.track.pose(0.0)
        world = self._own_world()
        if world is not None:
            write_file(folder / WORLD, world)
        else:
            source = "a map of its scans" if around.is_mapped else "its map"
            description = f"Traced from {evidence.path.name}: {source}."
            data = world_data(f"{name} world"[:60], around, start, evidence, description)
            write_file(folder / WORLD, to_yaml(data))
        head: dict[str, Any] = {
            "scenario": name,
            "description": f"A recorded run, {evidence.path.name}.",
            "mission": MISSION,
            "world": WORLD,
            "robot": recorded.robot_name,
            "start": pose_data(start),
        }
        if run is not None and (main := str(run.facts.get("file", ""))) in run.files:
            write_mission_files(folder, run.files, main)
            head["inputs"] = dict(run.inputs)
            head["seed"] = int(run.facts.get("seed", 0))
        else:
            checker = PoseChecker(load_world(folder / WORLD), recorded.robot)
            data = mission_data(
                name,
                evidence,
                recorded.robot_name,
                lambda x, y: checker.reaches((start.x, start.y), (x, y)),
            )
            write_file(folder / MISSION, to_yaml(data))
        wanted, more = self._wanted()
        requirements = {**more, **requirements_in_files(self._options.requirements)}
        if requirements:
            head["requirements"] = requirements
        is_open = wanted.outcome == "interrupted"
        head["limit"] = round(max(evidence.end_s + (0.0 if is_open else LONGER_S), 1.0), 2)
        return CaseFiles(name, folder, head, wanted)

    def _own_world(self) -> str | None:
        """Return the world of a recorded simulation."""
        run = self._recorded.run
        world = "" if run is None else str(run.facts.get("world", ""))
        if run is None or not world:
            return None
        names = [name for name in run.files if name.startswith("worlds/") or name == world]
        return run.files[names[0]] if len(names) == 1 else None

    def _wanted(self) -> tuple[RunEnd, Mapping[str, Any]]:
        """Return the recorded verdict, and the requirements that the mission's file lacks."""
        recorded, options = self._recorded, self._options
        run = recorded.run
        requirements = RecordedRequirements(recorded.path)
        own = requirements.own()
        known = [requirement.name for requirement in own]
        names = requirements.names if run is not None else RequirementNames()
        more = read_requirements(options.requirements, names, ())
        written = {requirement.name for requirement in more}
        every = [*(each for each in own if each.name not in written), *more]
        results = requirements.verify(every).results if every else ()
        violated = [result.name for result in results if result.verdict == "violated"]
        unknown = sorted(set(options.violated) - {*known, *written})
        if unknown:
            raise BtMissionError(
                f"--violated {unknown[0]}: there is no such requirement (known: "
                f"{', '.join([*known, *sorted(written)]) or 'none'})",
                code="BT-1102",
            )
        violated += [name for name in options.violated if name not in violated]
        outcome, reason = outcome_of(recorded.evidence), ""
        if run is not None and run.status in ("success", "failure", "interrupted"):
            outcome, reason = run.status, run.reason
        extra = {
            each.name: {"formula": each.text, "on_violation": each.on_violation}
            for each in own
            if each.name not in written and each.name not in self._in_mission_file()
        }
        return RunEnd(outcome, tuple(violated), reason), extra

    def _in_mission_file(self) -> frozenset[str]:
        """Return the names of the requirements in the written mission."""
        document = read(self._folder / MISSION)
        data = document.data.get("requirements") if isinstance(document.data, dict) else None
        return frozenset(data or ())

    # ---- runs ----------------------------------------------------------------------------

    def _nearest(self, case: CaseFiles, guesses: Guesses) -> tuple[PlannedFault, ...]:
        """Return the faults of the run that comes nearest."""
        best = guesses.as_it_is()
        nearest = self._score(case, best)
        for left_out in best if nearest == FAR else ():  # one that this stage cannot have
            fewer = tuple(fault for fault in best if fault is not left_out)
            nearest = self._score(case, fewer)
            if nearest < FAR:
                best = fewer
                break
        strategy: Strategy | None = None
        while self._runs < self._options.budget and not self._is_near(best) and guesses.count > 1:
            strategy = strategy or self._strategy(guesses)
            candidates = strategy.ask(min(BATCH, self._options.budget - self._runs))
            scores = []
            before = self._runs
            for candidate in candidates:
                scores.append(self._score(case, candidate.faults))
                if scores[-1] < nearest:
                    nearest, best = scores[-1], candidate.faults
                if self._is_near(best):
                    return best
            strategy.learn(scores)
            if self._runs == before:
                break
        if _key(best) not in self._simulated:
            assert self._first_error is not None
            raise self._first_error
        return best

    def _is_near(self, faults: tuple[PlannedFault, ...]) -> bool:
        known = self._simulated.get(_key(faults))
        return known is not None and known[0].is_near

    def _strategy(self, guesses: Guesses) -> Strategy:
        """Return what draws the guesses, and note if it is not the better one."""
        try:
            return OptunaStrategy(guesses, self._options.seed)
        except BtMissionError as error:
            note = f"guesses are drawn at random, which finds less: {error}"
            self._recorded.notes.append(note)
            return RandomStrategy(guesses, self._options.seed)

    def _score(self, case: CaseFiles, faults: tuple[PlannedFault, ...]) -> float:
        """Run the scenario with these faults; return how far it is from the recording."""
        key = _key(faults)
        if key in self._simulated:
            return self._simulated[key][0].score
        self._runs += 1
        path = self._place / f"run{self._runs}.mcap"
        try:
            report = record_scenario(case.scenario(faults), path).report
        except BtMissionError as error:
            self._first_error = self._first_error or error
            self._say(f"run {self._runs}: {error}")
            return FAR
        simulated = _read_simulated(path)
        path.unlink(missing_ok=True)
        got = RunEnd(
            report.status,
            tuple(result.name for result in report.requirements if result.verdict == "violated"),
            report.reason,
            tuple(fault.fault for fault in report.faults if fault.fails),
        )
        comparison = compare(self._recorded.evidence, simulated, case.verdict, got)
        self._simulated[key] = comparison, report, simulated
        mean = "no path" if comparison.mean is None else f"{comparison.mean:.3f} m"
        self._say(f"run {self._runs}: {report.status}, mean path difference {mean}")
        return comparison.score

    def _open_questions(self, comparison: RunComparison) -> list[str]:
        """Return what the recording shows and no fault explains."""
        if comparison.is_near:
            return []
        lines = self._recorded.evidence.lines
        return [f"the log at {at:.1f} s: {text}" for at, text in lines[:5]]


FAR = 100.0
"""The score of a run that could not be made."""


def _read_simulated(path: Path) -> Evidence:
    """Return the evidence of a simulated run; its start is known at its end."""
    file = RecordedFile(path)
    reader = EvidenceReader.of(file)
    return reader.evidence(path, file.facts.start_ns)


def _key(faults: Sequence[PlannedFault]) -> tuple[str, ...]:
    return tuple(fault.text for fault in faults)


def _name(path: Path) -> str:
    stem = re.sub(r"\.mcap.*$", "", path.name)
    words = re.findall(r"[A-Za-z0-9]+", stem) or ["run"]
    name = "_".join(words).lower()
    return name if name[0].isalpha() else f"run_{name}"


def _sentence(path: Path, comparison: RunComparison) -> str:
    wanted = comparison.wanted
    end = f"{path.name} ends in {wanted.outcome}"
    if wanted.outcome == "any":
        end = f"{path.name} shows no outcome"
    if wanted.violated:
        names = ", ".join(f"'{name}'" for name in wanted.violated)
        end += f" and violates {names}"
    return end


def summary_lines(result: Reproduction) -> list[str]:
    """Return the result for people."""
    comparison = result.comparison
    lines = [f"{result.case.name}: {_sentence(Path(result.case.name), comparison)}"]
    lines += [f"  {note}" for note in result.notes]
    lines.append(f"  world: {counted(result.world_shapes, 'shape')}")
    lines += [f"  fault {each}" for each in result.diagnosed] or ["  no fault found"]
    way = "the same way" if comparison.is_repeated else "another way"
    again = f"the simulation ends in {way}"
    if comparison.wanted.outcome == "any" and not comparison.wanted.violated:
        again = f"the simulation ends in {comparison.got.outcome}"
    lines.append(f"  {again} ({counted(result.runs, 'run')})")
    if comparison.mean is not None:
        lines.append(
            f"  path difference: mean {comparison.mean:.3f} m, largest {comparison.largest:.3f} m"
        )
    same = "in the same order" if comparison.outcomes_agree else "in another order"
    if comparison.recorded:
        lines.append(f"  goals end {same}: {', '.join(comparison.simulated) or 'no goals'}")
    else:
        lines.append("  the recording has no goals: the mission follows its path")
    for event in comparison.events:
        times = f"{_at(event.recorded)} recorded, {_at(event.simulated)} simulated"
        lines.append(f"  {event.what}: {times}")
    lines += [f"  unexplained: {text}" for text in result.unexplained]
    return [
        *lines,
        f"  {result.case.scenario_file}: bt-mission run repeats it, and pytest",
        f"  {result.picture}: scans, world and both paths",
    ]


def _at(time_s: float | None) -> str:
    return "-" if time_s is None else f"{time_s:.2f} s"
