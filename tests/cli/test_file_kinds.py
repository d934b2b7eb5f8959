"""Every command with every kind of file takes it, or says what it is and what takes it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_mission.base.commands import ROWS, brought_kinds, rows
from bt_mission.base.file_kinds import FORMATS, format_named, format_of
from bt_mission.cli.argument_types import FileType
from bt_mission.cli.parser import Command, Option
from bt_mission.cli.subparsers import declared
from tests.support.command_cases import cases, named_cases
from tests.support.command_line import CommandLine
from tests.support.recordings import recording
from tests.support.thorough import sample

MISSION = "mission: m\nrequirements:\n  slow: always speed < 9\ntree:\n  wait: 1\n"
TEXTS = {
    "mission": ("mine.yaml", MISSION),
    "scenario": ("mine.scenario.yaml", "scenario: s\nmission: mine.yaml\n"),
    "fleet": ("mine.fleet.yaml", "fleet: f\nworld: empty_arena\nrobots: {}\n"),
    "tree": ("tree.xml", '<root BTCPP_format="4"><BehaviorTree ID="a"/></root>'),
    "world": ("hall.yaml", "name: hall\nsize: [4, 4]\n"),
    "robot": ("trike.yaml", "drive: {kind: differential}\nlidar: {}\n"),
    "requirements": ("safe.yaml", "requirements:\n  slow: always speed < 9\n"),
    "ranges": ("ranges.yaml", "seeds: 3\nfaults: {most: 1}\n"),
    "parameters": ("p.yaml", "bt_mission_servers:\n  ros__parameters:\n    drive_timeout: 9\n"),
    "foreign parameters": ("nav2.yaml", "amcl:\n  ros__parameters:\n    alpha1: 0.2\n"),
    "bag metadata": ("metadata.yaml", "rosbag2_bagfile_information:\n  version: 9\n"),
    "trace": ("run.jsonl", '{"trace_version": 1}\n'),
    "map": ("map.yaml", "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"),
    "map image": ("map.pgm", "P5 1 1 255\n\0"),
    "urdf": ("robot.urdf", '<?xml version="1.0"?>\n<!-- mine -->\n<robot name="r"/>'),
    "sdf": ("room.world", '<sdf version="1.6"/>'),
    "mjcf": ("robot.xml", '<mujoco model="r"/>'),
    "python": ("server.py", "import rclpy\n"),
    "interface": ("Drive.action", "float32 speed\n---\n---\n"),
    "page": ("run.html", "<!DOCTYPE html>\n<title>run</title>"),
    "launch file": ("robot.launch.xml", "<launch/>"),
    **named_cases("KINDS"),
}
TABLES = {
    "sqlite bag": ("drive.db3", "topics"),
    "journal": ("mine.journal", "state"),
    "sweep results": ("results.sqlite", "scenarios"),
}
FOLDERS = {"bag folder": "metadata.yaml", "sweep folder": "results.sqlite"}
VALID = {"file": "square", "name": "square", "recordings": "run.mcap", "folder": "sweep_folder"}
"""What stands for the words of a command while another of its files is tried."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A file of each kind."""
    folder = tmp_path_factory.mktemp("kinds")
    made: dict[str, Path] = {}
    for kind, (name, text) in TEXTS.items():
        made[kind] = folder / name
        made[kind].write_text(text, encoding="utf-8")
    for kind, (name, table) in TABLES.items():
        made[kind] = folder / name
        with sqlite3.connect(made[kind]) as database:
            database.execute(f"CREATE TABLE {table} (id INTEGER)")
        database.close()
    for kind, name in FOLDERS.items():
        made[kind] = folder / kind.replace(" ", "_")
        made[kind].mkdir()
        (made[kind] / name).write_text("")
    made["recording"], made["foreign recording"] = folder / "run.mcap", folder / "other.mcap"
    content = recording().read_bytes()
    made["recording"].write_bytes(content)
    made["foreign recording"].write_bytes(content[:200].replace(b"bt-mission", b"libmcap__0"))
    return made


def test_every_kind_is_recognized(files: dict[str, Path]) -> None:
    """By its content or its name."""
    assert {kind: format_of(path) for kind, path in files.items()} == {
        kind: kind for kind in (*FORMATS, *brought_kinds(rows()))
    }


def test_what_no_kind_has_is_left_to_the_command(tmp_path: Path) -> None:
    """Nothing is guessed."""
    for name, text in {"a.yaml": "a: 1\n", "b.txt": "b", "c.xml": "<c/>", "d": ""}.items():
        (tmp_path / name).write_text(text)
        assert format_of(tmp_path / name) is None
    assert format_of(tmp_path) is None
    assert format_of(tmp_path / "absent.mcap") is None


def commands() -> Iterator[tuple[str, Command]]:
    """Yield every command with its words."""
    waiting = [(row.name, declared(row)) for row in ROWS if row.help]
    while waiting:
        words, command = waiting.pop()
        if command.function is not None:
            yield words, command
        waiting += [(f"{words} {name}", below) for name, below in command.commands.items()]


READ = [(words, command, option) for words, command in commands() for option in command.options]
TAKERS = [row for row in READ if row[2].takes]
UNATTENDED = [row for row in TAKERS if row[0] not in cases("SERVED_UNTIL_CTRL_C")]


