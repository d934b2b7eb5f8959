"""Forks of recorded runs from the command line."""

from __future__ import annotations

import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from bt_mission.commands.fork.command import fork_shown
from bt_mission.executive.stored_trace import read_trace
from tests.support.command_line import CommandLine
from tests.support.full_disk import process_full_after
from tests.support.project import ROOT
from tests.support.recordings import edited, with_facts
from tests.support.thorough import sample

MISSION = """\
mission: to the wall and back
world: empty_arena
seed: 3
inputs: {speed: 0.2, angle: 90}
include: [parts/ways.yaml]
requirements:
  has power: always battery > 20
tree:
  sequence:
    - set: {way: 0.3}
    - tree: {name: drive, inputs: {speed: $speed, way: $way}}
    - turn: {angle: $angle}
      timeout: 30
      name: turn away
    - tree: {name: drive, inputs: {speed: $speed, way: $way}}
"""
WAYS = """\
trees:
  drive:
    needs: {speed: number, way: number}
    do:
      explore_forward: {fwd_velocity: $speed, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled >= $way
      on_cancel: success
      timeout: 30
"""
LATE = """\
mission: up to the wall
world: wet_arena
inputs: {speed: 0.26}
requirements:
  keeps its distance: always clearance > 0.31
tree:
  sequence:
    - wait: 0.5
    - set: {pace: $speed}
    - explore_forward: {fwd_velocity: $pace, stopping_distance: 0.3}
      timeout: 60
"""
FLEET = """\
fleet: pair
world: dqn_stage1
seed: 3
robots:
  one:
    mission:
      mission: turns
      inputs: {angle: 90}
      requirements: {is slow: always speed < 1}
      tree:
        sequence:
          - {turn: {angle: $angle}, name: turn, timeout: 20}
          - {turn: {angle: $angle}, name: again, timeout: 20}
    inputs: {angle: 60}
    start: {x: -1}
  two:
    mission: drives.yaml
    robot: burger
    start: {x: 1, yaw: 90}
"""
DRIVES = """\
mission: drives
inputs: {speed: 0.1}
tree:
  sequence:
    - {wait: 1, name: a while}
    - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled >= 0.2
      on_cancel: success
      timeout: 20
"""


