"""Requirements over recordings: verdicts, margins and instants are those of the run itself.

Also over recordings of robots that know nothing of missions.
"""

from __future__ import annotations

import math
import random
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.files import find
from bt_mission.base.verdicts import RequirementResult
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Mission, Requirement
from bt_mission.recording.contents import string_message
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile, RecordingError
from bt_mission.recording.verification import (
    RecordedRequirements,
    read_verified_run,
    recorded_requirements,
)
from bt_mission.recording.writer import RunRecorder
from bt_mission.requirements.checks import with_requirements
from bt_mission.requirements.language.signals import OUTCOMES
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.testing.stages import Stages
from tests.requirements.test_semantics import drawn_formula
from tests.support.recordings import edited, recorded_run, recording, write_messages
from tests.support.robot_bag import RobotBag, verify
from tests.support.thorough import sample

NODES = {"explore": ("drive", "look around"), "patrol": ("visit the zones", "visit the zones")}
REQUIREMENTS = """\
requirements:
  keeps its distance: always clearance > 0.10
  is never hit: never collisions > 0
  gets on: 'eventually within 60 s: succeeded("{drive}")'
  looks before it drives: 'whenever running("{drive}"): previously succeeded("{look}")'
  stops when blind: {{whenever: age("scan") > 0.5, then: speed < 0.01, within: 0.6}}
  is slow: always speed < 0.15
  keeps off: always nearest != "wall" or clearance > 0.2
  knows its way: always abs(x - odometry.x) < 5 and distance < 3
  has one goal: always open_goals <= 1
  has one goal at the base: always goals_at_base <= 1
  has charge: always battery > 99.9 and scan_clearance > 0.2
  hears: always age("odom") < 0.05 and topic("imu", "angular_velocity.z") < 2
  turns calmly: 'whenever turn_rate > 1: turn_rate < 0.5 within 0.2 s'
"""
FEEDBACK = """\
  is told the truth: always feedback("drive", "current_distance_travelled") <= distance + 0.1
  gets away: 'whenever failed("turn away"): open_goals == 0 within 2 s'
  turned: 'whenever succeeded("turn away"): turn_rate < 2'
  is asked for it: always $speed < 0.3
  is accepted: 'whenever starts(running("drive")): accepted("drive") within 1 s'
  is never refused: never outcome("drive") = rejected or outcome("turn away") = aborted
  is canceled: eventually outcome("drive") = canceled
  ends at a bound: 'whenever ends(running("drive")): outcome("drive") == "canceled by timeout"'
  drives seldom: always count(starts(running("drive"))) within 20 s so far <= 1
  drives on: always mean(speed) over 5 s > 0.01
  starts gently: always abs(rate(speed)) < 0.5 m/s / 1 s
  turns well: >-
    whenever ends(running("turn away")):
    abs(yaw - value(yaw) at last starts(running("turn away"))) > 100 deg
"""
GOALS = """\
mission: goals
world: empty_arena
tree:
  sequence:
    - force: success
      do:
        retry: {attempts: 3, pause: 0.2}
        do:
          turn: {angle: 170}
          name: late
          timeout: 0.5
    - force: success
      do:
        turn: {angle: 9999999}
        name: refused
    - force: success
      do:
        timeout: 0.5
        do:
          turn: {angle: 170}
          name: halted
    - turn: {angle: 20}
      name: done
      timeout: 20
"""
THERE_AND_BACK = """\
mission: there and back
world: empty_arena
seed: 3
tree:
  sequence:
    - repeat: {count: 2}
      do:
        sequence:
          - explore_forward: {fwd_velocity: 0.26, stopping_distance: 0.3}
            name: a
            cancel_when: current_distance_travelled > 0.6
            on_cancel: success
            timeout: 30
          - turn: {angle: 120}
            name: b
            timeout: 30
"""


