"""The layers of the packages (docs/explanation/architecture.md), read from the sources."""

import ast
import fnmatch
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.project import ROOT
from tools import check_layers
from tools.check_layers import SPEAKS_ROS, TOPS, Import, is_in

MAX_LINES = 350
ROS_NAMES = ("rclpy", "rosidl_*", "unique_identifier_msgs", "*_msgs", "*_srvs", "*_interfaces")
WALL_CLOCK = "bt_mission.core.wall_clock"
"""The one module that reads the wall clock: it paces live runs."""

WALL_CLOCK_NAMES = (
    "time.time",
    "time.time_ns",
    "time.monotonic",
    "time.monotonic_ns",
    "time.perf_counter",
    "time.perf_counter_ns",
    "time.sleep",
    "asyncio.sleep",
    "datetime.datetime.now",
    "datetime.datetime.today",
    "datetime.datetime.utcnow",
    "datetime.date.today",
    "py_trees.decorators.Timeout",
    "py_trees.timers",
    "py_trees.timers.*",
    "*.tick_tock",
)

KNOWN = check_layers.modules()


def _imports(text: str) -> Iterator[str]:
    yield from (name for name, _ in check_layers.imported_names(ast.parse(text)))


def _dotted_names(text: str) -> Iterator[str]:
    """Each dotted name that is read, with local names replaced by what they were imported as."""
    tree = ast.parse(text)
    bound: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            bound |= {alias.asname: alias.name for alias in node.names if alias.asname}
        elif isinstance(node, ast.ImportFrom) and node.module:
            bound |= {one.asname or one.name: f"{node.module}.{one.name}" for one in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            first, dot, rest = ast.unparse(node).partition(".")
            yield bound.get(first, first) + dot + rest
    yield from _imports(text)


def faults(name: str, text: str) -> list[str]:
    """What breaks the rules in the module of this name, one line each."""
    found = []
    if text.count("\n") > MAX_LINES:
        found.append(f"{name}: {text.count(chr(10))} lines, at most {MAX_LINES}")
    imports = check_layers.imports_of(name, text, {**KNOWN, name: Path()})
    found += check_layers.upward(imports)
    if not any(is_in(name, package) for package in SPEAKS_ROS):
        found += [
            f"{name}: imports {one}: it is not among SPEAKS_ROS of tools/check_layers.py"
            for one in _imports(text)
            if any(fnmatch.fnmatchcase(one.partition(".")[0], pattern) for pattern in ROS_NAMES)
        ]
    if name != WALL_CLOCK:
        found += [
            f"{name}: {one} reads the wall clock; use the node's ROS clock"
            for one in _dotted_names(text)
            if any(fnmatch.fnmatchcase(one, pattern) for pattern in WALL_CLOCK_NAMES)
        ]
    return found


@pytest.mark.parametrize("name", KNOWN)
def test_every_module_keeps_the_rules(name):
    """No module imports upwards, speaks ROS where it may not, or reads the wall clock."""
    assert faults(name, KNOWN[name].read_text(encoding="utf-8")) == []


def test_no_modules_import_each_other():
    """There is no cycle of imports, those for annotations and inside functions included."""
    assert check_layers.cycles(check_layers.all_imports()) == []


def test_the_root_of_the_package_holds_folders():
    """Every module of bt_mission lies in a package, but for the two that Python asks for."""
    files = {path.name for path in (ROOT / "bt_mission").glob("*.py")}
    assert files == {"__init__.py", "__main__.py"}


def test_no_test_file_is_too_long():
    """Tests are held to the same length as what they test."""
    lengths = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8").count("\n")
        for path in (ROOT / "tests").rglob("*.py")
    }
    assert {path: lines for path, lines in lengths.items() if lines > MAX_LINES} == {}


@pytest.mark.parametrize("name", SPEAKS_ROS)
def test_what_may_speak_ros_is_there(name):
    """A package that is renamed or removed takes its permission with it."""
    assert name in KNOWN


def test_the_tool_says_what_it_found(capsys):
    """The tool prints layers, cycles and upward imports, and ends with 0 where all is well."""
    assert check_layers.main() == 0
    said = capsys.readouterr().out
    assert "layer 0: bt_mission.core" in said
    assert "0 cycles" in said
    assert "0 upward imports" in said


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("sim.world.world", "import action_servers.core.pilot\n", "imports of bt_mission only"),
        ("sim.world.world", "from bt_mission.goals.goal import Goal\n", "only bt_mission.core"),
        ("sim.world.world", "from sim.ros.node import SimNode\n", "part 0 imports part 6"),
        ("sim.world.world", "from rclpy.node import Node\n", "SPEAKS_ROS"),
        ("action_servers.core.pilot", "def f():\n    import sim.world\n", "imports of bt_mission"),
        (
            "action_servers.core.pilot",
            "import action_servers.server.node\n",
            "part 0 imports part 3",
        ),
        ("bt_mission.core.text", "import bt_mission.goals.goal\n", "layer 0 imports layer 0"),
        ("bt_mission.ros.graph", "from bt_mission.cli import run\n", "layer 4 imports layer 8"),
        ("bt_mission.new.room", "from bt_mission.cli import run\n", "a package without a layer"),
        ("bt_mission.executive.trace", "import sim.world.world\n", "import servers and simulator"),
        ("bt_mission.executive.trace", "import nav2_msgs.action\n", "SPEAKS_ROS"),
        ("bt_mission.sessions.stage", "import time\ntime.monotonic()\n", "time.monotonic reads"),
        ("bt_mission.core.text", "import time as t\nt.sleep(1)\n", "time.sleep reads the wall"),
        ("sim.ros.node", "from datetime import datetime\ndatetime.now()\n", "datetime.now reads"),
        ("bt_mission.core.text", "from py_trees.decorators import Timeout\n", "Timeout reads"),
        ("bt_mission.core.text", "def run(tree):\n    tree.tick_tock(100)\n", "tick_tock reads"),
        ("bt_mission.core.text", "x = 1\n" * (MAX_LINES + 1), "at most"),
    ],
)
def test_a_violation_is_found(name, text, expected):
    """Each rule, broken by a small invented module, is reported with its place and its reason."""
    found = faults(name, text)
    assert found, "nothing was found"
    assert all(line.startswith(name) for line in found)
    assert any(expected in line for line in found)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("sim.ros.node", "import rclpy\nfrom sim.world.world import World\n"),
        ("sim.world.world", "import mujoco\nfrom bt_mission.core.errors import BtMissionError\n"),
        ("bt_mission.sessions.stage", "import rclpy\nfrom sim.ros.node import SimNode\n"),
        ("bt_mission.core.wall_clock", "import time\nnow = time.monotonic\n"),
        ("bt_mission.cli.run", "import action_servers.server.node\n"),
        ("bt_mission.executive.trace", "from py_trees.composites import Sequence\nimport time\n"),
    ],
)
def test_what_is_allowed_is_not_reported(name, text):
    """The rules do not cry wolf."""
    assert faults(name, text) == []


def test_a_cycle_is_found():
    """Three modules that import each other in a ring are one cycle."""
    ring = [Import("sim.a", "sim.b", 1), Import("sim.b", "sim.c", 1), Import("sim.c", "sim.a", 1)]
    assert check_layers.cycles([*ring, Import("sim.d", "sim.a", 1)]) == [
        ["sim.a", "sim.b", "sim.c"]
    ]


def test_every_top_level_package_is_read():
    """Modules of all three packages are among those that are checked."""
    assert {name.partition(".")[0] for name in KNOWN} == set(TOPS)