def recorded(folder: Path, *words: str, code: int = 0, **files: str) -> Path:
    """Record a run of the first of the files; returns the recording, which is alone then."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    outputs = ("--record", str(folder / "run.mcap"), "--trace", str(folder / "run.jsonl"))
    first = str(folder / f"{next(iter(files))}.yaml")
    assert main(["run", first, "--json", *outputs, *words]) == code
    for path in folder.rglob("*.yaml"):
        path.unlink()
    return folder / "run.mcap"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run; where its mission was is another one now."""
    folder = tmp_path_factory.mktemp("fork")
    path = recorded(folder, mission=MISSION, parts__ways=WAYS)
    (folder / "mission.yaml").write_text("mission: another\ntree: {wait: 1}\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def late(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that comes too near to a wall, since it was too fast on a wet floor."""
    world = (ROOT / "worlds" / "empty_arena.yaml").read_text(encoding="utf-8")
    world = world.replace("name: empty_arena", "name: wet_arena")
    wet = "slippery:\n  - {name: puddle, x: 1.2, y: 0, radius: 0.5, friction: 0.03}\n"
    folder = tmp_path_factory.mktemp("late")
    return recorded(folder, code=1, late=LATE, wet_arena=world + wet)


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded fleet with nature and a fault, the files of which are gone."""
    fault = ["--fault", "one: at 0.5: drop imu lasting 0.5"]
    words = [*fault, "--nature", "usual", "--set", "angle=70"]
    return recorded(tmp_path_factory.mktemp("fleet"), *words, it=FLEET, drives=DRIVES)


def test_without_a_change_the_same_happens_again(run: Path, cli: CommandLine) -> None:
    """From the recording alone: the files on the disk are others by now, or gone."""
    fork = cli.json(f"fork {run} --at 2 --trace again.jsonl")
    assert (fork["is_identical"], fork["first_difference"]) == (True, None)
    assert Path("again.jsonl").read_bytes() == run.with_name("run.jsonl").read_bytes()
    assert fork["forked"]["requirements"] == fork["recorded"]["requirements"]
    assert fork["forked"]["trace_sha256"] == read_trace(run.with_name("run.jsonl")).sha256


def running_s(fork: Any) -> dict[str, float]:
    """Return how long each leaf of a fork ran, by its place."""
    return {leaf["path"]: leaf["running_s"] for leaf in fork["forked"]["leaves"]}


def test_a_variable_has_another_value_from_the_instant_on(run: Path, cli: CommandLine) -> None:
    """The current drive keeps its speed, the next one is slower."""
    fork = cli.json(f"fork {run} --at 1 --set speed=0.1")
    after, before = running_s(fork), running_s(cli.json(f"fork {run} --at 1"))
    assert after["0.1.0"] == before["0.1.0"]
    assert after["0.3.0"] > 1.5 * before["0.3.0"]
    change: Any = {"set": {"speed": 0.1}, "mission": None, "from_start": False, "faults": []}
    assert fork["change"] == change
    assert fork["first_difference"]["time_s"] > 1


def test_people_get_both_outcomes(run: Path, cli: CommandLine) -> None:
    """With the control step, where the instant lies between two, and what made no difference."""
    lines = cli.lines(f"fork {run} --at 1.01 --set angle=-45")
    assert lines[0].startswith("recorded: success at ")
    forked = "forked at 1.05 s (the control step after 1.01 s) with angle=-45: success at "
    assert lines[1].startswith(forked)
    assert "requirement has power: holds by 79.9" in lines[3]
    assert "(recorded: holds by 79.9" in lines[3]
    assert "first difference (< recorded, > forked):" in lines[4]
    last = cli.lines(f"fork {run} --at 4 --set angle=10")[-1]
    assert last.startswith("  the change makes no difference: all ")


def test_a_variable_that_is_no_input_is_set_too(run: Path, cli: CommandLine) -> None:
    """As long as it holds a value of that type."""
    fork = cli.json(f"fork {run} --at 1 --set way=0.1")
    assert fork["forked"]["distance_travelled_m"] < 0.5
    error = cli.refused(f"fork {run} --at 1 --set way=far")
    assert "'way' is a number at that instant" in error


def test_a_fork_is_recorded_as_one(run: Path, cli: CommandLine) -> None:
    """Its log has the change. It cannot be forked itself, unless nothing was changed."""
    cli(f"fork {run} --at 1 --set speed=0.1 --record fork.mcap")
    assert "forked here: speed=0.1" in cli("replay fork.mcap --plain")
    error = cli.refused("fork fork.mcap --at 1")
    assert "it is itself a fork, of the run in run.mcap: fork that one" in error
    cli(f"fork {run} --at 1 --record again.mcap")
    assert cli.json("fork again.mcap --at 3")["is_identical"]


@pytest.mark.thorough
def test_a_requirement_is_added(run: Path, cli: CommandLine) -> None:
    """Its verdict is no difference; a violated one decides the exit code."""
    cli.write("slow.yaml", "requirements:\n  is slow: always speed < 0.15\n")
    fork = cli.json(f"fork {run} --at 3 --require slow.yaml")
    verdicts = {each["name"]: each["verdict"] for each in fork["forked"]["requirements"]}
    assert verdicts == {"has power": "holds", "is slow": "violated"}
    assert fork["is_identical"]
    fork = cli.json(f"fork {run} --at 3 --set speed=0.1 --require slow.yaml", 1)
    assert fork["forked"]["status"] == "success"


def edit(cli: CommandLine, old: str, new: str, ways: str = WAYS) -> str:
    """Write the recorded mission with something in it replaced."""
    assert old in MISSION
    cli.write("parts/ways.yaml", ways)
    return cli.write("edited.yaml", MISSION.replace(old, new))


def test_an_edited_mission_continues_from_the_instant(run: Path, cli: CommandLine) -> None:
    """What runs there ends as it began; what begins later begins as edited, in all trees."""
    before = running_s(cli.json(f"fork {run} --at 1"))
    slow = WAYS.replace("fwd_velocity: $speed", "fwd_velocity: 0.1")
    path = edit(cli, "angle: $angle}", "angle: 45}", slow)
    fork = cli.json(f"fork {run} --at 1 --mission {path}")
    assert fork["change"] == {"set": {}, "mission": path, "from_start": False, "faults": []}
    after = running_s(fork)
    assert after["0.1.0"] == before["0.1.0"]
    assert after["0.2"] < 0.7 * before["0.2"]
    assert after["0.3.0"] > 1.5 * before["0.3.0"]


@pytest.mark.thorough
def test_an_edited_input_has_its_value_from_the_instant_on(run: Path, cli: CommandLine) -> None:
    """As with --set."""
    path = edit(cli, "angle: 90}", "angle: 45}")
    edited_, set_ = (
        cli.json(f"fork {run} --at 1 {words}") for words in (f"--mission {path}", "--set angle=45")
    )
    assert edited_["change"]["set"] == {"angle": 45}
    assert not set_["is_identical"]
    assert len({fork["forked"]["distance_travelled_m"] for fork in (edited_, set_)}) == 1


@pytest.mark.thorough
def test_a_mission_with_more_nodes_runs_from_the_start(run: Path, cli: CommandLine) -> None:
    """Where it does the same up to the fork; else the first difference is the reason."""
    more = "    - wait: 1\n    - turn: {angle: $angle}"
    path = edit(cli, "    - turn: {angle: $angle}", more)
    fork = cli.json(f"fork {run} --at 1 --mission {path}")
    assert fork["change"]["from_start"]
    assert fork["forked"]["virtual_s"] > fork["recorded"]["virtual_s"] + 0.9
    error = cli.refused(f"fork {run} --at 4 --mission {path}")
    assert "differs from the recording before 4.00 s" in error
    assert f"the edited mission has another tree: {path}:12:7: " in error


def test_an_edited_requirement_is_evaluated_from_the_start(run: Path, cli: CommandLine) -> None:
    """What was recorded of the first one is not compared."""
    path = edit(cli, "always battery > 20", "always speed < 0.15")
    fork = cli.json(f"fork {run} --at 4 --mission {path}", 1)
    assert fork["forked"]["requirements"][0]["verdict"] == "violated"
    assert fork["recorded"]["requirements"][0]["verdict"] == "holds"
    assert fork["is_identical"]


@pytest.mark.parametrize(
    ("new", "expected"),
    [
        ("seed: 4", "edited.yaml:3:7: error: 'seed' is fixed at the start of a run: recorded 3,"),
        ("sed: 3", "edited.yaml:3:1: error: unknown key 'sed'"),
    ],
)
def test_a_mission_that_begins_otherwise_is_refused(
    run: Path, cli: CommandLine, new: str, expected: str
) -> None:
    """World, robot, seed and map are settled by then; errors are those of a check."""
    error = cli.refused(f"fork {run} --at 1 --mission {edit(cli, 'seed: 3', new)}")
    assert expected in error


@pytest.mark.thorough
@pytest.mark.process
def test_a_shown_recording_is_forked_beside_it(
    run: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """By a command that is shown; a file that exists is kept."""
    monkeypatch.setattr("builtins.input", lambda _: "")
    first = run.with_name("run_fork_1.mcap")
    first.touch()
    path = fork_shown(run, 1.0, ["speed=0.1", "--fault", "at 2: drop scan"], nullcontext)
    assert path == run.with_name("run_fork_2.mcap")
    out = capfd.readouterr().out
    assert "--at 1.000 --set speed=0.1 --fault 'at 2: drop scan' --record " in out
    assert "recorded: success at " in out
    assert fork_shown(run, 1.0, ["sped=0.1"], nullcontext) is None
    assert first.stat().st_size == 0


def test_a_fault_begins_after_the_fork(run: Path, cli: CommandLine) -> None:
    """The recording of the fork holds the fault, so that it runs again alone."""
    fault = "--fault 'at 1.5: spawn_box ahead 0.45'"
    fork = cli.json(f"fork {run} --at 1 {fault} --record fault.mcap")
    assert fork["forked"]["faults"][0]["began"] == 1.5
    assert fork["first_difference"]["time_s"] >= 1.5
    again = cli.json("fork fault.mcap --at 2")
    assert again["is_identical"]
    assert again["forked"]["faults"] == fork["forked"]["faults"]


@pytest.mark.thorough
@pytest.mark.process
def test_a_fork_with_an_incomplete_file_fails(run: Path) -> None:
    """It is identical, but what was asked for was not written."""
    words = ["fork", str(run), "--at", "1", "--record", str(run.with_name("full.mcap"))]
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission", *words],
        capture_output=True,
        text=True,
        check=False,
        **process_full_after(8000),
    )
    assert (done.returncode, "identical: all" in done.stdout) == (1, True)
    assert "full.mcap; it lacks everything after 0.0 s (File too large)" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


def test_a_fault_that_never_begins_after_the_fork_fails_it(run: Path, cli: CommandLine) -> None:
    """The mission succeeds as before, and the fork has tested nothing."""
    words = f"fork {run} --at 1 --fault 'at 500: drop scan' --record fault.mcap"
    fork = cli.json(words, code=1)
    assert fork["forked"]["verdict"] == "untested"
    assert fork["forked"]["untested"] == ["'at 500.0: drop scan' never happened"]
    again = cli.json("fork fault.mcap --at 2")
    assert (again["is_identical"], again["forked"]["verdict"]) == (True, "untested")


@pytest.mark.parametrize(
    ("recorded", "words", "expected"),
    sample(
        [
            (
                "run",
                "--at 1 --set sped=1",
                "unknown variable 'sped' (the mission's: speed, angle, way); did you mean 'speed'?",
            ),
            ("run", "--at 1 --set speed=fast", "input 'speed' expects a number, got string 'fast'"),
            ("run", "--at 999", "--at 999: the run ends at "),
            (
                "run",
                "--at 2 --fault 'at 1.5: drop scan'",
                "--fault:1:4: error: it begins before the fork, which is at 2.00",
            ),
            (
                "run",
                "--at 2 --fault 'when speed > 0.1: drop scan'",
                "differs from the recording before 2.00 s",
            ),
            ("run", "--at 2 --fault 'at 3: drp scan'", "did you mean 'drop'?"),
            ("fleet", "--at 1 --set speed=0.2", "name the robot to change with --robot: one, two"),
            (
                "fleet",
                "--at 1 --robot tow",
                "contains no mission of a robot 'tow' (robots: one, two)",
            ),
            ("fleet", "--at 99 --robot one", "--at 99: the run ends at"),
            ("fleet", "--at 1 --robot one --set speed=1", "unknown variable 'speed'"),
            ("fleet", "--at 1 --video x.mp4", "--video does not apply to fleets: "),
        ],
        4,
    ),
)
def test_a_change_that_does_not_fit_is_refused(
    request: pytest.FixtureRequest, cli: CommandLine, recorded: str, words: str, expected: str
) -> None:
    """With its place, and what to do."""
    assert expected in cli.refused(f"fork {request.getfixturevalue(recorded)} {words}")


def test_the_shipped_files_are_not_used(cli: CommandLine) -> None:
    """The user's own world and robot are in the recording."""
    for kind, name in (("worlds", "empty_arena"), ("robots", "waffle")):
        Path(kind).mkdir()
        shutil.copy(ROOT / kind / f"{name}.yaml", f"{kind}/mine.yaml")
    cli.write("m.yaml", "mission: m\nworld: mine\nrobot: mine\ntree: {turn: {angle: 9}}\n")
    cli("run m.yaml --json --record run.mcap")
    shutil.rmtree("worlds")
    shutil.rmtree("robots")
    assert cli.json("fork run.mcap --at 0.5")["is_identical"]


def test_a_recording_of_another_place_fails_alike(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Failures name the mission's file as on every machine, so the traces are the same."""
    cli.write("m.yaml", "mission: m\ntree:\n  sequence: [{set: {a: 0}}, {wait: 1 / a}]\n")
    cli(f"run {cli.folder}/m.yaml --json --record run.mcap", 1)
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    fork = cli.json("fork ../run.mcap --at 0")
    assert fork["is_identical"]
    assert fork["recorded"]["reason"].startswith("m.yaml:3:")


@pytest.mark.thorough
def test_a_run_of_a_scenario_is_forked(cli: CommandLine) -> None:
    """With its place, its start, its faults and its requirements."""
    cli.write(
        "s.yaml",
        "scenario: s\nmission: square\nworld: nav_arena\nseed: 5\n"
        "start: {x: 0.2, y: 0.1, yaw: 90}\ninputs: {side: 0.3}\n"
        "faults: ['at 2.0: drop odom lasting 0.5']\n"
        "requirements: {has power: always battery > 20}\n",
    )
    cli("run s.yaml --json --record s.mcap")
    fork = cli.json("fork s.mcap --at 3")
    assert fork["is_identical"]
    assert fork["forked"]["faults"][0]["began"] == 2
    assert fork["forked"]["requirements"] == fork["recorded"]["requirements"]


def test_places_of_a_fork_are_those_of_the_recorded_world(cli: CommandLine) -> None:
    """Also where the world stands in a scenario, and is in no file."""
    cli.write(
        "z.yaml",
        "scenario: z\nworld: {name: w, size: [4, 4], zones: [{name: Z, x: 0.3, y: 0}]}\n"
        "mission:\n  mission: m\n  world: nav_arena\n"
        "  tree: {navigate_to_pose: {pose: Z}, timeout: 60 s}\n",
    )
    cli("run z.yaml --record z.mcap")
    assert "identical" in cli("fork z.mcap --at 1.0")


def test_a_recording_that_was_cut_is_forked_before_its_end(run: Path, cli: CommandLine) -> None:
    """How the recorded run ended is unknown then."""
    data = run.read_bytes()
    Path("cut.mcap").write_bytes(data[: len(data) // 2])
    error = cli.refused("fork cut.mcap --at 99")
    end_s = float(error.rpartition("the recording ends at ")[2].split()[0])
    fork = cli.json(f"fork cut.mcap --at {end_s} --set speed=0.1")
    assert fork["recorded"]["status"] == "unknown"
    assert "the file is incomplete" in fork["recorded"]["reason"]
    assert fork["forked"]["status"] == "success"
    lines = cli.lines("fork cut.mcap --at 1")
    assert lines[3].endswith("(recorded: not known)")
    assert lines[4].endswith(" events of the trace that were recorded, byte by byte")


def test_a_recording_of_another_recorder_is_refused(cli: CommandLine) -> None:
    """Files that are no recordings are in transcripts/recordings.txt."""
    edited(Path("foreign.mcap"), lambda *_: True)
    assert "contains no run of bt-mission" in cli.refused("fork foreign.mcap --at 1")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"world": None, "stage": None}, "has no seed: it was recorded on a running graph"),
        ({"stage": None}, "lacks the files of world and robot"),
        ({"stage": "{}"}, "lacks the files of world and robot"),
        ({"file": "gone.yaml"}, "lacks the mission file 'gone.yaml'"),
        ({"seed": "-"}, "has no seed"),
        (
            {"requirements": '[{"name": "a", "formula": "always"}]'},
            "its requirement 'a' cannot be read here",
        ),
    ],
)
def test_a_recording_that_lacks_something(
    changes: dict[str, str | None], expected: str, cli: CommandLine
) -> None:
    """The error names what it lacks."""
    with_facts(Path("lacking.mcap"), changes)
    assert expected in cli.refused("fork lacking.mcap --at 1")