def run(mission: Mission, path: Path) -> tuple[RequirementResult, ...]:
    """Run a mission, recorded; return the results of its requirements."""
    return recorded_run(mission, path).report(1.0).requirements


def plain(results: tuple[RequirementResult, ...]) -> list[dict[str, Any]]:
    """Results as programs get them."""
    return [asdict(result) for result in results]


def judged_alike(mission: Mission, bare: Mission, folder: Path) -> tuple[RequirementResult, ...]:
    """Run a mission, also without its requirements; assert that verdicts of recordings are equal.

    Verdict, margin, instant and all else.
    """
    reports = run(mission, folder / "with.mcap")
    assert plain(verify(folder / "with.mcap").results) == plain(reports)
    run(bare, folder / "without.mcap")
    result = verify(folder / "without.mcap", requirements=mission.requirements)
    assert plain(result.results) == plain(reports)
    assert (result.notes, result.why_cut, result.lacks) == ((), "", "")
    return reports


@pytest.mark.thorough
@pytest.mark.parametrize("name", sample(NODES, every=9))
def test_a_recording_comes_to_what_the_run_did(name: str, tmp_path: Path) -> None:
    """Also where the run did not know the requirements."""
    drive, look = NODES[name]
    text = REQUIREMENTS.format(drive=drive, look=look) + (FEEDBACK if name == "explore" else "")
    (tmp_path / "more.yaml").write_text(text)
    bare = load(find("missions", name), set={"legs": 3} if name == "explore" else None)
    mission = with_requirements(bare, [tmp_path / "more.yaml"])
    reports = judged_alike(mission, bare, tmp_path)
    assert {report.verdict for report in reports} >= {"holds", "violated"}


@pytest.mark.thorough
@pytest.mark.parametrize("count", sample([80, 200], every=2))
def test_any_formula_comes_to_what_it_did_in_the_run(count: int, tmp_path: Path) -> None:
    """Formulas chosen at random, over true poses and the states of nodes."""
    draw = random.Random(14)
    texts = [drawn_formula(draw, measures=draw.choice((0.0, 0.4))) for _ in range(count)]
    mission = load(THERE_AND_BACK)
    results = []
    for text in texts:
        with suppress(ExpressionError):  # what can only come to one verdict
            results.append(Requirement(text, text))
    requirements = tuple({result.name: result for result in results}.values())
    reports = judged_alike(replace(mission, requirements=requirements), mission, tmp_path)
    assert {report.verdict for report in reports} >= {"holds", "violated", "open"}
    assert len({report.margin for report in reports}) > 20


@pytest.mark.thorough
def test_what_becomes_of_goals_is_the_same_in_the_run_and_in_its_recording(tmp_path: Path) -> None:
    """How each ended, whether it was accepted, how often; also if the run did not know that."""
    mission = load(GOALS)
    texts = [
        f"{word} {inner}"
        for name in ("late", "refused", "halted", "done")
        for word in ("eventually", "never")
        for inner in (
            *(f'outcome("{name}") = "{outcome}"' for outcome in OUTCOMES),
            f'accepted("{name}")',
            f'count(starts(accepted("{name}"))) > 2',
            f'count(ends(outcome("{name}") = canceled)) > 1',
            f'starts(accepted("{name}")) and yaw > 0.1',
        )
    ]
    requirements = tuple(Requirement(text, text) for text in texts)
    reports = judged_alike(replace(mission, requirements=requirements), mission, tmp_path)
    names = (report.name for report in reports if report.verdict == "holds")
    held = {name.removeprefix("eventually ") for name in names}
    assert {name for name in held if not name.startswith(("never", "starts", "count"))} == {
        'outcome("late") = "canceled"',
        'outcome("late") = "canceled by timeout"',
        'accepted("late")',
        'outcome("refused") = "rejected"',
        'outcome("halted") = "canceled"',
        'outcome("halted") = "canceled by halt"',
        'accepted("halted")',
        'outcome("done") = "succeeded"',
        'accepted("done")',
    }
    assert 'count(starts(accepted("late"))) > 2' in held
    assert 'count(ends(outcome("late") = canceled)) > 1' in held


