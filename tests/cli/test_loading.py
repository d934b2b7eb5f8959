"""What a command loads before it does anything, and the process that has loaded it beforehand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from pydantic import BaseModel

from bt_mission.base.commands import ROWS
from tests.support.command_line import CommandLine
from tests.support.transcripts import assert_written

pytestmark = pytest.mark.process

HEAVY = {"rclpy", "mujoco", "numpy", "scipy", "cv2", "PIL", "pydantic", "yaml", "py_trees", "rich"}
LOADED = Path(__file__).with_name("loaded")
OURS = {"bt_mission", "action_servers", "sim"}
RARE = {"asyncio", "difflib", "multiprocessing", "sqlite3", "subprocess", "xml.etree.ElementTree"}
LISTED = """\
import atexit
first = {*sys.modules}
atexit.register(lambda: print(json.dumps(sorted({*sys.modules} - first)), file=told))
"""
AT_THE_FIRST_LINE = """\
class Terminal:
    encoding = "utf-8"
    def isatty(self):
        return True
    def write(self, text):
        print(json.dumps([text, *sys.modules]), file=told, flush=True)
        os._exit(0)
    def flush(self):
        pass
sys.stderr = Terminal()
"""
MISSION = "mission: short\nworld: empty_arena\ntree: {wait: 0.1}\n"


def loaded(folder: Path, before: str, *words: str) -> list[str]:
    """What a command tells of the modules that are loaded; `before` runs before it."""
    reported = folder / "told.json"
    program = (
        f"import json, os, sys; sys.path[:0] = {sys.path!r}; told = open({str(reported)!r}, 'w')\n"
        f"sys.argv = {['bt-mission', *words]!r}\n{before}"
        "from bt_mission.cli import main\nsys.exit(main())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONHASHSEED": "0"},
    )
    assert (done.returncode, done.stderr) == (0, "")
    data: list[str] = json.loads(reported.read_text())
    return data


def of_packages(modules: list[str]) -> set[str]:
    """The top-level packages of modules."""
    return {name.partition(".")[0] for name in modules}


def commands_in(modules: list[str]) -> set[str]:
    """The modules of commands that are loaded."""
    return {row.declared_in for row in ROWS if row.help} & set(modules)


def test_help_loads_no_command(tmp_path: Path) -> None:
    """The list of commands has their help."""
    modules = loaded(tmp_path, LISTED, "--help")
    assert commands_in(modules) == set()
    assert of_packages(modules).isdisjoint(HEAVY)


def test_names_for_completion_load_their_command_alone(tmp_path: Path) -> None:
    """A shell asks for them while somebody types."""
    modules = loaded(tmp_path, LISTED, "completion", "--names", "runs")
    assert commands_in(modules) == {"bt_mission.commands.completion"}
    assert of_packages(modules).isdisjoint(HEAVY)


@pytest.mark.process(always=True)
def test_the_parsers_of_all_commands_load_neither_ros_nor_the_simulation(tmp_path: Path) -> None:
    """Nor anything else that takes long. They are in the order in which they are listed."""
    program = (
        f"import json, sys; sys.path[:0] = {sys.path!r}\n"
        "from bt_mission.cli.subparsers import load_commands\n"
        "from bt_mission.cli.main import make_parser\n"
        "commands = load_commands(make_parser()).choices\n"
        "helps = [command.format_help().split()[2] for command in commands.values()]\n"
        "print(json.dumps([helps, [*sys.modules]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    names, modules = json.loads(done.stdout)
    assert names == [row.name for row in ROWS if row.help]
    assert of_packages(modules).isdisjoint(HEAVY)


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("run", "explore"), "explore in dqn_stage4: starting ..."),
        (("run", "explore", "--world", "empty_arena"), "explore in empty_arena: starting ..."),
        (("run", "short.yaml"), "short in empty_arena: starting ..."),
        (("run", "explore", "--attach"), "explore: joining the ROS graph ..."),
        (("run", "odd.yaml"), "odd.yaml: starting ..."),
        (("run", "nowhere"), "nowhere: starting ..."),
        (("run", "scene.yaml"), "wall in front in nav_arena: starting ..."),
    ],
)
def test_the_first_line_comes_before_everything(
    tmp_path: Path, words: tuple[str, ...], line: str
) -> None:
    """It says what starts and where, as far as a first look at the file tells."""
    (tmp_path / "short.yaml").write_text(MISSION)
    (tmp_path / "odd.yaml").write_text("mission: $(x) y\n")
    (tmp_path / "scene.yaml").write_text("scenario: wall in front # once\nworld: nav_arena\n")
    text, *modules = loaded(tmp_path, AT_THE_FIRST_LINE, *words)
    assert text == line
    assert of_packages(modules).isdisjoint(HEAVY)
    assert commands_in(modules) <= {"bt_mission.commands.run", "bt_mission.commands.check"}


@pytest.mark.process(always=True)
@pytest.mark.parametrize("command", ["check", "tree"])
def test_what_runs_nothing_loads_these_modules(tmp_path: Path, command: str) -> None:
    """Ours, and packages of others: no simulation, trees, ROS itself or NumPy.

    Of ROS there are the types of goals, which are only Python classes. Write the lists with
    WRITE_TRANSCRIPTS=1. A module that is new in them costs each user of the command its time.
    """
    modules = set(loaded(tmp_path, LISTED, command, "explore"))
    others = {
        name
        for name in of_packages([*modules]) - sys.stdlib_module_names
        if not name.startswith(("_", "cython"))  # parts of compiled modules
    }
    ours = {name for name in modules if name.partition(".")[0] in OURS}
    assert modules.isdisjoint(RARE)
    assert others.isdisjoint(HEAVY - {"pydantic", "yaml"})
    lines = "\n".join([*sorted(others - OURS), *sorted(ours)])
    assert_written(LOADED / f"{command}.txt", f"{lines}\n")


@pytest.mark.process(always=True)
def test_modules_of_models_that_check_loads_evaluate_their_annotations() -> None:
    """Postponed ones are texts, which pydantic evaluates again for each subclass of a model."""

    def below(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
        for each in model.__subclasses__():
            yield each
            yield from below(each)

    names = (LOADED / "check.txt").read_text(encoding="utf-8").split()
    modules = {name: import_module(name) for name in names if name.partition(".")[0] in OURS}
    models = {each.__module__ for each in below(BaseModel)} & modules.keys()
    assert {"bt_mission.language.nodes.action", "bt_mission.robots.drives"} <= models
    assert [name for name in sorted(models) if hasattr(modules[name], "annotations")] == []


@pytest.mark.thorough
def test_a_run_loads_what_its_mission_needs(tmp_path: Path) -> None:
    """Not what others compute paths and pictures with, nor what draws or reads XML."""
    (tmp_path / "short.yaml").write_text(MISSION)
    modules = loaded(tmp_path, LISTED, "run", "short.yaml", "--json")
    assert {"rclpy", "mujoco", "py_trees"} <= of_packages(modules)
    assert of_packages(modules).isdisjoint({"scipy", "cv2", "PIL", "rich", "textual"})
    adding = {row.folder for row in ROWS if row.adds.keys() & {"show", "recording"}}
    commands = {".".join(name.split(".")[:3]) for name in modules if "on.commands." in name}
    assert commands == {"bt_mission.commands.run", *adding}


@pytest.mark.thorough
def test_a_ready_process_runs_as_a_new_one_does(cli: CommandLine) -> None:
    """The run with which it got ready leaves nothing in the trace and in the outputs."""
    cli.write("turns.yaml", "mission: turns\ntree: {turn: {angle: 45}, timeout: 20}\n")
    run = "run turns.yaml --json --trace"
    done = subprocess.run(
        [sys.executable, "-m", "bt_mission.cli.preloaded"],
        input=json.dumps([*run.split(), "ready.jsonl"]) + "\n",
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["status"] == "success"
    assert done.stderr == ""
    cli(f"{run} new.jsonl")
    assert Path("ready.jsonl").read_text() == Path("new.jsonl").read_text()