def test_a_run_that_cannot_be_repeated_is_refused(cli: CommandLine) -> None:
    """With the first event that differs, and with what is of another version."""
    changes = {"inputs": '{"reach": 0.3}', "versions": '{"mujoco": "1.0"}'}
    with_facts(Path("other.mcap"), changes)
    error = cli.refused("fork other.mcap --at 99999")
    assert "recorded with mujoco 1.0, installed is " in error
    error = cli.refused("fork other.mcap --at 7")
    assert (
        "the repeated run differs from the recording before 7.00 s, so it cannot be forked there"
        in error
    )
    assert "the first difference is at " in error
    assert error.count("recorded with mujoco 1.0, installed is ") == 2


def test_the_code_of_python_leaves_is_not_run_unasked(cli: CommandLine) -> None:
    """A recording may be anybody's."""
    cli.write("leaf.py", "from py_trees.behaviours import Success\n\nLeaf = Success\n")
    cli.write("m.yaml", "mission: m\ntree: {python: 'leaf.py:Leaf'}\n")
    cli("run m.yaml --json --record run.mcap")
    error = cli.refused("fork run.mcap --at 0")
    assert "the Python leaf 'leaf.py:Leaf' is refused" in error
    assert "--import-python" in error
    assert cli.json("fork run.mcap --at 0 --import-python")["is_identical"]