SLOW = {
    "report": "always speed < 0.1",
    "fail": "{formula: always speed < 0.1, on_violation: fail}",
    "halt": "{formula: always speed < 0.1, on_violation: halt}",
}


@pytest.mark.parametrize("action", sample(SLOW, 3))
def test_what_a_violation_does_comes_after_the_instant_for_all(action: str, tmp_path: Path) -> None:
    """Another requirement sees what there was before the mission was ended for the first."""
    text = THERE_AND_BACK.replace(
        "tree:",
        f"requirements:\n  slow: {SLOW[action]}\n  goes on: always running('a') or time < 0.5\n"
        "  ends: eventually succeeded('b')\n"
        "  one goal: 'whenever speed > 0.1: open_goals > 0'\ntree:",
    )
    reported = run(load(text), tmp_path / "run.mcap")
    assert reported[0].verdict == "violated"
    assert plain(verify(tmp_path / "run.mcap").results) == plain(reported)


def test_what_a_fault_kept_from_the_mission_is_known(stage: Stages, tmp_path: Path) -> None:
    """Scans were sent, and are in the file; that they were not heard is, too."""
    text = THERE_AND_BACK.replace(
        "tree:", "requirements:\n  hears: always age('scan') < 0.5\ntree:"
    )
    made = stage.run(text)
    made.expect_violation("hears")
    made.at(1.0, stage.faults.drop("scan", lasting=2.0))
    with RunRecorder(made.stage, tmp_path / "run.mcap") as recorder:
        report = made.until_done()
        recorder.finish(report.as_dict())
    assert report.requirements[0].verdict == "violated"
    assert plain(verify(tmp_path / "run.mcap").results) == plain(report.requirements)


def test_what_appears_while_the_run_goes_on_has_room_around_it(
    stage: Stages, tmp_path: Path
) -> None:
    """The model at the start does not tell of it, so clearance is recorded then."""
    made = stage.run(THERE_AND_BACK)
    made.at(1.0, stage.faults.spawn_box(at=(0.8, 0.5), lasting=2.0))
    with RunRecorder(made.stage, tmp_path / "run.mcap") as recorder:
        recorder.finish(made.until_done().as_dict())
    least = min(moment.clearance for moment in made.moments)
    result, nearest = verify(
        tmp_path / "run.mcap", "always clearance > 0", "always nearest != 'box'"
    ).results
    assert result.margin == pytest.approx(least, abs=1e-8)
    assert nearest.verdict == "violated"


def test_a_recording_that_begins_late_tells_nothing(tmp_path: Path) -> None:
    """What was before might decide."""
    mission = load(THERE_AND_BACK)
    with Stage(mission, image_folder=tmp_path, say=lambda _: None) as stage:
        while stage.executive.cycles < 20:
            stage.step()
        with RunRecorder(stage, tmp_path / "run.mcap") as recorder:
            while not stage.is_done:
                stage.step()
            recorder.finish(stage.report(1.0).as_dict())
    (result,) = verify(tmp_path / "run.mcap", "always speed < 0.1").results
    assert (result.verdict, result.margin) == ("unknown", None)
    assert result.why == "the recording begins 1.05 s after the mission"


