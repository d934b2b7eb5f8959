"""`bt-mission verify`: what it prints, and its exit codes."""

from __future__ import annotations

import json

from tests.support.command_line import CommandLine
from tests.support.recordings import recording
from tests.support.robot_bag import RobotBag

MISSION = """\
mission: turn
world: empty_arena
requirements:
  turns: eventually succeeded('turn')
  is calm: {whenever: turn_rate > 0.1, then: speed < 0.01, within: 0.5}
tree:
  turn: {angle: 30}
  timeout: 20
"""


def required(cli: CommandLine, **formulas: str) -> str:
    """Write a file of requirements; returns the option that names it."""
    lines = (f"  {name.replace('_', ' ')}: {json.dumps(text)}\n" for name, text in formulas.items())
    cli.write("more.yaml", "requirements:\n" + "".join(lines))
    return "--require more.yaml"


def test_json_has_what_run_has(cli: CommandLine) -> None:
    """The same objects; requirements of files are recorded with those of the mission."""
    cli.write("turn.yaml", MISSION)
    more = required(cli, keeps_off="always clearance > 1", is_slow="always turn_rate < 0.1")
    expected = cli.json(f"run turn.yaml {more} --record run.mcap", 1)["requirements"]
    report = cli.json("verify run.mcap", 1)
    assert report["requirements"] == expected
    assert [each["verdict"] for each in expected] == ["holds", "holds", "holds", "violated"]
    assert (report["mission"], report["notes"], report["recording_lacks"]) == ("turn", [], "")


def test_a_table_for_people(cli: CommandLine) -> None:
    """With the lines that a run ends with."""
    more = required(cli, is_slow="always speed < 0.3", drives="eventually distance > 0.7")
    first, *rest = cli.lines(f"verify {recording()} {more}")
    assert first.startswith(f"{recording()}: there and back, ")
    assert rest[0].startswith("  requirement is slow: holds by 0.1")
    assert rest[1].startswith("  requirement drives: holds by 0.")


def test_a_file_replaces_recorded_requirements_of_its_names(cli: CommandLine) -> None:
    """So a limit can be tried out; `--mission` leaves none of the recorded ones."""
    cli.write("turn.yaml", MISSION)
    cli("run turn.yaml --record run.mcap --json")
    more = required(cli, turns="eventually within 0.1 s succeeded('turn')")
    out = cli(f"verify run.mcap {more}", 1)
    assert "turns: violated" in out
    assert "is calm: holds" in out
    cli.write("other.yaml", MISSION.replace("turns:", "gets there:"))
    out = cli("verify run.mcap --mission other.yaml")
    assert "gets there: holds" in out
    assert "turns:" not in out


def test_an_unknown_verdict_has_an_exit_code_of_its_own(cli: CommandLine) -> None:
    """3, with what is missing; 1 if anything else is violated."""
    bag = RobotBag(cli.folder / "bag.mcap")
    for step in range(20):
        bag.odometry(0.1 * step, x=0.0, speed=0.2)
    bag.close()
    keeps_off = "always clearance > 0.1"
    out = cli(f"verify bag.mcap {required(cli, keeps_off=keeps_off)}", 3)
    assert "no mission, 1.90 s" in out
    assert "requirement keeps off: unknown: clearance: only a simulation provides it" in out
    more = required(cli, keeps_off=keeps_off, is_slow="always speed < 0.1")
    cli(f"verify bag.mcap {more}", 1)
    of_a_mission = required(cli, turns="never failed('turn')", counts="always $count < 3")
    out = cli(f"verify bag.mcap {of_a_mission}", 3)
    assert "turns: unknown: failed('turn'): the recording contains no mission" in out
    assert "counts: unknown: $count: the recording contains no mission" in out
    cli.write(
        "mine.yaml", "mission: m\nrequirements:\n  r: never failed('a')\ntree: {wait: 1, name: a}\n"
    )
    out = cli("verify bag.mcap --mission mine.yaml", 3)
    assert "r: unknown: failed('a'): the recording contains no mission" in out


def test_an_open_requirement_is_no_failure_of_a_whole_recording(cli: CommandLine) -> None:
    """As of a run; where the recording is cut, its rest is missing."""
    more = required(cli, rests="whenever time > 1: eventually within 60 s speed > 5")
    out = cli(f"verify {recording()} {more}")
    assert "rests: open by" not in out
    assert "rests: open" in out
    data = recording().read_bytes()
    (cli.folder / "cut.mcap").write_bytes(data[: len(data) // 2])
    out = cli(f"verify cut.mcap {required(cli, is_slow='always speed < 3')}", 3)
    assert "  requirement is slow: open" in out
    assert "the recording is cut: the file is incomplete, or the recorder was killed" in out


def test_bad_input_is_refused_with_what_to_do(cli: CommandLine) -> None:
    """The error has the file, its line, and the names that exist."""
    cli.write(
        "other.yaml",
        "mission: other\nrequirements:\n  it: never failed('rest')\n"
        "tree:\n  sequence:\n    - wait: 1\n      name: rest\n",
    )
    bag = RobotBag(cli.folder / "bag.mcap")
    bag.odometry(0.0, x=0.0, speed=0.0)
    bag.close()
    more = required(cli, gets_on="eventually succeeded('drve')")
    nowhere = "so no requirements; add some with --require"
    for words, expected in {
        "bag.mcap": [f"contains no mission, {nowhere}"],
        f"{recording()}": ["the recorded mission has no requirements; add some with"],
        f"{recording()} {more}": ["more.yaml:2", "unknown node: 'drve'", "drive"],
        f"{recording()} --mission other.yaml": ["other.yaml:3", "unknown node: 'rest'"],
    }.items():
        error = cli.refused(f"verify {words}")
        assert [part for part in expected if part not in error] == []