@pytest.mark.thorough
def test_a_change_that_saves_a_mission(late: Path, cli: CommandLine) -> None:
    """The variable is read when the drive begins."""
    saved = cli.json(f"fork {late} --at 0 --set speed=0.1 --record saved.mcap")
    assert saved["forked"]["requirements"][0]["verdict"] == "holds"
    assert Path("saved.mcap").exists()


@pytest.mark.thorough
def test_without_a_change_the_same_happens_again_to_every_robot(
    fleet: Path, cli: CommandLine
) -> None:
    """From the recording alone: with starts, models, nature, inputs and faults of each robot."""
    fork = cli.json(f"fork {fleet} --at 2 --trace again.jsonl")
    assert (fork["robot"], fork["is_identical"]) == ("one", True)
    assert [(each["robot"], each["is_identical"]) for each in fork["others"]] == [("two", True)]
    assert fork["forked"]["faults"][0]["ended"] == 1.0
    for robot in ("one", "two"):
        again = Path(f"again.{robot}.jsonl").read_bytes()
        assert again == fleet.with_name(f"run.{robot}.jsonl").read_bytes()


@pytest.mark.thorough
def test_the_run_of_one_robot_is_changed(fleet: Path, cli: CommandLine) -> None:
    """It is shown first, then those of the others."""
    lines = cli.lines(f"fork {fleet} --robot two --at 0.5 --set speed=0.2")
    assert lines[0].startswith("two: recorded: success at ")
    assert lines[1].startswith("forked at 0.50 s with speed=0.2: success at ")
    (at,) = (number for number, line in enumerate(lines) if line.startswith("one: recorded: "))
    assert lines[at + 1].startswith("forked at 0.50 s with two: speed=0.2: success at ")
    fork = cli.json(f"fork {fleet} --robot two --at 1 --fault 'at 2: lidar_dead'", 1)
    assert [each["fault"] for each in fork["forked"]["faults"]] == ["at 2.0: lidar_dead"]
    assert fork["others"][0]["forked"]["status"] == "success"