def test_every_option_that_names_a_file_says_which_kinds_it_takes() -> None:
    """`check` looks at each file by itself; the robot of a recording is a name in it."""
    lacking = [
        f"{words} {option.form}"
        for words, _, option in READ
        if not option.takes
        and (
            (isinstance(option.type, FileType) and option.type.role == "input")
            or option.completes in ("missions", "runs", "worlds", "robots", "parameters")
        )
    ]
    of_recordings = [f"{name} --robot NAME" for name in ("replay", "report", "verify")]
    assert (
        sorted(set(lacking) - {*of_recordings, *cases("NAMES_IN_RECORDINGS"), "check files file"})
        == []
    )


@pytest.mark.parametrize(
    ("words", "command", "option"),
    sample(TAKERS, 15),
    ids=[f"{row[0]} {row[2].name}" for row in TAKERS],
)
def test_a_command_refuses_every_other_kind(
    cli: CommandLine, files: dict[str, Path], words: str, command: Command, option: Option
) -> None:
    """With what the file is and what takes it; a bag's folder stands for its recording."""
    for kind, path in files.items():
        if kind in option.takes:
            continue
        line = line_with(words, command, option, path, files)
        assert cli.call(line) == 2, (line, cli.out)
        if kind == "bag folder" and "recording" in option.takes:
            assert "the bag has no MCAP file; convert it: " in cli.err
        else:
            assert cli.err.startswith(f"{path}: error: is {format_named(kind).noun}; expected ")
            assert cli.err.rstrip().endswith("[BT-111]")


def line_with(
    words: str, command: Command, option: Option, path: Path | str, files: dict[str, Path]
) -> str:
    """Return the line of a command with a path for one of its options, and valid other words."""
    line = [words]
    for other in command.options:
        if other.flags:
            continue
        if other.form == option.form:
            line.append(str(path))
        elif other.nargs not in ("?", "*"):
            valid = VALID.get(other.attribute, "run.mcap")
            line.append(str(files["recording"]) if "recording" in other.takes else valid)
    return " ".join([*line, f"{option.name} {path}"] if option.flags else line)


@pytest.mark.parametrize(
    ("words", "command", "option"),
    sample(UNATTENDED, 20),
    ids=[f"{row[0]} {row[2].name}" for row in UNATTENDED],
)
@pytest.mark.parametrize("path", [".", "/", ".."])
def test_a_command_refuses_a_folder_without_a_name(
    cli: CommandLine,
    files: dict[str, Path],
    words: str,
    command: Command,
    option: Option,
    path: str,
) -> None:
    """Which has no suffix to exchange either."""
    assert cli.call(line_with(words, command, option, path, files)) == 2, cli.out + cli.err


@pytest.mark.parametrize(
    "kind", [kind for kind in FORMATS if kind not in TEXTS or kind in ("map", "urdf")]
)
def test_check_reports_each_file_by_itself(
    cli: CommandLine, files: dict[str, Path], kind: str
) -> None:
    """Among others, and as JSON."""
    assert cli.call(f"check {files[kind]} {files['mission']}") == 2
    assert f"is {FORMATS[kind].noun}; expected a mission" in cli.err
    assert "1 of 2 files are valid" in cli.out
    (diagnostic,) = json.loads(cli(f"check --json {files[kind]}", code=2))
    assert diagnostic["code"] == "BT-111"


def test_a_file_that_a_mission_names_is_recognized_too(cli: CommandLine) -> None:
    """Its world and its robot."""
    cli.write("map.yaml", TEXTS["map"][1])
    for key, kind in (("world", "world"), ("robot", "robot")):
        mission = cli.write("m.yaml", f"mission: m\n{key}: map.yaml\ntree:\n  wait: 1\n")
        assert cli.call(f"check {mission}") == 2
        assert f"is a map of map_server; expected a {kind}; a world has walls" in cli.err


def test_the_folder_of_a_bag_stands_for_its_recording(cli: CommandLine) -> None:
    """Where it has one; of several, one is named."""
    bag = cli.folder / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text(TEXTS["bag metadata"][1])
    (bag / "bag_0.mcap").write_bytes(recording().read_bytes())
    cli("report bag -o page.html")
    assert cli("replay bag --once").startswith("there and back ")
    assert "slow: holds" in cli("verify bag --require " + cli.write("mine.yaml", MISSION))
    assert cli("diff bag/bag_0.mcap bag/bag_0.mcap").startswith("the same ")
    (bag / "bag_1.mcap").write_bytes(b"")
    assert cli.call("replay bag --once") == 2
    assert "the bag has 2 recordings (bag_0.mcap, bag_1.mcap); name one of them" in cli.err


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("mine.yaml", "it is a file: use `bt-mission run mine.yaml`"),
        ("absent.yaml", "it is a file: use `bt-mission run absent.yaml`"),
        ("server.py", "name its class in a mission, as server.py:CLASS"),
        ("run --mission mine.yaml", "give the file alone: bt-mission run FILE"),
    ],
)
def test_a_file_in_a_wrong_place_leads_to_the_right_one(
    cli: CommandLine, line: str, words: str
) -> None:
    """Without a command, or behind an option that is a guess."""
    cli.write("mine.yaml", MISSION)
    cli.write("server.py", "")
    assert cli.call(line) == 2
    assert words in cli.err


def test_each_line_of_examples_is_one_command() -> None:
    """None was wrapped by hand into the next one."""
    programs = ("bt-mission ", "ros2 ", "cd ", "pytest", "python ", "source ", "eval ")
    for words, command in commands():
        examples = command.epilog.partition("examples:\n")[2].partition("\n\n")[0]
        for example in examples.splitlines():
            line = example.strip()
            assert line.startswith(programs) or example.startswith("   "), (words, line)