@pytest.mark.thorough
def test_a_cut_recording_never_lies(tmp_path: Path) -> None:
    """Cut anywhere, a verdict is that of the whole run, or open, or unknown."""
    formulas = (
        "always speed < 0.15",
        "always clearance > 0.1",
        "eventually succeeded('turn away')",
        "eventually within 2 s: speed > 0.1",
        "eventually within 60 s: distance > 100",
        "whenever succeeded('drive'): eventually within 3 s: succeeded('turn away')",
        "never open_goals > 1",
        "never goals_at_base > 1",
    )
    whole = recording().read_bytes()
    reported = {judged.name: judged for judged in verify(recording(), *formulas).results}
    assert {judged.verdict for judged in reported.values()} >= {"holds", "violated"}
    draw, seen = random.Random(4), set()
    for size in (*(draw.randrange(len(whole)) for _ in range(60)), len(whole) - 20):
        path = tmp_path / "cut.mcap"
        path.write_bytes(whole[:size])
        try:
            result = verify(path, *formulas)
        except RecordingError:  # nothing of it can be read
            assert size < len(whole) / 20
            continue
        for element in result.results:
            seen.add(element.verdict)
            if element.verdict in ("holds", "violated"):
                assert element.verdict == reported[element.name].verdict, (size, element)
            else:
                assert element.why, (size, element)
    assert seen >= {"holds", "violated", "open"}


def test_messages_that_are_missing_are_named(tmp_path: Path) -> None:
    """Each kind of message is needed for something."""
    path = tmp_path / "run.mcap"
    edited(path, lambda channel, _: not channel.topic.endswith(("/tree", "/scan")))
    node, scan = verify(path, "always running('drive')", "always age('scan') < 1").results
    assert (node.verdict, scan.verdict) == ("unknown", "unknown")
    assert node.why == "running('drive'): the recording contains no mission"
    assert scan.why == "age('scan'): the recording has no topic /scan"


@pytest.mark.parametrize("line", ["{", "[]", '{"t": 1050000000, "start": 1, "values": 3}'])
def test_a_damaged_line_of_signals_makes_all_unknown(line: str, tmp_path: Path) -> None:
    """Whatever decides may stand in it."""
    messages = [*RecordedFile(recording()).messages()]
    for number, (channel, time_ns, _) in enumerate(messages):
        if channel.topic.endswith("/signals") and number > 1000:
            messages[number] = channel, time_ns, string_message(line)
    path = write_messages(McapFile(tmp_path / "run.mcap", "another"), messages)
    (result,) = verify(path, "always running('drive')").results
    assert result.verdict == "unknown"
    assert result.why.startswith("the messages of the mission cannot be read: ")


def test_margins_over_time(tmp_path: Path) -> None:
    """Of each instant where the requirement speaks of instants, else of the run so far."""
    text = THERE_AND_BACK.replace(
        "tree:",
        "requirements:\n  slow: always speed < 0.15\n"
        "  calms down: 'whenever speed > 0.2: speed < 0.1 within 4 s'\n"
        "  done: eventually succeeded('b')\ntree:",
    )
    (reported, *_) = run(load(text), tmp_path / "run.mcap")
    slow, calms, done = recorded_requirements(RecordedRequirements(tmp_path / "run.mcap"))
    assert (slow.is_of_instants, calms.is_of_instants, done.is_of_instants) == (True, False, True)
    assert slow.result == reported
    worst = int(slow.margins.argmin())
    assert (slow.times[worst], round(slow.margins[worst], 9)) == (reported.at, reported.margin)
    assert slow.times[slow.margins < 0][0] == reported.violated_at
    known = [margin for margin in calms.margins if math.isfinite(margin)]
    assert known == sorted(known, reverse=True)
    assert set(done.margins) == {-math.inf, math.inf}
    assert read_verified_run(tmp_path / "run.mcap")[0].requirements[0].result == reported


@pytest.fixture
def bag(tmp_path: Path) -> RobotBag:
    """What `ros2 bag record` has kept of a robot that drives for ten seconds, ever faster."""
    bag = RobotBag(tmp_path / "bag.mcap")
    for step in range(201):
        bag.odometry(0.05 * step, x=0.01 * step, speed=0.001 * step)
    for step in range(41):
        bag.scan(0.25 * step, [2.0, 3.0 - 0.05 * step, math.inf])
    return bag