@pytest.mark.thorough
def test_another_version_of_a_mission_of_a_fleet(fleet: Path, cli: CommandLine) -> None:
    """It is that of the robot that is named."""
    cli.write("edited.yaml", DRIVES.replace("0.1", "0.2"))
    fork = cli.json(f"fork {fleet} --robot two --at 0.5 --mission edited.yaml")
    assert fork["change"]["set"] == {"speed": 0.2}


@pytest.mark.thorough
def test_a_fork_of_a_fleet_is_a_recording_of_all_robots(fleet: Path, cli: CommandLine) -> None:
    """It names its fleet, and cannot be forked itself."""
    words = "--robot two --at 0.5 --set speed=0.2 --record forked.mcap"
    assert cli.json(f"fork {fleet} {words}")["recording"] == "forked.mcap"
    assert [each["robot"] for each in cli.json("verify forked.mcap")["robots"]] == ["one"]
    error = cli.refused("fork forked.mcap --at 1")
    assert "it is itself a fork, of the run in run.mcap" in error


@pytest.mark.thorough
def test_the_robot_that_cannot_be_repeated_is_named(fleet: Path, cli: CommandLine) -> None:
    """With its first difference, although the other robot ends with it."""
    with_facts(
        Path("other.mcap"), {"inputs": '{"speed": 0.2}'}, fleet, "bt_mission /two/bt_mission"
    )
    error = cli.refused("fork other.mcap --at 2")
    assert "two: the repeated run differs from the recording before 2.00 s" in error
    assert "the first difference is at" in error
