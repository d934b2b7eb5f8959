"""``bt-mission verify``: what it prints, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.cli import main
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


def required(folder: Path, **formulas: str) -> str:
    """A file of requirements."""
    path = folder / "more.yaml"
    lines = (f"  {name.replace('_', ' ')}: {json.dumps(text)}\n" for name, text in formulas.items())
    path.write_text("requirements:\n" + "".join(lines))
    return str(path)


def test_json_has_what_run_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same objects; requirements of files are recorded with those of the mission."""
    (tmp_path / "turn.yaml").write_text(MISSION)
    more = required(tmp_path, keeps_off="always clearance > 1", is_slow="always turn_rate < 0.1")
    file = str(tmp_path / "run.mcap")
    arguments = ["run", str(tmp_path / "turn.yaml"), "--require", more, "--record", file, "--json"]
    assert main(arguments) == 1
    told = json.loads(capsys.readouterr().out)["requirements"]
    assert main(["verify", file, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["requirements"] == told
    assert [one["verdict"] for one in told] == ["holds", "holds", "holds", "violated"]
    assert (found["mission"], found["notes"], found["recording_lacks"]) == ("turn", [], "")


def test_a_table_for_people(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With the lines that a run ends with."""
    more = required(tmp_path, is_slow="always speed < 0.3", drives="eventually distance > 0.7")
    assert main(["verify", str(recording()), "--require", more]) == 0
    first, *rest = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{recording()}: there and back, ")
    assert rest[0].startswith("  requirement is slow: holds by 0.1")
    assert rest[1].startswith("  requirement drives: holds by 0.")


def test_a_file_replaces_recorded_requirements_of_its_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """So a limit can be tried out; `--mission` leaves none of the recorded ones."""
    (tmp_path / "turn.yaml").write_text(MISSION)
    file = str(tmp_path / "run.mcap")
    assert main(["run", str(tmp_path / "turn.yaml"), "--record", file, "--json"]) == 0
    capsys.readouterr()
    more = required(tmp_path, turns="eventually within 0.1 s succeeded('turn')")
    assert main(["verify", file, "--require", more]) == 1
    told = capsys.readouterr().out
    assert "turns: violated" in told
    assert "is calm: holds" in told
    (tmp_path / "other.yaml").write_text(MISSION.replace("turns:", "gets there:"))
    assert main(["verify", file, "--mission", str(tmp_path / "other.yaml")]) == 0
    told = capsys.readouterr().out
    assert "gets there: holds" in told
    assert "turns:" not in told


def test_what_cannot_be_told_has_an_exit_code_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """3, and what is missing; 1 where anything is violated all the same."""
    bag = RobotBag(tmp_path / "bag.mcap")
    for step in range(20):
        bag.odometry(0.1 * step, x=0.0, speed=0.2)
    file = str(bag.close())
    keeps_off = "always clearance > 0.1"
    assert main(["verify", file, "--require", required(tmp_path, keeps_off=keeps_off)]) == 3
    told = capsys.readouterr().out
    assert "no mission, 1.90 s" in told
    assert "requirement keeps off: unknown: clearance: only a simulation knows it" in told
    more = required(tmp_path, keeps_off=keeps_off, is_slow="always speed < 0.1")
    assert main(["verify", file, "--require", more]) == 1


def test_an_open_requirement_is_no_failure_of_a_whole_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As of a run; where the recording is cut, its rest is missing."""
    more = required(tmp_path, rests="whenever time > 1: eventually within 60 s speed > 5")
    assert main(["verify", str(recording()), "--require", more]) == 0
    assert "rests: open by" not in (told := capsys.readouterr().out)
    assert "rests: open" in told
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording().read_bytes()[: recording().stat().st_size // 2])
    more = required(tmp_path, is_slow="always speed < 3")
    assert main(["verify", str(cut), "--require", more]) == 3
    told = capsys.readouterr().out
    assert "  requirement is slow: open" in told
    assert "the recording is cut: the file was cut, or the recorder killed" in told


def test_bad_input_is_told_with_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By its file, its line, and names that there are."""
    empty, text, bag = tmp_path / "empty.mcap", tmp_path / "notes.txt", tmp_path / "bag.mcap"
    empty.touch()
    text.write_text("notes")
    (tmp_path / "trace.jsonl").write_text('{"trace_version": 3}\n')
    made = RobotBag(bag)
    made.odometry(0.0, x=0.0, speed=0.0)
    made.close()
    cases = {
        str(tmp_path / "none.mcap"): "none.mcap: cannot read it: No such file",
        str(empty): "empty.mcap: the file is empty",
        str(text): "notes.txt: the file is neither a recording",
        str(tmp_path / "trace.jsonl"): "a trace does not hold the signals of a run",
        str(bag): "no mission is in it, and so no requirements: name a file of them with --require",
        str(recording()): "the recorded mission has no requirements: name a file of them with",
    }
    for file, words in cases.items():
        assert main(["verify", file]) == 2
        assert words in capsys.readouterr().err
    more = required(tmp_path, gets_on="eventually succeeded('drve')")
    assert main(["verify", str(recording()), "--require", more]) == 2
    told = capsys.readouterr().err
    assert "more.yaml:2" in told
    assert "no node is named 'drve'" in told
    assert "drive" in told


def test_requirements_of_another_mission_file_name_nodes_of_the_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Else the error has the line of that file."""
    other = tmp_path / "other.yaml"
    other.write_text(
        "mission: other\nrequirements:\n  it: never failed('rest')\n"
        "tree:\n  sequence:\n    - wait: 1\n      name: rest\n"
    )
    assert main(["verify", str(recording()), "--mission", str(other)]) == 2
    told = capsys.readouterr().err
    assert "other.yaml:3" in told
    assert "no node is named 'rest'" in told