def test_a_recording_of_another_robot(bag: RobotBag) -> None:
    """Its topics tell signals; of what only a simulation or a mission knows it is said so."""
    result = verify(
        bag.close(),
        "always speed < 0.15",
        "always scan_clearance > 0.5",
        "always age('scan') < 0.3",
        "always distance <= 2",
        "always topic('odom', 'twist.twist.linear.x') < 0.3",
        "always clearance > 0.1",
        "always running('drive')",
        "always battery > 20",
        "always topic('odom', 'nothing') < 1",
    )
    speed, room, age, distance, field, clearance, node, battery, nothing = result.results
    assert (speed.verdict, speed.margin, speed.violated_at, speed.at) == (
        *("violated", -0.05, 7.5, 10.0),
    )
    assert (room.verdict, room.margin, room.at) == ("holds", 0.5, 10.0)
    assert (age.verdict, age.margin) == ("holds", 0.1)
    assert (distance.verdict, field.verdict) == ("holds", "holds")
    assert distance.margin == pytest.approx(0.0, abs=1e-9)
    unknown = (clearance, node, battery, nothing)
    assert {judged.verdict for judged in unknown} == {"unknown"}
    assert [judged.why for judged in unknown] == [
        "clearance: only a simulation provides it",
        "running('drive'): the recording contains no mission",
        "battery: the recording has no topic /battery_state",
        "its signals never had a value",
    ]
    assert (speed.sources, distance.sources) == (("speed by odometry",), ("distance by odometry",))


def test_a_robot_in_a_namespace(tmp_path: Path) -> None:
    """Its topics are found where they are said to be; nothing is guessed."""
    bag = RobotBag(tmp_path / "bag.mcap", "/tb3_1")
    bag.odometry(0.0, x=0.0, speed=0.1)
    bag.odometry(1.0, x=0.0, speed=0.3)
    formula = Requirement("slow", "always speed < 0.25")
    (result,) = RecordedRequirements(bag.close()).verify((formula,)).results
    assert result.why == "speed: the recording has no topic /odom"
    recorded = RecordedRequirements(tmp_path / "bag.mcap", "tb3_1")
    assert recorded.verify((formula,)).results[0].margin == -0.05


def test_a_message_that_cannot_be_read_decides_nothing(bag: RobotBag) -> None:
    """Not even where others of its topic can: it might have been the one."""
    bag.raw(10.5, "/odom", b"\0\1\0\0too short")
    result = verify(bag.close(), "always speed < 0.15", "always scan_clearance > 0.1")
    assert [judged.verdict for judged in result.results] == ["unknown", "holds"]
    assert result.results[0].why.startswith("speed: a message cannot be read: ")


def test_clocks_that_do_not_agree_are_told(bag: RobotBag) -> None:
    """Years between two messages are evaluated for nobody."""
    bag.odometry(1e9, x=0.0, speed=0.0)
    with pytest.raises(RecordingError, match="its messages span 11,574 days; were they recorded"):
        verify(bag.close(), "always speed < 1")


def test_a_recording_without_a_message(tmp_path: Path) -> None:
    """There is nothing to evaluate."""
    with pytest.raises(RecordingError, match="contains no messages"):
        RecordedRequirements(RobotBag(tmp_path / "bag.mcap").close())


def test_a_message_of_ours_that_cannot_be_read_makes_all_unknown(tmp_path: Path) -> None:
    """Also where messages are not in the order of time, as of files that were joined."""

    def is_bad(channel: Channel, time_ns: int) -> bool:
        return channel.topic.endswith("/trace") and time_ns > 3_000_000_000

    messages = [
        (channel, time_ns, b"\0\1\0\0" if is_bad(channel, time_ns) else data)
        for channel, time_ns, data in RecordedFile(recording()).messages()
        if not channel.topic.endswith("/signals")
    ]
    path = write_messages(McapFile(tmp_path / "joined.mcap", "another"), reversed(messages))
    (result,) = verify(path, "always running('drive')").results
    assert result.verdict == "unknown"
    assert result.why.startswith("the messages of the mission cannot be read: ")
